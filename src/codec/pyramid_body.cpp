#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "codec/corrections.h"
#include "codec/pyramid_blocks.h"
#include "codec/raster_body.h"
#include "codec/tile_masks.h"
#include "relief/multires/cubic_window.h"
#include "relief/spline/lattice_filters.h"

namespace relief::codec {

namespace {

using multires::LevelCoefficients;
using multires::Planes;
using multires::Pyramid;
using multires::PyramidLayout;

bool all_finite(const Planes<double>& planes) {
    return std::all_of(planes.begin(), planes.end(), [](const Grid<double>& plane) {
        for (std::int64_t r = 0; r < plane.rows(); ++r)
            if (!std::all_of(plane.row(r), plane.row(r) + plane.cols(),
                             [](double v) { return std::isfinite(v); }))
                return false;
        return true;
    });
}

Planes<double> cropped(Planes<double> planes, const LatticeBox& window) {
    for (Grid<double>& plane : planes) {
        if (window.rows == plane.rows() && window.cols == plane.cols()) continue;
        Grid<double> part(window.rows, window.cols);
        for (std::int64_t r = 0; r < window.rows; ++r)
            std::copy_n(plane.row(window.row0 + r) + window.col0, window.cols, part.row(r));
        plane = std::move(part);
    }
    return planes;
}

/// Open-loop files: streams of coefficients, and corrections.
class PyramidBody final : public RasterBody {
  public:
    PyramidBody(const ContainerReader& container, const RasterHeader& header,
                const PyramidLayout& layout)
        : container_(container),
          header_(header),
          layout_(layout),
          layers_(header.pyramid.layers.size()),
          blocks_(container, layout, header.pyramid,
                  kFirstMask + static_cast<std::size_t>(mask_chunks(header, layout))) {
        if (header.has_mask)
            masks_ = std::make_unique<TileMasks>(container, layout.rows, layout.cols, kFirstMask);
    }

    Status open() const {
        if (!container_.complete(blocks_.chunk(0, 0)))
            return Error{
                ErrorCode::BadFile,
                "not even the coarsest level is inside the bytes given; give more of the file", ""};
        return {};
    }

    /// How many chunks a file has. Complexity: O(levels).
    [[nodiscard]] static std::uint64_t chunk_count(const RasterHeader& header,
                                                   const PyramidLayout& layout) {
        return kFirstMask + mask_chunks(header, layout) +
               header.pyramid.layers.size() * StreamLayout::count(layout) + 1;
    }

    Result<BodySamples> samples(int level, const LatticeBox& window) const override {
        BodySamples samples;
        Known known;
        RELIEF_TRY(samples.planes, surface(level, window, known));
        if (corrected(level)) RELIEF_CHECK(correct(window, samples.planes));
        samples.bound = bound_of(level, known.fewest_layers, known.most_layers);
        samples.damaged = std::move(known.damaged);
        if (masks_) samples.mask = masks_->read(level, window, samples.damaged);
        return samples;
    }

    Result<ControlPart> coefficients(int level, const LatticeBox& part) const override {
        Known known;
        ControlPart control;
        if (decodes_parts()) {
            control.net.box = part;
            RELIEF_TRY(control.net.planes, surface(level, part, known));
        } else {
            RELIEF_TRY(control.net, whole(level, known));
        }
        return control;
    }

    Result<Planes<double>> control_net() const override {
        Known known;
        if (!corrected(0)) {
            RELIEF_TRY(LevelCoefficients<double> finest, whole(0, known));
            return std::move(finest.planes);
        }
        const LatticeBox all{0, 0, layout_.rows, layout_.cols};
        RELIEF_TRY(Planes<double> net, surface(0, all, known));
        RELIEF_CHECK(correct(all, net));
        const multires::SchemeSpec& spec = layout_.spec;
        if (multires::samples_are_coefficients(spec)) return net;
        for (Grid<double>& plane : net) {
            Grid<double> solved(plane.rows(), plane.cols());
            RELIEF_CHECK(
                spline::interpolate_lattice<double>(spec.order, plane.view(), solved.view()));
            plane = std::move(solved);
        }
        return net;
    }

    /// Parts of its surfaces depend on parts of its bands.
    bool decodes_parts() const override {
        return layout_.spec.id == multires::SchemeId::Cubic && !layout_.spec.exact;
    }

    int finest_level() const override {
        const auto& groups = blocks_.streams().groups();
        int level = layout_.levels();
        for (const StreamLayout::Group& group : groups) {
            if (!container_.complete(last_chunk(group))) break;
            level = std::max(group.finest - 1, 0);
        }
        return level;
    }

    double bound(int level) const override { return surface_bound(level); }

    double surface_bound(int level) const override {
        const bool whole = container_.complete_chunks() == container_.chunks().size();
        if (level == 0 && whole && header_.goal.kind != Goal::Kind::MaxError)
            return header_.max_error;  // not rounded as in the directory
        if (level >= finest_level()) return bound_of(level, layers_, layers_);
        // Known if the prefix ends with a layer.
        std::size_t layer = 0;
        while (layer < layers_ && container_.complete(blocks_.end_of(layer))) ++layer;
        if (layer == 0) return bound_of(level, 0, layers_);
        bool begun = false;  // chunks that say nothing are always there
        const std::size_t end = container_.complete_chunks();
        for (std::size_t k = blocks_.end_of(layer - 1) + 1; k < end; ++k)
            begun = begun || container_.chunks()[k].length > 0;
        return bound_of(level, layer, begun ? layers_ : layer);
    }

    std::uint64_t bytes_for(int level) const override {
        const StreamLayout& streams = blocks_.streams();
        const StreamLayout::Group& group =
            streams.groups()[streams.group_of_level(std::min(level + 1, layout_.levels()))];
        std::size_t last = last_chunk(group);
        if (level == 0) last = correction_chunk();
        const ChunkInfo& chunk =
            container_.chunks()[std::min(last, container_.complete_chunks() - 1)];
        return chunk.offset + chunk.length;
    }

    std::vector<double> band_steps() const override {
        std::vector<double> steps;
        for (std::size_t k = 0; k < layout_.bands.size(); ++k) {
            const StreamLayout& streams = blocks_.streams();
            const auto& group = streams.groups()[streams.group_of_level(layout_.bands[k].level)];
            const bool there = container_.complete(blocks_.chunk(0, group.first));
            steps.push_back(there ? header_.pyramid.step_of(layout_, k) : 0);
        }
        return steps;
    }

    std::vector<ChunkSummary> chunks() const override {
        std::vector<ChunkSummary> all;
        const auto add = [&](const char* kind, int level, std::size_t first, std::size_t count) {
            ChunkSummary sum{kind, level, 0, 0, 0};
            for (std::size_t k = first; k < first + count; ++k) {
                const ChunkInfo& chunk = container_.chunks()[k];
                sum.bytes += chunk.length;
                sum.count += chunk.length > 0;
                sum.max_error = chunk.bound;
            }
            if (sum.bytes > 0) all.push_back(sum);
        };
        add("mask", 0, kFirstMask, static_cast<std::size_t>(mask_chunks(header_, layout_)));
        const auto& groups = blocks_.streams().groups();
        for (std::size_t layer = 0; layer < layers_; ++layer)
            add("scaling", groups[0].finest, blocks_.chunk(layer, 0), 1);
        for (std::size_t layer = 0; layer < layers_; ++layer)
            for (std::size_t g = 1; g < groups.size(); ++g)
                add("details", groups[g].finest, blocks_.chunk(layer, groups[g].first),
                    groups[g].count);
        add("correction", 0, correction_chunk(), 1);
        return all;
    }

  private:
    static constexpr std::size_t kFirstMask = kEditsChunk + 1;

    [[nodiscard]] static std::uint64_t mask_chunks(const RasterHeader& header,
                                                   const PyramidLayout& layout) {
        return header.has_mask ? TileMasks::chunks(layout.rows, layout.cols) : 0;
    }

    /// What turned out to be known of what was asked for.
    struct Known {
        std::size_t fewest_layers = 0;
        std::size_t most_layers = 0;
        std::vector<LatticeBox> damaged = {};
    };

    [[nodiscard]] std::size_t last_chunk(const StreamLayout::Group& group) const {
        return blocks_.chunk(layers_ - 1, group.first + group.count - 1);
    }
    [[nodiscard]] std::size_t correction_chunk() const { return blocks_.end(); }
    [[nodiscard]] bool corrected(int level) const {
        return level == 0 && container_.chunks()[correction_chunk()].length > 0 &&
               container_.complete(correction_chunk());
    }
    /// Largest error of a surface of `level` of which so many layers are known.
    [[nodiscard]] double bound_of(int level, std::size_t fewest, std::size_t most) const {
        constexpr double unknown = std::numeric_limits<double>::infinity();
        const std::vector<double>& bounds = header_.pyramid.bounds;
        if (fewest == layers_ && level > 0) {
            const auto k = static_cast<std::size_t>(level - 1);
            return bounds.empty() ? unknown : bounds[std::min(k, bounds.size() - 1)];
        }
        const bool whole = corrected(0) || container_.chunks()[correction_chunk()].length == 0;
        if (fewest == layers_ && whole)
            return header_.goal.kind == Goal::Kind::MaxError ? header_.goal.value
                                                             : header_.max_error;
        if (level > 0 || fewest != most || fewest == 0) return unknown;
        return container_.chunks()[blocks_.end_of(fewest - 1)].bound;
    }

    [[nodiscard]] Result<PyramidPart> read(const std::vector<LatticeBox>& boxes,
                                           Known& known) const {
        RELIEF_TRY(PyramidPart part, blocks_.read(boxes));
        known = {part.fewest_layers, part.most_layers, std::move(part.damaged)};
        return part;
    }

    [[nodiscard]] Result<LevelCoefficients<double>> whole(int level, Known& known) const {
        std::vector<LatticeBox> boxes;
        for (const multires::BandLayout& band : layout_.bands)
            boxes.push_back(band.channel > 0 && band.level <= level ? LatticeBox{} : band.box);
        Pyramid<double> pyramid;
        RELIEF_TRY(PyramidPart part, read(boxes, known));
        pyramid.layout = layout_;
        pyramid.bands = std::move(part.bands);
        return multires::coefficients(pyramid, level);
    }

    /// Samples of a window of `level` without corrections and moves, not rounded.
    [[nodiscard]] Result<Planes<double>> surface(int level, const LatticeBox& window,
                                                 Known& known) const {
        if (!decodes_parts()) {
            RELIEF_TRY(const LevelCoefficients<double> control, whole(level, known));
            return cropped(multires::samples_of(layout_, control, level), window);
        }
        const auto boxes = multires::cubic::needed_boxes(layout_, level, window);
        RELIEF_TRY(const PyramidPart part, read(boxes, known));
        return cubic_surface(layout_, level, window, part);
    }

    Status correct(const LatticeBox& window, Planes<double>& planes) const {
        RELIEF_TRY(const auto corrections, corrections_of_file());
        apply_corrections(*corrections, header_.description.type, header_.description.nodata,
                          window, planes);
        if (all_finite(planes)) return {};
        return Error{ErrorCode::BadFile,
                     "the corrections give samples that are not numbers; the file is damaged",
                     "correction chunk"};
    }

    [[nodiscard]] Result<std::shared_ptr<const Corrections>> corrections_of_file() const {
        const std::lock_guard lock(mutex_);
        if (corrections_) return corrections_;
        RELIEF_TRY(const Bytes data, container_.chunk(correction_chunk()));
        RELIEF_TRY(Corrections read,
                   read_corrections(data, layout_.rows, layout_.cols, layout_.components));
        corrections_ = std::make_shared<const Corrections>(std::move(read));
        return corrections_;
    }

    const ContainerReader& container_;
    const RasterHeader& header_;
    const PyramidLayout& layout_;
    std::size_t layers_;
    PyramidBlocks blocks_;
    std::unique_ptr<TileMasks> masks_;
    mutable std::mutex mutex_;
    mutable std::shared_ptr<const Corrections> corrections_;  ///< read when they are first needed
};

}  // namespace

Result<std::unique_ptr<RasterBody>> open_pyramid_body(const ContainerReader& container,
                                                      const RasterHeader& header,
                                                      const multires::PyramidLayout& layout) {
    const PyramidCoding& coding = header.pyramid;
    if (!coding.exponents.empty() && coding.exponents.size() != layout.bands.size())
        return Error{ErrorCode::BadFile, "has not a step for each band; the file is damaged",
                     "header"};
    // Sizes must be believable before anything of their size is allocated: each tile has chunks.
    if (container.chunks().size() != PyramidBody::chunk_count(header, layout))
        return Error{ErrorCode::BadFile,
                     "has not the chunks that its levels call for; the file is damaged",
                     "directory"};
    auto body = std::make_unique<PyramidBody>(container, header, layout);
    RELIEF_CHECK(body->open());
    return std::unique_ptr<RasterBody>(std::move(body));
}

}  // namespace relief::codec
