#include <algorithm>
#include <limits>

#include "codec/lattice_file.h"
#include "codec/raster_body.h"

namespace relief::codec {

namespace {

using multires::Planes;

/// Closed-loop files: control coefficients are samples.
class LatticeBody final : public RasterBody {
  public:
    LatticeBody(const ContainerReader& container, const RasterHeader& header,
                const multires::PyramidLayout& layout, std::unique_ptr<LatticeFile> file)
        : container_(container), header_(header), layout_(layout), file_(std::move(file)) {}

    Result<BodySamples> samples(int level, const LatticeBox& window) const override {
        RELIEF_TRY(LatticeWindow part, file_->read(level, window));
        BodySamples samples;
        samples.planes = std::move(part.planes);
        samples.stored = true;
        samples.mask = std::move(part.mask);
        samples.bound = part.known_level <= level ? exact_bound() : part.bound;
        samples.damaged = std::move(part.damaged);
        return samples;
    }

    /// What the file has at holes is an interpolation.
    Result<ControlPart> coefficients(int level, const LatticeBox& part) const override {
        RELIEF_TRY(LatticeWindow window, file_->read(level, part, true));
        return ControlPart{
            {part, std::move(window.planes)}, std::move(window.mask), std::move(window.damaged)};
    }

    Result<Planes<double>> control_net() const override {
        RELIEF_TRY(auto finest, coefficients(0, {0, 0, layout_.rows, layout_.cols}));
        return std::move(finest.net.planes);
    }

    bool decodes_parts() const override { return true; }

    int finest_level() const override {
        const std::size_t complete = container_.complete_chunks();
        int level = 0;
        while (level < layout_.levels() && file_->chunks().end_of_level(level) > complete) ++level;
        return level;
    }

    double bound(int level) const override {
        return finest_level() <= level ? exact_bound() : surface_bound(level);
    }

    double surface_bound(int level) const override {
        level = std::max(level, finest_level());
        if (level == 0) return exact_bound();
        // All tiles of the level's tier end with a chunk that has it.
        const int tier = file_->tree().tier_of(level);
        const auto& ranges = file_->chunks().ranges(tier);
        std::size_t k = 0;
        while (k + 1 < ranges.size() && ranges[k].last > level) ++k;
        double largest = 0;
        for (std::int64_t tile = 0; tile < file_->tree().tier(tier).tiles(); ++tile)
            largest =
                std::max(largest, container_.chunks()[file_->chunks().chunk(tier, k, tile)].bound);
        return largest;
    }

    std::uint64_t bytes_for(int level) const override {
        const std::size_t end =
            std::min(file_->chunks().end_of_level(level), container_.complete_chunks());
        const ChunkInfo& last = container_.chunks()[end - 1];
        return last.offset + last.length;
    }

    std::vector<double> band_steps() const override {
        std::vector<double> steps;
        const int finest = finest_level();
        for (const multires::BandLayout& band : layout_.bands) {
            const int level = band.channel == 0 ? band.level : band.level - 1;
            const LatticeCoding& coding = file_->coding();
            const bool known = level >= finest;
            steps.push_back(known ? coding.step(0, level) * coding.domains[0].unit : 0);
        }
        return steps;
    }

    std::vector<ChunkSummary> chunks() const override {
        std::vector<ChunkSummary> all;
        const TileTree& tree = file_->tree();
        for (int tier = tree.tiers() - 1; tier >= 0; --tier) {
            const auto& ranges = file_->chunks().ranges(tier);
            for (std::size_t k = 0; k < ranges.size(); ++k) {
                ChunkSummary& sum = all.emplace_back();
                sum.kind = "lattice";
                sum.level = ranges[k].last;
                sum.count = tree.tier(tier).tiles();
                for (std::int64_t tile = 0; tile < sum.count; ++tile) {
                    const ChunkInfo& chunk =
                        container_.chunks()[file_->chunks().chunk(tier, k, tile)];
                    sum.bytes += chunk.length;
                    sum.max_error = std::max(sum.max_error, chunk.bound);
                }
            }
        }
        return all;
    }

  private:
    /// What the file promises of all samples that it codes.
    [[nodiscard]] double exact_bound() const {
        return header_.goal.kind == Goal::Kind::MaxError ? header_.goal.value : header_.max_error;
    }

    const ContainerReader& container_;
    const RasterHeader& header_;
    const multires::PyramidLayout& layout_;
    std::unique_ptr<LatticeFile> file_;
};

}  // namespace

Result<std::unique_ptr<RasterBody>> open_lattice_body(const ContainerReader& container,
                                                      const RasterHeader& header,
                                                      const multires::PyramidLayout& layout) {
    LatticeCoding coding = *header.lattice;
    RELIEF_TRY(auto file, LatticeFile::open(container, kEditsChunk + 1, std::move(coding),
                                            header.lattice_rows(), header.lattice_cols()));
    if (!container.complete(kEditsChunk + 1))
        return Error{ErrorCode::BadFile,
                     "not even the coarsest level is inside the bytes given; give more of the file",
                     ""};
    return std::unique_ptr<RasterBody>(
        std::make_unique<LatticeBody>(container, header, layout, std::move(file)));
}

}  // namespace relief::codec
