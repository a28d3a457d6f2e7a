#include "codec/tile_masks.h"

#include <algorithm>

#include "relief/codec/mask_coder.h"

namespace relief::codec {

namespace {

/// Masks that are kept, besides two rows of tiles.
constexpr std::size_t kFewestKept = 16;

}  // namespace

Bytes encode_tile_mask(GridView<const std::uint8_t> mask) {
    bool holes = false;
    for (std::int64_t r = 0; r < mask.rows; ++r)
        holes =
            holes || std::find(mask.row(r), mask.row(r) + mask.cols, 0) != mask.row(r) + mask.cols;
    return holes ? encode_mask(mask) : Bytes();
}

TileMasks::TileMasks(const ContainerReader& container, std::int64_t rows, std::int64_t cols,
                     std::size_t first_chunk)
    : container_(container), tree_(rows, cols), first_chunk_(first_chunk) {
    const std::vector<std::int64_t> order = tree_.hilbert_order(0);
    places_.resize(order.size());
    for (std::size_t k = 0; k < order.size(); ++k) places_[static_cast<std::size_t>(order[k])] = k;
    capacity_ = kFewestKept + 2 * static_cast<std::size_t>(tree_.tier(0).tile_cols);
}

TileMasks::MaskPointer TileMasks::decode(std::int64_t number) const {
    const std::size_t chunk = first_chunk_ + places_[static_cast<std::size_t>(number)];
    const Result<Bytes> bytes = container_.chunk(chunk);
    if (!bytes.ok()) return nullptr;
    const LatticeBox box = tree_.box(0, number);
    auto mask = std::make_shared<Grid<std::uint8_t>>(box.rows, box.cols, 1);
    if (!bytes->empty() && !decode_mask(*bytes, mask->view()).ok()) return nullptr;
    return mask;
}

TileMasks::MaskPointer TileMasks::tile(std::int64_t number) const {
    {
        const std::lock_guard lock(mutex_);
        if (const auto found = kept_.find(number); found != kept_.end()) return found->second;
    }
    MaskPointer mask = decode(number);
    const std::lock_guard lock(mutex_);
    if (kept_.size() >= capacity_) kept_.clear();
    return kept_.emplace(number, std::move(mask)).first->second;
}

Grid<std::uint8_t> TileMasks::read(int level, const LatticeBox& window,
                                   std::vector<LatticeBox>& damaged) const {
    Grid<std::uint8_t> mask(window.rows, window.cols, 0);
    const LatticeBox tiles = tree_.tiles_meeting(
        0, {window.row0 << level, window.col0 << level, ((window.rows - 1) << level) + 1,
            ((window.cols - 1) << level) + 1});
    for (std::int64_t i = tiles.row0; i < tiles.row0 + tiles.rows; ++i)
        for (std::int64_t j = tiles.col0; j < tiles.col0 + tiles.cols; ++j) {
            const std::int64_t number = i * tree_.tier(0).tile_cols + j;
            const LatticeBox box = tree_.box(0, number);
            const MaskPointer found = tile(number);
            if (!found) {
                damaged.push_back(box);
                continue;
            }
            const LatticeBox part = intersection(window, box_at_level(box, level));
            for (std::int64_t r = part.row0; r < part.row0 + part.rows; ++r)
                for (std::int64_t c = part.col0; c < part.col0 + part.cols; ++c)
                    mask(r - window.row0, c - window.col0) =
                        (*found)((r << level) - box.row0, (c << level) - box.col0);
        }
    return mask;
}

}  // namespace relief::codec
