#include "edit/touched_boxes.h"

#include <algorithm>

namespace relief::edit {

namespace {

/// More boxes than this cost more than the places between them.
constexpr std::size_t kMostBoxes = 16;

LatticeBox hull(const LatticeBox& a, const LatticeBox& b) {
    const std::int64_t row0 = std::min(a.row0, b.row0);
    const std::int64_t col0 = std::min(a.col0, b.col0);
    return {row0, col0, std::max(a.row0 + a.rows, b.row0 + b.rows) - row0,
            std::max(a.col0 + a.cols, b.col0 + b.cols) - col0};
}

/// What joining two boxes adds to their areas.
std::int64_t waste(const LatticeBox& a, const LatticeBox& b) {
    return hull(a, b).count() - a.count() - b.count();
}

/// Joins a box with the one that it wastes least with, if that is nothing or there are too many.
void insert(std::vector<LatticeBox>& boxes, const LatticeBox& box) {
    if (box.count() == 0) return;
    const auto best = std::min_element(
        boxes.begin(), boxes.end(),
        [&](const auto& a, const auto& b) { return waste(a, box) < waste(b, box); });
    if (best == boxes.end() || (waste(*best, box) > 0 && boxes.size() < kMostBoxes))
        boxes.push_back(box);
    else
        *best = hull(*best, box);
}

}  // namespace

std::vector<LatticeBox> touched_boxes(const multires::PyramidLayout& layout,
                                      const std::vector<multires::Move>& moves, int level) {
    std::vector<LatticeBox> boxes;
    for (const multires::Move& move : moves)
        if (move.level >= level) insert(boxes, multires::touched_box(layout, {move}));
    return boxes;
}

std::uint64_t covered(const std::vector<LatticeBox>& boxes) {
    // Strips between all borders of rows; in each, the boxes' columns as intervals.
    std::vector<std::int64_t> borders;
    for (const LatticeBox& box : boxes) {
        borders.push_back(box.row0);
        borders.push_back(box.row0 + box.rows);
    }
    std::sort(borders.begin(), borders.end());
    std::int64_t count = 0;
    for (std::size_t k = 1; k < borders.size(); ++k) {
        std::vector<std::pair<std::int64_t, std::int64_t>> intervals;
        for (const LatticeBox& box : boxes)
            if (box.row0 < borders[k] && box.row0 + box.rows > borders[k - 1])
                intervals.emplace_back(box.col0, box.col0 + box.cols);
        std::sort(intervals.begin(), intervals.end());
        std::int64_t end = INT64_MIN;
        for (const auto& [first, last] : intervals) {
            const std::int64_t from = std::max(first, end);
            count += (borders[k] - borders[k - 1]) * std::max<std::int64_t>(last - from, 0);
            end = std::max(end, last);
        }
    }
    return static_cast<std::uint64_t>(count);
}

}  // namespace relief::edit
