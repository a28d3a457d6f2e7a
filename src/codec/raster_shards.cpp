#include "relief/codec/raster_shards.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>

#include "codec/lattice_encode.h"
#include "codec/lattice_file.h"
#include "codec/lattice_margin.h"
#include "codec/little_endian.h"
#include "codec/raster_encode.h"
#include "codec/shard_header.h"
#include "relief/core/parallel.h"

namespace relief::codec {

namespace {

/// The chunk of edits, which shards do not have, stands first as in raster files.
constexpr std::size_t kFirstChunk = 1;

/// The chunks of a file, most of which a shard leaves empty.
class ShardWriter {
  public:
    explicit ShardWriter(ShardHeader header)
        : header_(std::move(header)),
          tree_(header_.raster.lattice_rows(), header_.raster.lattice_cols()),
          places_(tree_, kFirstChunk),
          chunks_(places_.end()) {}

    [[nodiscard]] const TileTree& tree() const { return tree_; }

    void put(int tier, std::int64_t tile, const std::vector<Bytes>& chunks) {
        for (std::size_t range = 0; range < chunks.size(); ++range)
            chunks_[places_.chunk(tier, range, tile)] = chunks[range];
    }
    void put_finest(std::int64_t number, const EncodedTile& tile) {
        put(0, number, tile.chunks);
        header_.tiles.push_back({number, summary_of(tile)});
    }
    Status write(ByteSink& sink) {
        std::sort(header_.tiles.begin(), header_.tiles.end(),
                  [](const auto& a, const auto& b) { return a.number < b.number; });
        ContainerWriter container;
        for (const Bytes& chunk : chunks_) container.add(chunk);
        RELIEF_TRY(const Bytes bytes, container.finish(write_shard_header(header_)));
        return sink.write(bytes);
    }

  private:
    ShardHeader header_;
    TileTree tree_;
    LatticeChunks places_;
    std::vector<Bytes> chunks_;
};

/// An open shard, whose bytes have their checksums.
struct Shard {
    ContainerReader container;
    ShardHeader header;
    std::uint32_t checksum = 0;  ///< of the head, and so of all

    [[nodiscard]] TileTree tree() const {
        return {header.raster.lattice_rows(), header.raster.lattice_cols()};
    }
};

std::uint64_t chunk_count(const TileTree& tree) {
    std::uint64_t count = kFirstChunk;
    for (int k = 0; k < tree.tiers(); ++k)
        count += static_cast<std::uint64_t>(tree.tier(k).tiles()) * chunk_ranges(tree, k).size();
    return count;
}

Result<Shard> open_shard(const std::shared_ptr<const ByteSource>& source) {
    RELIEF_TRY(ContainerReader container, ContainerReader::open(source));
    RELIEF_TRY(ShardHeader header, read_shard_header(container.header()));
    Shard shard{std::move(container), std::move(header)};
    const ContainerReader& reader = shard.container;
    // Before anything of its size is allocated: each tile has chunks.
    if (reader.chunks().size() != chunk_count(shard.tree()))
        return Error{ErrorCode::BadFile, "has not the chunks that its size calls for", "directory"};
    if (reader.complete_chunks() != reader.chunks().size() || !reader.checksums_ok())
        return Error{ErrorCode::BadFile, "is cut off or damaged; make it anew", "chunks"};
    std::array<std::uint8_t, 4> last{};
    RELIEF_CHECK(source->read(reader.head_size() - last.size(), last));
    shard.checksum = load<std::uint32_t>(last.data());
    return shard;
}

Error unsupported(const char* what) {
    return {ErrorCode::Unsupported, std::string(what) + ": such files are encoded in one process",
            ""};
}

}  // namespace

Status plan_raster(const RasterSource& source, const EncodeOptions& options, ByteSink& sink) {
    RELIEF_CHECK(check_raster(source, options.goal));
    if (!is_bound(options.goal) || (options.spec && options.spec->id != multires::SchemeId::Fvs))
        return unsupported("shards are for max-error and lossless, with scheme fvs");
    const double bound = bound_of(options.goal);
    RELIEF_TRY(const LatticeMargin margin, choose_margin(source));
    const RasterWithMargin lattice(source, margin);
    RELIEF_TRY(const Survey seen, survey(lattice, options.progress));
    LatticeCoding coding;
    coding.profile = options.profile;
    coding.margin = margin;
    RELIEF_TRY(const bool fits, choose_domains(lattice, seen, bound, coding));
    if (!fits) return unsupported("the samples do not fit the integers of the closed loop");
    RELIEF_TRY(const CoarseEncoding coarse,
               encode_coarse_tiers(lattice, seen, std::move(coding),
                                   {options.profile, bound, true, options.progress}));
    const Raster& about = lattice.description();
    ShardWriter plan({.raster = lattice_header(source, options.goal, coarse.coding,
                                               seen.valid != about.rows * about.cols),
                      .valid = seen.valid});
    for (std::size_t k = 0; k < coarse.chunks.size(); ++k)
        for (std::size_t tile = 0; tile < coarse.chunks[k].size(); ++tile)
            plan.put(static_cast<int>(k) + 1, static_cast<std::int64_t>(tile),
                     coarse.chunks[k][tile]);
    for (const auto& [number, tile] : coarse.finest) plan.put_finest(number, tile);
    return plan.write(sink);
}

struct RasterPlan::State {
    Shard shard;
    TileTree tree;
    std::unique_ptr<LatticeFile> file;
    std::vector<std::int64_t> missing;

    [[nodiscard]] const LatticeCoding& coding() const { return *shard.header.raster.lattice; }
    Status check(const RasterSource& source, std::span<const std::int64_t> tiles) const;
    /// A tile of which the samples are in a strip.
    Result<EncodedTile> encode(std::int64_t number, const RasterView& strip,
                               const LatticeBox& strip_box) const;
    /// Encodes tiles of one row of them, whose samples are read together.
    Status encode_row(const RasterSource& lattice, std::span<const std::int64_t> tiles,
                      ShardWriter& writer) const;
};

RasterPlan::RasterPlan(std::unique_ptr<const State> state) : state_(std::move(state)) {}
RasterPlan::RasterPlan(RasterPlan&&) noexcept = default;
RasterPlan& RasterPlan::operator=(RasterPlan&&) noexcept = default;
RasterPlan::~RasterPlan() = default;

Result<RasterPlan> RasterPlan::open(std::shared_ptr<const ByteSource> source) {
    RELIEF_TRY(Shard shard, open_shard(source));
    if (shard.header.plan)
        return Error{ErrorCode::BadInput, "is a shard with tiles, not the plan", ""};
    const TileTree tree = shard.tree();
    auto state = std::make_unique<State>(State{std::move(shard), tree, nullptr, {}});
    RELIEF_TRY(state->file, LatticeFile::open(state->shard.container, kFirstChunk, state->coding(),
                                              tree.tier(0).rows, tree.tier(0).cols));
    auto held = state->shard.header.tiles.begin();
    for (std::int64_t tile = 0; tile < tree.tier(0).tiles(); ++tile) {
        const bool holds = held != state->shard.header.tiles.end() && held->number == tile;
        if (holds)
            ++held;
        else
            state->missing.push_back(tile);
    }
    return RasterPlan(std::move(state));
}

const Raster& RasterPlan::description() const {
    return state_->shard.header.raster.description;
}
int RasterPlan::components() const {
    return state_->shard.header.raster.components;
}
std::int64_t RasterPlan::tile_rows() const {
    return state_->tree.tier(0).tile_rows;
}
std::int64_t RasterPlan::tile_cols() const {
    return state_->tree.tier(0).tile_cols;
}
const std::vector<std::int64_t>& RasterPlan::missing_tiles() const {
    return state_->missing;
}

LatticeBox RasterPlan::samples(std::int64_t tile) const {
    const LatticeMargin margin = state_->coding().margin;
    const LatticeBox box = state_->tree.box(0, tile);
    const LatticeBox all{margin.rows, margin.cols, description().rows, description().cols};
    return relative(intersection(box, all), margin.rows, margin.cols);
}

Status RasterPlan::State::check(const RasterSource& source,
                                std::span<const std::int64_t> tiles) const {
    const Raster& is = source.description();
    const Raster& planned = shard.header.raster.description;
    if (is.rows != planned.rows || is.cols != planned.cols || is.type != planned.type ||
        source.components() != shard.header.raster.components)
        return Error{ErrorCode::BadInput,
                     "the raster has another size, type or number of bands than the planned one",
                     ""};
    std::vector<std::int64_t> sorted(tiles.begin(), tiles.end());
    std::sort(sorted.begin(), sorted.end());
    const bool twice = std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
    if (sorted.empty() || twice ||
        !std::includes(missing.begin(), missing.end(), sorted.begin(), sorted.end()))
        return Error{
            ErrorCode::InvalidArgument,
            "the tiles of a shard are some of those that the plan does not hold, each once", ""};
    return {};
}

Status RasterPlan::State::encode_row(const RasterSource& lattice,
                                     std::span<const std::int64_t> tiles,
                                     ShardWriter& writer) const {
    LatticeBox strip_box = tree.box(0, tiles.front());
    const LatticeBox last = tree.box(0, tiles.back());
    strip_box.cols = last.col0 + last.cols - strip_box.col0;
    Raster room;
    RELIEF_TRY(const RasterView strip, lattice.view(strip_box, room));
    std::vector<EncodedTile> encoded(tiles.size());
    std::vector<Status> failed(tiles.size());
    parallel_for(0, std::ssize(tiles), 1, [&](std::int64_t k, std::int64_t) {
        const auto at = static_cast<std::size_t>(k);
        auto tile = encode(tiles[at], strip, strip_box);
        if (tile.ok())
            encoded[at] = *std::move(tile);
        else
            failed[at] = tile.error();
    });
    for (std::size_t k = 0; k < tiles.size(); ++k) {
        RELIEF_CHECK(failed[k]);
        writer.put_finest(tiles[k], encoded[k]);
    }
    return {};
}

Result<EncodedTile> RasterPlan::State::encode(std::int64_t number, const RasterView& strip,
                                              const LatticeBox& strip_box) const {
    RELIEF_TRY(TileState start, file->start_of_finest(number));
    const LatticeBox box = relative(tree.box(0, number), strip_box.row0, strip_box.col0);
    RELIEF_TRY(
        EncodedTile tile,
        encode_tile(coding(), tree, 0, number, tile_samples(coding(), part_of(strip, box)),
                    std::move(start), bound_of(shard.header.raster.goal), TileCare::Measured));
    tile.state = {};
    return tile;
}

Status encode_shard(const RasterPlan& plan, const RasterSource& source,
                    std::span<const std::int64_t> tiles, const Progress& progress, ByteSink& sink) {
    const RasterPlan::State& state = *plan.state_;
    RELIEF_CHECK(state.check(source, tiles));
    const RasterWithMargin lattice(source, state.coding().margin);
    std::vector<std::int64_t> rest(tiles.begin(), tiles.end());
    std::sort(rest.begin(), rest.end());
    RELIEF_TRY(ShardHeader header, read_shard_header(state.shard.container.header()));
    header.plan = state.shard.checksum;
    header.tiles.clear();
    ShardWriter writer(std::move(header));
    const std::int64_t across = plan.tile_cols();
    for (auto first = rest.begin(); first != rest.end();) {
        const auto end = std::find_if(
            first, rest.end(), [&](std::int64_t t) { return t / across != *first / across; });
        RELIEF_CHECK(state.encode_row(lattice, {first, end}, writer));
        first = end;
        const auto done = static_cast<double>(first - rest.begin());
        if (progress && !progress(done / static_cast<double>(rest.size())))
            return Error{ErrorCode::Cancelled, "encoding was cancelled", ""};
    }
    return writer.write(sink);
}

namespace {

/// The bytes of several shards, one behind the other.
class Concatenated final : public ByteSource {
  public:
    explicit Concatenated(const std::vector<std::shared_ptr<const ByteSource>>& parts)
        : parts_(parts) {
        for (const auto& part : parts_) begins_.push_back(begins_.back() + part->size());
    }
    [[nodiscard]] std::uint64_t begin(std::size_t part) const { return begins_[part]; }
    [[nodiscard]] std::uint64_t size() const override { return begins_.back(); }
    /// Requires: the bytes are of one part.
    Status read(std::uint64_t offset, std::span<std::uint8_t> into) const override {
        const auto after = std::upper_bound(begins_.begin(), begins_.end(), offset);
        const auto part = static_cast<std::size_t>(after - begins_.begin()) - 1;
        return into.empty() ? Status() : parts_[part]->read(offset - begins_[part], into);
    }

  private:
    const std::vector<std::shared_ptr<const ByteSource>>& parts_;
    std::vector<std::uint64_t> begins_{0};
};

class Merger {
  public:
    Merger(const std::vector<std::shared_ptr<const ByteSource>>& sources)
        : sources_(sources), bytes_(sources) {}

    Status open() {
        for (std::size_t k = 0; k < sources_.size(); ++k) {
            auto shard = open_shard(sources_[k]);
            if (!shard.ok()) return named(shard.error(), k);
            if (!shard->header.plan && plan_)
                return named({ErrorCode::BadInput, "is a second plan; there is one for all", ""},
                             k);
            if (!shard->header.plan) plan_ = k;
            shards_.push_back(*std::move(shard));
        }
        if (plan_) return {};
        return Error{ErrorCode::BadInput, "no shard is the plan; add it", ""};
    }

    Result<MergeReport> merge(ByteSink& sink) {
        const Shard& plan = shards_[*plan_];
        const TileTree tree = plan.tree();
        const LatticeChunks places(tree, kFirstChunk);
        RELIEF_TRY(const auto owners, owners_of_tiles(tree));
        LatticeAssembly assembly(tree, true);
        for (int k = tree.tiers() - 1; k > 0; --k)
            for (std::int64_t tile = 0; tile < tree.tier(k).tiles(); ++tile)
                assembly.add_coarse(k, tile, chunks_of(*plan_, places, k, tile));
        for (std::size_t tile = 0; tile < owners.size(); ++tile) {
            const auto& [shard, about] = owners[tile];
            const auto number = static_cast<std::int64_t>(tile);
            assembly.add_finest(number, chunks_of(shard, places, 0, number), *about);
        }
        LatticeEncoding encoding = std::move(assembly).finish();
        encoding.samples = plan.header.valid;
        RasterHeader& header = shards_[*plan_].header.raster;
        set_errors(header, encoding);
        std::vector<SpooledChunk> chunks(kFirstChunk);  // no edits
        chunks.insert(chunks.end(), encoding.chunks.begin(), encoding.chunks.end());
        RELIEF_TRY(const auto file,
                   SpooledFile::create(write_header(header), std::move(chunks), bytes_));
        RELIEF_CHECK(file->copy_to(sink));
        const auto samples = static_cast<double>(header.description.rows * header.description.cols);
        return MergeReport{header.description.rows,
                           header.description.cols,
                           encoding.samples,
                           tree.tier(0).tiles(),
                           file->size(),
                           8 * static_cast<double>(file->size()) / samples,
                           header.max_error,
                           header.rms_error};
    }

  private:
    using Owner = std::pair<std::size_t, const TileSummary*>;  ///< which shard has a tile

    static Error named(Error error, std::size_t shard) {
        error.where =
            "shard " + std::to_string(shard + 1) + (error.where.empty() ? "" : ", " + error.where);
        return error;
    }

    [[nodiscard]] Result<std::vector<Owner>> owners_of_tiles(const TileTree& tree) const {
        const Shard& plan = shards_[*plan_];
        const std::string raster = write_header(plan.header.raster);
        std::vector<Owner> owners(static_cast<std::size_t>(tree.tier(0).tiles()));
        for (std::size_t k = 0; k < shards_.size(); ++k) {
            const ShardHeader& header = shards_[k].header;
            if (header.plan.value_or(plan.checksum) != plan.checksum ||
                write_header(header.raster) != raster)
                return named({ErrorCode::BadInput, "was made by another plan", ""}, k);
            for (const ShardTile& tile : header.tiles) {
                Owner& owner = owners[static_cast<std::size_t>(tile.number)];
                if (owner.second != nullptr)
                    return named({ErrorCode::BadInput,
                                  "has tile " + std::to_string(tile.number) + ", as shard " +
                                      std::to_string(owner.first + 1) + " has; leave one out",
                                  ""},
                                 k);
                owner = {k, &tile.about};
            }
        }
        for (std::size_t tile = 0; tile < owners.size(); ++tile)
            if (owners[tile].second == nullptr)
                return Error{ErrorCode::BadInput,
                             "no shard has tile " + std::to_string(tile) + "; add the one that has",
                             ""};
        return owners;
    }

    [[nodiscard]] std::vector<SpooledChunk> chunks_of(std::size_t shard,
                                                      const LatticeChunks& places, int tier,
                                                      std::int64_t tile) const {
        std::vector<SpooledChunk> chunks;
        for (std::size_t range = 0; range < places.ranges(tier).size(); ++range) {
            ChunkInfo info = shards_[shard].container.chunks()[places.chunk(tier, range, tile)];
            const std::uint64_t place = bytes_.begin(shard) + info.offset;
            info.bound = ChunkInfo{}.bound;
            chunks.push_back({place, info});
        }
        return chunks;
    }

    const std::vector<std::shared_ptr<const ByteSource>>& sources_;
    Concatenated bytes_;
    std::vector<Shard> shards_;
    std::optional<std::size_t> plan_;
};

}  // namespace

Result<MergeReport> merge_shards(const std::vector<std::shared_ptr<const ByteSource>>& shards,
                                 ByteSink& sink) {
    Merger merger(shards);
    RELIEF_CHECK(merger.open());
    return merger.merge(sink);
}

}  // namespace relief::codec
