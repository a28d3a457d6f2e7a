#include "codec/lattice_encode.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <string>

#include "codec/sample_rows.h"
#include "codec/tile_start.h"
#include "relief/core/parallel.h"

namespace relief::codec {

namespace {

/// Coarse levels are worth finer steps below so many bits a sample.
constexpr double kLooseBits = 0.9;
constexpr double kTightening = 1.1;
/// Tiles that are encoded twice to choose.
constexpr std::int64_t kTrialTiles = 4;
/// Tiles that are encoded together, at least: threads that are done early wait for the others.
constexpr std::int64_t kTilesPerThread = 4;

Error cancelled() {
    return {ErrorCode::Cancelled, "encoding was cancelled", ""};
}

std::uint64_t size_of(const EncodedTile& tile) {
    std::uint64_t size = 0;
    for (const Bytes& chunk : tile.chunks) size += chunk.size();
    return size;
}

/// The mask of samples; empty if it has no hole.
Grid<std::uint8_t> mask_of(const RasterView& samples) {
    if (!samples.mask.data) return {};
    Grid<std::uint8_t> valid(samples.rows, samples.cols);
    bool holes = false;
    for (std::int64_t r = 0; r < valid.rows(); ++r) {
        const std::uint8_t* from = samples.mask.row(r);
        std::transform(from, from + valid.cols(), valid.row(r),
                       [](std::uint8_t v) { return static_cast<std::uint8_t>(v != 0); });
        holes = holes || std::memchr(valid.row(r), 0, static_cast<std::size_t>(valid.cols()));
    }
    return holes ? std::move(valid) : Grid<std::uint8_t>();
}

/// Every 8th sample of both axes.
Raster thinned(const Raster& raster) {
    constexpr std::int64_t step = std::int64_t{1} << TileTree::kTierLevels;
    Raster coarse;
    coarse.rows = level_size(raster.rows, TileTree::kTierLevels);
    coarse.cols = level_size(raster.cols, TileTree::kTierLevels);
    const auto pick = [&]<class T>(const Grid<T>& from) {
        Grid<T> to(coarse.rows, coarse.cols);
        for (std::int64_t r = 0; r < to.rows(); ++r)
            for (std::int64_t c = 0; c < to.cols(); ++c) to(r, c) = from(r * step, c * step);
        return to;
    };
    for (const Grid<double>& plane : raster.planes) coarse.planes.push_back(pick(plane));
    if (!raster.mask.empty()) coarse.mask = pick(raster.mask);
    return coarse;
}

/// The tiers above the finest, encoded: their lattices as decoded, and what their coders learnt.
struct CoarseTiers {
    struct Tier {
        std::vector<Grid<std::int32_t>> values;                        ///< one a component
        std::vector<std::vector<std::unique_ptr<LevelCodec>>> learnt;  ///< [tile][component]
        std::vector<std::vector<Bytes>> chunks;                        ///< [tile]
    };
    std::vector<Tier> tiers;  ///< [0] is tier 1
    std::uint64_t size = 0;   ///< of all chunks
};

class Encoder {
  public:
    Encoder(const RasterSource& source, const Survey& seen, LatticeCoding coding,
            const LatticeOptions& options, Spool* spool)
        : source_(source),
          about_(source.description()),
          survey_(seen),
          options_(options),
          spool_(spool),
          coding_(std::move(coding)),
          tree_(about_.rows, about_.cols),
          assembly_(tree_, options.measure_coarse) {
        for (int k = 2; k < tree_.tiers(); ++k) coarser_.push_back(thinned(lattice(k - 1)));
    }

    Result<LatticeEncoding> run() {
        RELIEF_CHECK(choose_tightening());
        for (int k = tree_.tiers() - 1; k > 0; --k)
            for (std::int64_t tile = 0; tile < tree_.tier(k).tiles(); ++tile) {
                RELIEF_TRY(auto chunks,
                           spooled_chunks(coarse_.tiers[static_cast<std::size_t>(k - 1)]
                                              .chunks[static_cast<std::size_t>(tile)]));
                assembly_.add_coarse(k, tile, std::move(chunks));
            }
        RELIEF_CHECK(encode_finest());
        LatticeEncoding result = std::move(assembly_).finish();
        result.coding = std::move(coding_);
        result.samples = survey_.valid;
        result.has_holes = survey_.valid != about_.rows * about_.cols;
        result.coarse_energy = coarse_energy_;
        return result;
    }

    Result<CoarseEncoding> coarse() {
        RELIEF_CHECK(choose_tightening());
        CoarseEncoding result;
        for (CoarseTiers::Tier& tier : coarse_.tiers)
            result.chunks.push_back(std::move(tier.chunks));
        result.coding = std::move(coding_);
        result.finest = std::move(kept_);
        return result;
    }

  private:
    /// The samples of tier k > 0.
    [[nodiscard]] const Raster& lattice(int k) const {
        return k == 1 ? survey_.coarse : coarser_[static_cast<std::size_t>(k - 2)];
    }

    [[nodiscard]] TileState start(const LatticeCoding& coding, const CoarseTiers& coarse, int tier,
                                  std::int64_t tile) const {
        if (tier == tree_.tiers() - 1) return top_state(coding);
        const CoarseTiers::Tier& above = coarse.tiers[static_cast<std::size_t>(tier)];
        const auto fetch = [&](std::size_t component, const LatticeBox& box,
                               GridView<std::int32_t> out) {
            for (std::int64_t r = 0; r < box.rows; ++r)
                std::copy_n(above.values[component].row(box.row0 + r) + box.col0, box.cols,
                            out.row(r));
        };
        return state_below(coding, tree_, tier, tile,
                           above.learnt[static_cast<std::size_t>(tree_.parent(tier, tile))], fetch);
    }

    Result<EncodedTile> encode(const LatticeCoding& coding, const CoarseTiers& coarse, int tier,
                               std::int64_t tile, const TileSamples& samples, TileCare care) const {
        return encode_tile(coding, tree_, tier, tile, samples, start(coding, coarse, tier, tile),
                           options_.bound, care);
    }

    Result<CoarseTiers> encode_coarse(const LatticeCoding& coding) const {
        CoarseTiers coarse;
        coarse.tiers.resize(static_cast<std::size_t>(tree_.tiers() - 1));
        for (int k = tree_.tiers() - 1; k > 0; --k) {
            CoarseTiers::Tier& tier = coarse.tiers[static_cast<std::size_t>(k - 1)];
            const TileTree::Tier& all = tree_.tier(k);
            for (std::size_t c = 0; c < coding.domains.size(); ++c)
                tier.values.emplace_back(all.rows, all.cols);
            tier.learnt.resize(static_cast<std::size_t>(all.tiles()));
            tier.chunks.resize(static_cast<std::size_t>(all.tiles()));
            std::vector<Status> failed(static_cast<std::size_t>(all.tiles()));
            parallel_for(0, all.tiles(), 1, [&](std::int64_t tile, std::int64_t) {
                failed[static_cast<std::size_t>(tile)] =
                    encode_coarse_tile(coding, coarse, k, tile);
            });
            for (const Status& status : failed) RELIEF_CHECK(status);
            for (const auto& chunks : tier.chunks)
                for (const Bytes& chunk : chunks) coarse.size += chunk.size();
        }
        return coarse;
    }

    Status encode_coarse_tile(const LatticeCoding& coding, CoarseTiers& coarse, int k,
                              std::int64_t number) const {
        const LatticeBox box = tree_.box(k, number);
        const TileSamples samples = tile_samples(coding, view_of(lattice(k), box));
        RELIEF_TRY(EncodedTile tile,
                   encode(coding, coarse, k, number, samples, TileCare::Verified));
        CoarseTiers::Tier& tier = coarse.tiers[static_cast<std::size_t>(k - 1)];
        for (std::size_t c = 0; c < tier.values.size(); ++c)
            for (std::int64_t r = 0; r < box.rows; ++r)
                std::copy_n(tile.state.levels[c].values.row(r), box.cols,
                            tier.values[c].row(box.row0 + r) + box.col0);
        tier.learnt[static_cast<std::size_t>(number)] = std::move(tile.state.codecs);
        tier.chunks[static_cast<std::size_t>(number)] = std::move(tile.chunks);
        return {};
    }

    /// Encodes a few tiles to see whether finer steps on coarse levels make the file smaller; they
    /// are kept as they are part of the file.
    Status choose_tightening() {
        LatticeCoding& coding = coding_;
        coding.tightening = 1;
        RELIEF_TRY(coarse_, encode_coarse(coding));
        const bool lossless_steps =
            std::all_of(coding.domains.begin(), coding.domains.end(),
                        [](const IntegerDomain& domain) { return domain.step == 1; });
        if (lossless_steps) return {};
        const std::int64_t tiles = tree_.tier(0).tiles();
        const std::int64_t trials = std::min(kTrialTiles, tiles);
        std::vector<Trial> plain(static_cast<std::size_t>(trials));
        std::int64_t count = 0;
        for (std::int64_t k = 0; k < trials; ++k) {
            Trial& trial = plain[static_cast<std::size_t>(k)];
            trial.number = (2 * k + 1) * tiles / (2 * trials);
            RELIEF_TRY(trial.samples, source_.view(tree_.box(0, trial.number), trial.room));
            count += trial.samples.valid_count() * static_cast<std::int64_t>(coding.domains.size());
        }
        const double tight = kLooseBits / 8 * static_cast<double>(count);
        RELIEF_TRY(const double plain_size, encode_trials(coding, coarse_, plain, tight));
        if (plain_size >= tight) {
            keep(plain);
            return {};
        }
        LatticeCoding tightened = coding;
        tightened.tightening = kTightening;
        RELIEF_TRY(CoarseTiers finer, encode_coarse(tightened));
        std::vector<Trial> fine(plain.size());
        for (std::size_t k = 0; k < plain.size(); ++k)
            fine[k] = {plain[k].number, std::move(plain[k].room), plain[k].samples, {}};
        RELIEF_TRY(double size,
                   encode_trials(tightened, finer, fine, std::numeric_limits<double>::infinity()));
        // Coarse tiers weigh as much as they do in the whole file.
        const double share = static_cast<double>(trials) / static_cast<double>(tiles);
        size += share * static_cast<double>(finer.size);
        const bool pays = size <= 1.002 * (plain_size + share * static_cast<double>(coarse_.size));
        keep(pays ? fine : plain);
        if (!pays) return {};
        coding.tightening = kTightening;
        coarse_ = std::move(finer);
        return {};
    }

    /// A tile that is encoded before the others.
    struct Trial {
        std::int64_t number = 0;
        Raster room;
        RasterView samples;
        std::optional<EncodedTile> tile;
    };

    /// The size of the trial tiles; where it reaches `enough`, perhaps of some of them only.
    Result<double> encode_trials(const LatticeCoding& coding, const CoarseTiers& coarse,
                                 std::vector<Trial>& trials, double enough) const {
        std::vector<Status> failed(trials.size());
        std::atomic<std::uint64_t> size = 0;
        parallel_for(
            0, static_cast<std::int64_t>(trials.size()), 1, [&](std::int64_t k, std::int64_t) {
                if (static_cast<double>(size) >= enough) return;
                Trial& trial = trials[static_cast<std::size_t>(k)];
                auto tile = encode_finest_tile(coding, coarse, trial.number, trial.samples);
                if (!tile.ok()) {
                    failed[static_cast<std::size_t>(k)] = tile.error();
                    return;
                }
                size += size_of(*tile);
                trial.tile = *std::move(tile);
            });
        for (const Status& status : failed) RELIEF_CHECK(status);
        return static_cast<double>(size);
    }

    void keep(std::vector<Trial>& trials) {
        for (Trial& trial : trials)
            if (trial.tile) kept_.emplace(trial.number, *std::move(trial.tile));
    }

    Result<EncodedTile> encode_finest_tile(const LatticeCoding& coding, const CoarseTiers& coarse,
                                           std::int64_t number, const RasterView& samples) const {
        RELIEF_TRY(EncodedTile tile,
                   encode(coding, coarse, 0, number, tile_samples(coding, samples),
                          options_.measure_coarse ? TileCare::Measured : TileCare::Verified));
        tile.state = {};
        return tile;
    }

    /// Rows of tiles, as many at a time as give every thread work.
    Status encode_finest() {
        const TileTree::Tier& tier = tree_.tier(0);
        const std::int64_t together = std::max<std::int64_t>(
            1, (kTilesPerThread * thread_count() + tier.tile_cols - 1) / tier.tile_cols);
        for (std::int64_t row = 0; row < tier.tile_rows; row += together) {
            const std::int64_t rows = std::min(together, tier.tile_rows - row);
            RELIEF_CHECK(encode_rows(row, rows));
            if (options_.progress &&
                !options_.progress(0.2 + 0.8 * static_cast<double>(row + rows) /
                                             static_cast<double>(tier.tile_rows)))
                return cancelled();
        }
        return {};
    }

    Status encode_rows(std::int64_t tile_row, std::int64_t tile_rows) {
        const std::int64_t across = tree_.tier(0).tile_cols;
        const std::int64_t first = tile_row * across;
        const std::int64_t count = tile_rows * across;
        const LatticeBox top = tree_.box(0, first);
        const LatticeBox bottom = tree_.box(0, first + count - 1);
        const LatticeBox strip_box{top.row0, 0, bottom.row0 + bottom.rows - top.row0, about_.cols};
        Raster room;
        RELIEF_TRY(const RasterView strip, source_.view(strip_box, room));
        std::vector<Status> failed(static_cast<std::size_t>(count));
        std::vector<EncodedTile> tiles(static_cast<std::size_t>(count));
        parallel_for(0, count, 1, [&](std::int64_t k, std::int64_t) {
            const auto at = static_cast<std::size_t>(k);
            if (const auto kept = kept_.find(first + k); kept != kept_.end()) {
                tiles[at] = std::move(kept->second);
                return;
            }
            LatticeBox box = tree_.box(0, first + k);
            box.row0 -= strip_box.row0;
            auto tile = encode_finest_tile(coding_, coarse_, first + k, part_of(strip, box));
            if (tile.ok())
                tiles[at] = *std::move(tile);
            else
                failed[at] = tile.error();
        });
        coarse_energy_ += coarse_energy(strip, strip_box.row0, survey_, about_);
        for (std::int64_t k = 0; k < count; ++k) {
            RELIEF_CHECK(failed[static_cast<std::size_t>(k)]);
            RELIEF_CHECK(take(first + k, tiles[static_cast<std::size_t>(k)]));
        }
        return {};
    }

    Status take(std::int64_t number, const EncodedTile& tile) {
        RELIEF_TRY(auto chunks, spooled_chunks(tile.chunks));
        assembly_.add_finest(number, std::move(chunks), summary_of(tile));
        return {};
    }

    Result<std::vector<SpooledChunk>> spooled_chunks(const std::vector<Bytes>& chunks) {
        std::vector<SpooledChunk> entries;
        for (const Bytes& chunk : chunks) {
            RELIEF_TRY(const SpooledChunk entry, spooled(chunk, *spool_));
            entries.push_back(entry);
        }
        return entries;
    }

    const RasterSource& source_;
    const Raster& about_;
    const Survey& survey_;
    const LatticeOptions& options_;
    Spool* spool_;  ///< of `run`
    LatticeCoding coding_;
    TileTree tree_;
    std::vector<Raster> coarser_;  ///< samples of tiers 2 ..
    CoarseTiers coarse_;
    std::map<std::int64_t, EncodedTile> kept_;  ///< finest tiles that trials have encoded
    LatticeAssembly assembly_;
    double coarse_energy_ = 0;
};

}  // namespace

TileSamples tile_samples(const LatticeCoding& coding, const RasterView& part) {
    TileSamples samples;
    samples.valid = mask_of(part);
    samples.originals = part.planes;
    for (std::size_t p = 0; p < coding.domains.size(); ++p) {
        Grid<std::int32_t> values(part.rows, part.cols);
        for (std::int64_t r = 0; r < part.rows; ++r)
            integer_row(part.planes[p].row(r), part.cols, coding.domains[p], values.row(r));
        samples.values.push_back(std::move(values));
    }
    return samples;
}

RasterView part_of(const RasterView& view, const LatticeBox& box) {
    RasterView part{.rows = box.rows, .cols = box.cols};
    for (const GridView<const double>& plane : view.planes)
        part.planes.emplace_back(plane.row(box.row0) + box.col0, box.rows, box.cols, plane.stride);
    if (view.mask.data)
        part.mask = {view.mask.row(box.row0) + box.col0, box.rows, box.cols, view.mask.stride};
    return part;
}

Result<CoarseEncoding> encode_coarse_tiers(const RasterSource& source, const Survey& survey,
                                           LatticeCoding coding, const LatticeOptions& options) {
    return Encoder(source, survey, std::move(coding), options, nullptr).coarse();
}

Result<LatticeEncoding> encode_lattice(const RasterSource& source, const Survey& survey,
                                       LatticeCoding coding, const LatticeOptions& options,
                                       Spool& spool) {
    return Encoder(source, survey, std::move(coding), options, &spool).run();
}

}  // namespace relief::codec
