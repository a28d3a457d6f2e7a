#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "relief/codec/raster_codec.h"

/// A closed-loop raster file made in parts, by processes that need not know each other: first a
/// plan, which holds the coarse tiers, then shards, each with some tiles of the finest one, then
/// the file of all, whose bytes are those of encode_raster. docs/rasters.md, "In shards";
/// docs/format.md, "Shards".
namespace relief::codec {

/// The first shard. Reads the raster two or three times, but encodes a 64th of it and a few tiles.
/// Goals: max-error and lossless. Options: spec none or `fvs`, the same as spec `fvs` of
/// encode_raster. Errors: those of encode_raster; Unsupported for other goals and schemes, and for
/// samples that do not fit the closed loop's integers.
Status plan_raster(const RasterSource& source, const EncodeOptions& options, ByteSink& sink);

/// A plan that is open, and how the raster is cut into tiles of 256 to 767 samples a side. Several
/// threads may use it.
class RasterPlan {
  public:
    /// Nothing is trusted. Errors: BadFile; Unsupported for what is no shard; BadInput for a shard
    /// that is not the plan.
    [[nodiscard]] static Result<RasterPlan> open(std::shared_ptr<const ByteSource> source);
    RasterPlan(RasterPlan&&) noexcept;
    RasterPlan& operator=(RasterPlan&&) noexcept;
    ~RasterPlan();

    /// As RasterFile::description.
    [[nodiscard]] const Raster& description() const;
    [[nodiscard]] int components() const;
    /// Tiles are numbered row by row.
    [[nodiscard]] std::int64_t tile_rows() const;
    [[nodiscard]] std::int64_t tile_cols() const;
    /// Those that the plan does not hold already, ascending.
    [[nodiscard]] const std::vector<std::int64_t>& missing_tiles() const;
    /// The samples of the raster that a tile is made of. Requires: 0 <= tile < rows x cols of
    /// tiles.
    [[nodiscard]] LatticeBox samples(std::int64_t tile) const;

  private:
    struct State;
    friend Status encode_shard(const RasterPlan& plan, const RasterSource& source,
                               std::span<const std::int64_t> tiles, const Progress& progress,
                               ByteSink& sink);
    explicit RasterPlan(std::unique_ptr<const State> state);
    std::unique_ptr<const State> state_;
};

/// A shard with these tiles. Reads their samples only. The source is the raster that was planned.
/// Errors: InvalidArgument for tiles that do not exist, are named twice or are in the plan;
/// BadInput for a source of another size, type or number of components; those of the source and
/// the sink; Cancelled. Complexity: O(samples of the tiles).
Status encode_shard(const RasterPlan& plan, const RasterSource& source,
                    std::span<const std::int64_t> tiles, const Progress& progress, ByteSink& sink);

/// What the file of all shards is.
struct MergeReport {
    std::int64_t rows = 0;
    std::int64_t cols = 0;
    std::int64_t samples = 0;  ///< valid ones
    std::int64_t tiles = 0;    ///< of the finest tier
    std::uint64_t bytes = 0;
    double bits_per_sample = 0;
    double max_error = 0;
    double rms_error = 0;
};

/// Joins a plan and its shards, in any order, without coding anything anew. Errors: BadFile for
/// damage, naming the shard by its place in the list; BadInput unless there is one plan, all shards
/// are of it, and every tile is in one of them; those of the sink. Complexity: O(bytes), which are
/// read twice.
[[nodiscard]] Result<MergeReport> merge_shards(
    const std::vector<std::shared_ptr<const ByteSource>>& shards, ByteSink& sink);

}  // namespace relief::codec
