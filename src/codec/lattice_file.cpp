#include "codec/lattice_file.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "codec/tile_start.h"
#include "relief/core/parallel.h"

namespace relief::codec {

namespace {

constexpr std::size_t kFewestKept = 16;

/// The samples of `level` that lie in a box of a tier's lattice.
LatticeBox in_level(const LatticeBox& box, int shift) {
    const std::int64_t row0 = level_size(box.row0, shift);
    const std::int64_t col0 = level_size(box.col0, shift);
    return {row0, col0, level_size(box.row0 + box.rows, shift) - row0,
            level_size(box.col0 + box.cols, shift) - col0};
}

}  // namespace

LatticeChunks::LatticeChunks(const TileTree& tree, std::size_t first) : tree_(tree) {
    tiers_.resize(static_cast<std::size_t>(tree.tiers()));
    for (int k = tree.tiers() - 1; k >= 0; --k) {
        Tier& tier = tiers_[static_cast<std::size_t>(k)];
        tier.first = first;
        tier.ranges = chunk_ranges(tree, k);
        const std::vector<std::int64_t> order = tree.hilbert_order(k);
        tier.place.resize(order.size());
        for (std::size_t at = 0; at < order.size(); ++at)
            tier.place[static_cast<std::size_t>(order[at])] = static_cast<std::int64_t>(at);
        first += tier.ranges.size() * order.size();
    }
}

std::size_t LatticeChunks::chunk(int tier, std::size_t range, std::int64_t tile) const {
    const Tier& t = tiers_[static_cast<std::size_t>(tier)];
    return t.first + range * t.place.size() +
           static_cast<std::size_t>(t.place[static_cast<std::size_t>(tile)]);
}

std::size_t LatticeChunks::end_of_level(int level) const {
    const int tier = tree_.tier_of(level);
    const Tier& t = tiers_[static_cast<std::size_t>(tier)];
    std::size_t range = 0;
    while (range + 1 < t.ranges.size() && t.ranges[range].last > level) ++range;
    return t.first + (range + 1) * t.place.size();
}

LatticeFile::LatticeFile(const ContainerReader& container, std::size_t first_chunk,
                         LatticeCoding coding, std::int64_t rows, std::int64_t cols)
    : container_(container),
      tree_(rows, cols),
      chunks_(tree_, first_chunk),
      coding_(std::move(coding)),
      capacity_(kFewestKept) {
    for (int k = 1; k < tree_.tiers(); ++k)
        capacity_ += 2 * static_cast<std::size_t>(tree_.tier(k).tile_cols);
}

Result<std::unique_ptr<LatticeFile>> LatticeFile::open(const ContainerReader& container,
                                                       std::size_t first_chunk,
                                                       LatticeCoding coding, std::int64_t rows,
                                                       std::int64_t cols) {
    // Sizes must be believable before anything of their size is allocated: each tile has chunks.
    const TileTree tree(rows, cols);
    std::uint64_t expected = first_chunk;
    for (int k = 0; k < tree.tiers(); ++k)
        expected += static_cast<std::uint64_t>(tree.tier(k).tiles()) * chunk_ranges(tree, k).size();
    if (expected != container.chunks().size())
        return Error{ErrorCode::BadFile,
                     "has " + std::to_string(container.chunks().size()) +
                         " chunks where its size "
                         "calls for " +
                         std::to_string(expected) + "; the file is damaged",
                     "directory"};
    return std::unique_ptr<LatticeFile>(
        new LatticeFile(container, first_chunk, std::move(coding), rows, cols));
}

Result<TileState> LatticeFile::start(int tier, std::int64_t number, Tile& about) const {
    if (tier == tree_.tiers() - 1) return top_state(coding_);
    const LatticeBox box = tree_.box(tier, number);
    const LatticeBox reach{std::max<std::int64_t>(0, (box.row0 >> TileTree::kTierLevels) - 3),
                           std::max<std::int64_t>(0, (box.col0 >> TileTree::kTierLevels) - 3),
                           level_size(box.rows, TileTree::kTierLevels) + 6,
                           level_size(box.cols, TileTree::kTierLevels) + 6};
    const LatticeBox met = tree_.tiles_meeting(tier + 1, reach);
    const std::int64_t across = tree_.tier(tier + 1).tile_cols;
    std::map<std::int64_t, TilePointer> around;
    for (std::int64_t i = met.row0; i < met.row0 + met.rows; ++i)
        for (std::int64_t j = met.col0; j < met.col0 + met.cols; ++j) {
            RELIEF_TRY(around[i * across + j], coarse(tier + 1, i * across + j));
            const Tile& above = *around[i * across + j];
            about.known_level = std::max(about.known_level, above.known_level);
            about.bound = std::max(about.bound, above.bound);
        }
    const auto fetch = [&](std::size_t component, const LatticeBox& wanted,
                           GridView<std::int32_t> out) {
        for (const auto& [tile, decoded] : around) {
            const LatticeBox inside = tree_.box(tier + 1, tile);
            const LatticeBox part = intersection(inside, wanted);
            for (std::int64_t r = 0; r < part.rows; ++r)
                if (part.cols > 0)
                    std::copy_n(
                        decoded->state.levels[component].values.row(part.row0 + r - inside.row0) +
                            (part.col0 - inside.col0),
                        part.cols,
                        out.row(part.row0 + r - wanted.row0) + (part.col0 - wanted.col0));
        }
    };
    TileState state = state_below(coding_, tree_, tier, number,
                                  around.at(tree_.parent(tier, number))->state.codecs, fetch);
    for (const auto& [tile, decoded] : around)
        inherit_repairs(*decoded, tree_.box(tier + 1, tile), tier, box, state);
    return state;
}

Result<TileState> LatticeFile::start_of_finest(std::int64_t number) const {
    Tile about;
    RELIEF_TRY(TileState state, start(0, number, about));
    if (about.known_level > TileTree::kTierLevels)
        return Error{ErrorCode::BadFile, "a coarser tile is damaged or missing",
                     "tile " + std::to_string(number)};
    state.repairs.clear();  // those of the tiers above
    return state;
}

/// Repairs of samples that the tier above has coded, where they lie in a tile's box.
void LatticeFile::inherit_repairs(const Tile& above, const LatticeBox& over, int tier,
                                  const LatticeBox& box, TileState& state) {
    const int level = TileTree::kTierLevels * (tier + 1);
    const std::int64_t rows = level_size(box.rows, TileTree::kTierLevels);
    const std::int64_t cols = level_size(box.cols, TileTree::kTierLevels);
    for (const LatticeRepair& repair : above.state.repairs) {
        const int shift = repair.level - level;
        const std::int64_t row =
            over.row0 + (repair.row << shift) - (box.row0 >> TileTree::kTierLevels);
        const std::int64_t col =
            over.col0 + (repair.col << shift) - (box.col0 >> TileTree::kTierLevels);
        if (row >= 0 && row < rows && col >= 0 && col < cols)
            state.repairs.push_back({repair.component, level, row, col, repair.value});
    }
}

/// Holes of a tile whose own mask is missing: as the nearest samples of the tier above say.
Grid<std::uint8_t> LatticeFile::mask_from_above(int tier, std::int64_t number) const {
    if (tier == tree_.tiers() - 1) return {};
    const auto above = coarse(tier + 1, tree_.parent(tier, number));
    if (!above.ok() || (*above)->valid.empty()) return {};
    const LatticeBox box = tree_.box(tier, number);
    const LatticeBox over = tree_.box(tier + 1, tree_.parent(tier, number));
    Grid<std::uint8_t> valid(box.rows, box.cols);
    for (std::int64_t r = 0; r < box.rows; ++r)
        for (std::int64_t c = 0; c < box.cols; ++c)
            valid(r, c) =
                (*above)->valid(std::min(((box.row0 + r) >> 3) - over.row0, over.rows - 1),
                                std::min(((box.col0 + c) >> 3) - over.col0, over.cols - 1));
    return valid;
}

Result<LatticeFile::Tile> LatticeFile::decode(int tier, std::int64_t number, int level) const {
    Tile tile;
    RELIEF_TRY(tile.state, start(tier, number, tile));
    const bool top = tier == tree_.tiers() - 1;
    const LatticeBox box = tree_.box(tier, number);
    const std::vector<LevelRange>& ranges = chunks_.ranges(tier);
    std::optional<TileCodec> codec;
    for (std::size_t k = 0; k < ranges.size() && (k == 0 || ranges[k].first >= level); ++k) {
        const std::size_t chunk = chunks_.chunk(tier, k, number);
        if (!container_.complete(chunk)) break;
        const auto bytes = container_.chunk(chunk);
        tile.damaged = !bytes.ok();
        if (!bytes.ok()) break;
        std::span<const std::uint8_t> rest(*bytes);
        if (k == 0) {
            auto valid = read_tile_mask(box, rest);
            tile.damaged = !valid.ok();
            if (!valid.ok()) break;
            tile.valid = *std::move(valid);
            codec.emplace(coding_, tree_, tier, number, tile.valid);
            if (!top && !codec->has_valid()) {
                tile.known_level = 0;
                tile.bound = 0;
                break;
            }
        }
        tile.damaged = !codec->decode_chunk(ranges[k], rest, tile.state).ok();
        if (tile.damaged) break;
        tile.known_level = ranges[k].last;
        tile.bound = container_.chunks()[chunk].bound;
    }
    if (tile.state.levels.empty())
        return Error{ErrorCode::BadFile,
                     "the coarsest level is damaged or missing: nothing can be "
                     "decoded",
                     "first chunk"};
    if (!codec) {
        tile.valid = mask_from_above(tier, number);
        codec.emplace(coding_, tree_, tier, number, tile.valid);
    }
    for (std::size_t c = 0; c < tile.state.levels.size(); ++c)
        while (tile.state.levels[c].level > level)
            tile.state.levels[c] =
                codec->interpolate(tile.state.levels[c].level - 1, c, tile.state.levels[c]);
    return tile;
}

Result<LatticeFile::TilePointer> LatticeFile::coarse(int tier, std::int64_t number) const {
    const Key key{tier, number};
    {
        const std::lock_guard lock(mutex_);
        if (const auto found = index_.find(key); found != index_.end()) {
            recent_.splice(recent_.begin(), recent_, found->second);
            return found->second->second;
        }
    }
    RELIEF_TRY(Tile tile, decode(tier, number, TileTree::kTierLevels * tier));
    const auto kept = std::make_shared<const Tile>(std::move(tile));
    const std::lock_guard lock(mutex_);
    if (index_.contains(key)) return kept;  // another thread was faster, with the same result
    recent_.emplace_front(key, kept);
    index_[key] = recent_.begin();
    if (recent_.size() > capacity_) {
        index_.erase(recent_.back().first);
        recent_.pop_back();
    }
    return kept;
}

void LatticeFile::copy_tile(const Tile& tile, int tier, std::int64_t number, int level,
                            const LatticeBox& window, bool fill_holes, LatticeWindow& out) const {
    const int shift = level - TileTree::kTierLevels * tier;
    const LatticeBox box = tree_.box(tier, number);
    const LatticeBox have = in_level(box, shift);
    const LatticeBox part = intersection(have, window);
    if (part.rows <= 0 || part.cols <= 0) return;
    const std::int64_t step = std::int64_t{1} << (level - tile.state.levels[0].level);
    for (std::size_t p = 0; p < out.planes.size(); ++p) {
        const LatticeLevel& from = tile.state.levels[p];
        std::vector<std::int32_t> picked(static_cast<std::size_t>(part.cols));
        for (std::int64_t r = 0; r < part.rows; ++r) {
            const std::int32_t* row = from.values.row((part.row0 - have.row0 + r) * step) +
                                      (part.col0 - have.col0) * step;
            for (std::int64_t c = 0; c < part.cols && step > 1; ++c)
                picked[static_cast<std::size_t>(c)] = row[c * step];
            coding_.stored(
                p, step > 1 ? picked.data() : row, part.cols,
                out.planes[p].row(part.row0 - window.row0 + r) + (part.col0 - window.col0));
        }
    }
    for (const LatticeRepair& repair : tile.state.repairs) {
        if (repair.level < level) continue;
        const std::int64_t row = have.row0 + (repair.row << (repair.level - level));
        const std::int64_t col = have.col0 + (repair.col << (repair.level - level));
        if (window.contains(row, col))
            out.planes[repair.component](row - window.row0, col - window.col0) = repair.value;
    }
    if (tile.valid.empty() || fill_holes) return;
    for (Grid<double>& plane : out.planes)
        visit_holes(tile.valid, tier, number, level, window, [&](std::int64_t r, std::int64_t c) {
            plane(r, c) = std::numeric_limits<double>::quiet_NaN();
        });
}

template <class Visit>
void LatticeFile::visit_holes(const Grid<std::uint8_t>& valid, int tier, std::int64_t number,
                              int level, const LatticeBox& window, Visit visit) const {
    const int shift = level - TileTree::kTierLevels * tier;
    const LatticeBox have = in_level(tree_.box(tier, number), shift);
    const LatticeBox part = intersection(have, window);
    for (std::int64_t r = 0; r < part.rows; ++r) {
        const std::uint8_t* row =
            valid.row((part.row0 - have.row0 + r) << shift) + ((part.col0 - have.col0) << shift);
        for (std::int64_t c = 0; c < part.cols; ++c)
            if (!row[c << shift]) visit(part.row0 - window.row0 + r, part.col0 - window.col0 + c);
    }
}

Result<LatticeWindow> LatticeFile::read(int level, const LatticeBox& window,
                                        bool fill_holes) const {
    const int tier = tree_.tier_of(level);
    const int shift = level - TileTree::kTierLevels * tier;
    LatticeWindow out;
    for (std::size_t p = 0; p < coding_.domains.size(); ++p)
        out.planes.emplace_back(window.rows, window.cols);
    const LatticeBox samples{window.row0 << shift, window.col0 << shift,
                             ((window.rows - 1) << shift) + 1, ((window.cols - 1) << shift) + 1};
    const LatticeBox met = tree_.tiles_meeting(tier, samples);
    const auto tile_number = [&, across = tree_.tier(tier).tile_cols](std::int64_t k) {
        return (met.row0 + k / met.cols) * across + met.col0 + k % met.cols;
    };
    std::vector<Status> failed(static_cast<std::size_t>(met.count()));
    std::vector<Tile> abouts(failed.size());
    parallel_for(0, met.count(), 1, [&](std::int64_t k, std::int64_t) {
        const std::int64_t number = tile_number(k);
        Result<Tile> tile = decode(tier, number, level);
        const auto at = static_cast<std::size_t>(k);
        if (!tile.ok()) {
            failed[at] = tile.error();
            return;
        }
        copy_tile(*tile, tier, number, level, window, fill_holes, out);
        tile->state = {};
        abouts[at] = *std::move(tile);
    });
    for (std::size_t k = 0; k < failed.size(); ++k) {
        RELIEF_CHECK(failed[k]);
        const Tile& about = abouts[k];
        out.known_level = std::max(out.known_level, about.known_level);
        out.bound = std::max(out.bound, about.bound);
        const std::int64_t number = tile_number(static_cast<std::int64_t>(k));
        if (!about.damaged) continue;
        const LatticeBox box = tree_.box(tier, number);
        const int bits = TileTree::kTierLevels * tier;
        out.damaged.push_back(
            {box.row0 << bits, box.col0 << bits, box.rows << bits, box.cols << bits});
    }
    const auto has_holes = [](const Tile& about) { return !about.valid.empty(); };
    if (std::none_of(abouts.begin(), abouts.end(), has_holes)) return out;
    out.mask = Grid<std::uint8_t>(window.rows, window.cols, 1);
    parallel_for(0, met.count(), 1, [&](std::int64_t k, std::int64_t) {
        const Tile& about = abouts[static_cast<std::size_t>(k)];
        if (!has_holes(about)) return;
        visit_holes(about.valid, tier, tile_number(k), level, window,
                    [&](std::int64_t r, std::int64_t c) { out.mask(r, c) = 0; });
    });
    return out;
}

}  // namespace relief::codec
