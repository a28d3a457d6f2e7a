#include <algorithm>
#include <cmath>

#include "codec/bytes.h"
#include "codec/corrections.h"
#include "codec/level_chunks.h"
#include "codec/raster_body.h"
#include "relief/codec/mask_coder.h"
#include "relief/codec/quantise.h"
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

/// Every 2^shift-th sample of a window of a mask's level.
Grid<std::uint8_t> picked(const Grid<std::uint8_t>& mask, int shift, const LatticeBox& window) {
    if (mask.empty()) return {};
    Grid<std::uint8_t> part(window.rows, window.cols);
    for (std::int64_t r = 0; r < window.rows; ++r)
        for (std::int64_t c = 0; c < window.cols; ++c)
            part(r, c) = mask((window.row0 + r) << shift, (window.col0 + c) << shift);
    return part;
}

/// Open-loop files: a pyramid of coefficients, and corrections.
class PyramidBody final : public RasterBody {
  public:
    PyramidBody(const ContainerReader& container, const RasterHeader& header,
                const PyramidLayout& layout)
        : container_(container), header_(header), layout_(layout) {}

    Status open() {
        if (container_.chunks().size() != correction_chunk() + 1)
            return Error{ErrorCode::BadFile,
                         "has not the chunks that its levels call for; the file is damaged",
                         "directory"};
        const auto present = [&](std::size_t k) { return container_.chunks()[k].length > 0; };
        for (int number = 0; number <= layout_.levels(); ++number)
            if (!present(level_chunk(number)))
                return Error{ErrorCode::BadFile, "lacks a level; the file is damaged", "directory"};
        if (!header_.has_mask && present(kMaskChunk))
            return Error{ErrorCode::BadFile,
                         "does not agree with its header about a mask; the file is damaged",
                         "directory"};
        while (complete_levels_ <= layout_.levels() &&
               container_.complete(level_chunk(complete_levels_)))
            ++complete_levels_;
        if (complete_levels_ == 0)
            return Error{
                ErrorCode::BadFile,
                "not even the coarsest level is inside the bytes given; give more of the file", ""};
        if (!header_.has_mask) return {};
        RELIEF_TRY(const Bytes data, container_.chunk(kMaskChunk));
        mask_ = Grid<std::uint8_t>(layout_.rows, layout_.cols);
        return decode_mask(data, mask_.view());
    }

    Result<BodySamples> samples(int level, const LatticeBox& window) const override {
        RELIEF_TRY(Planes<double> planes, corrected_samples(level));
        BodySamples samples;
        for (Grid<double>& plane : planes) {
            if (window.rows != plane.rows() || window.cols != plane.cols()) {
                Grid<double> part(window.rows, window.cols);
                for (std::int64_t r = 0; r < window.rows; ++r)
                    std::copy_n(plane.row(window.row0 + r) + window.col0, window.cols, part.row(r));
                plane = std::move(part);
            }
            samples.planes.push_back(std::move(plane));
        }
        samples.mask = picked(mask_, level, window);
        samples.bound = bound(level);
        return samples;
    }

    Result<LevelCoefficients<double>> coefficients(int level, const LatticeBox&) const override {
        return coefficients(level);
    }

    [[nodiscard]] Result<LevelCoefficients<double>> coefficients(int level) const {
        RELIEF_TRY(Quantised quantised, read_bands(level));
        // Bands that were not read stay empty until zeros are needed for them.
        Pyramid<double> pyramid;
        pyramid.layout = layout_;
        pyramid.bands.resize(layout_.bands.size());
        for (std::size_t k = 0; k < layout_.bands.size(); ++k) {
            const multires::BandLayout& band = layout_.bands[k];
            if (k > 0 && band.level <= level) continue;
            const bool read = k < quantised.values.size() && !quantised.values[k].empty();
            const double step = read ? static_cast<double>(quantised.steps[k]) : 0;
            for (std::size_t c = 0; c < static_cast<std::size_t>(layout_.components); ++c) {
                Grid<double> plane(band.box.rows, band.box.cols);
                for (std::int64_t r = 0; r < band.box.rows; ++r)
                    for (std::int64_t j = 0; j < band.box.cols; ++j)
                        plane(r, j) = read ? quantised.values[k][c](r, j) * step : 0.0;
                pyramid.bands[k].push_back(std::move(plane));
            }
            if (read) quantised.values[k].clear();
        }
        return multires::coefficients(pyramid, level);
    }

    Result<Planes<double>> control_net() const override {
        if (!corrected(0)) {
            RELIEF_TRY(LevelCoefficients<double> finest, coefficients(0));
            return std::move(finest.planes);
        }
        RELIEF_TRY(Planes<double> net, corrected_samples(0));
        const multires::SchemeSpec& spec = layout_.spec;
        const bool interpolates = !multires::samples_are_coefficients(spec);
        for (Grid<double>& plane : net) {
            if (!interpolates) break;
            Grid<double> solved(plane.rows(), plane.cols());
            RELIEF_CHECK(
                spline::interpolate_lattice<double>(spec.order, plane.view(), solved.view()));
            plane = std::move(solved);
        }
        return net;
    }

    int finest_level() const override { return layout_.levels() + 1 - complete_levels_; }

    double bound(int level) const override { return surface_bound(level); }

    double surface_bound(int level) const override {
        if (corrected(level))
            return header_.goal.kind == Goal::Kind::MaxError ? header_.goal.value
                                                             : header_.max_error;
        const int used = std::min(layout_.levels() - level, complete_levels_ - 1);
        if (used == layout_.levels()) return header_.max_error;
        return container_.chunks()[level_chunk(used)].bound;
    }

    std::uint64_t bytes_for(int level) const override {
        const int wanted = std::min(layout_.levels() - level + 1, complete_levels_);
        std::size_t last = level_chunk(wanted - 1);
        if (level == 0 && container_.complete(correction_chunk())) last = correction_chunk();
        return container_.chunks()[last].offset + container_.chunks()[last].length;
    }

    std::vector<double> band_steps() const override {
        std::vector<double> steps(layout_.bands.size(), 0);
        for (int number = 0; number < complete_levels_; ++number) {
            const auto data = container_.chunk(level_chunk(number));
            if (!data.ok()) continue;
            ByteReader in(*data);
            for (std::size_t k = 0; k < layout_.bands.size(); ++k)
                if (chunk_of(layout_, layout_.bands[k]) == number)
                    steps[k] = static_cast<double>(in.f32());
        }
        return steps;
    }

    std::vector<ChunkSummary> chunks() const override {
        std::vector<ChunkSummary> all;
        const auto add = [&](const char* kind, int level, std::size_t k) {
            const ChunkInfo& chunk = container_.chunks()[k];
            if (chunk.length > 0) all.push_back({kind, level, 1, chunk.length, chunk.bound});
        };
        add("mask", 0, kMaskChunk);
        add("scaling", layout_.levels(), level_chunk(0));
        for (int number = 1; number <= layout_.levels(); ++number)
            add("details", layout_.levels() - number + 1, level_chunk(number));
        add("correction", 0, correction_chunk());
        return all;
    }

  private:
    static constexpr std::size_t kMaskChunk = kEditsChunk + 1;
    [[nodiscard]] static std::size_t level_chunk(int number) {
        return kMaskChunk + 1 + static_cast<std::size_t>(number);
    }
    [[nodiscard]] std::size_t correction_chunk() const { return level_chunk(layout_.levels()) + 1; }
    [[nodiscard]] bool corrected(int level) const {
        return level == 0 && container_.chunks()[correction_chunk()].length > 0 &&
               container_.complete(correction_chunk());
    }

    [[nodiscard]] Result<Quantised> read_bands(int level) const {
        Quantised quantised;
        const int wanted = std::min(layout_.levels() - level + 1, complete_levels_);
        for (int number = 0; number < wanted; ++number) {
            RELIEF_TRY(const Bytes data, container_.chunk(level_chunk(number)));
            RELIEF_CHECK(read_level(data, number, layout_, quantised));
        }
        return quantised;
    }

    /// Samples of `level` with corrections, without moves, not rounded.
    [[nodiscard]] Result<Planes<double>> corrected_samples(int level) const {
        RELIEF_TRY(const LevelCoefficients<double> control, coefficients(level));
        Planes<double> planes = multires::samples_of(layout_, control, level);
        if (!corrected(level)) return planes;
        RELIEF_TRY(const Bytes data, container_.chunk(correction_chunk()));
        RELIEF_TRY(const Corrections corrections,
                   read_corrections(data, layout_.rows, layout_.cols, layout_.components));
        apply_corrections(corrections, header_.description.type, header_.description.nodata,
                          planes);
        if (all_finite(planes)) return planes;
        return Error{ErrorCode::BadFile,
                     "the corrections give samples that are not numbers; the file is damaged",
                     "correction chunk"};
    }

    const ContainerReader& container_;
    const RasterHeader& header_;
    const PyramidLayout& layout_;
    Grid<std::uint8_t> mask_;
    int complete_levels_ = 0;  ///< leading level chunks inside the prefix
};

}  // namespace

Result<std::unique_ptr<RasterBody>> open_pyramid_body(const ContainerReader& container,
                                                      const RasterHeader& header,
                                                      const multires::PyramidLayout& layout) {
    auto body = std::make_unique<PyramidBody>(container, header, layout);
    RELIEF_CHECK(body->open());
    return std::unique_ptr<RasterBody>(std::move(body));
}

}  // namespace relief::codec
