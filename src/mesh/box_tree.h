#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "relief/core/vec2.h"
#include "relief/mesh/quadrangulation.h"

namespace relief::mesh {

/// An axis-parallel box; empty until it includes a point.
struct Box {
    Vec2 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    Vec2 high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};

    void include(Vec2 p) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
    void include(const Box& b) {
        include(b.low);
        include(b.high);
    }
    [[nodiscard]] Box grown(double margin) const {
        return {low - Vec2{margin, margin}, high + Vec2{margin, margin}};
    }
    [[nodiscard]] bool contains(Vec2 p) const {
        return p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y;
    }
    [[nodiscard]] bool meets(const Box& b) const {
        return b.low.x <= high.x && b.high.x >= low.x && b.low.y <= high.y && b.high.y >= low.y;
    }
    /// Whether the box reaches the line through `from` along `along`, or a parallel within
    /// `margin`.
    [[nodiscard]] bool meets_line(Vec2 from, Vec2 along, double margin) const {
        const Vec2 half = 0.5 * (high - low);
        const double reach = std::abs(along.y) * half.x + std::abs(along.x) * half.y;
        return std::abs(cross(along, midpoint(low, high) - from)) <= reach + margin * length(along);
    }
    [[nodiscard]] double distance(Vec2 p) const {
        return length({std::max({low.x - p.x, 0.0, p.x - high.x}),
                       std::max({low.y - p.y, 0.0, p.y - high.y})});
    }
};

template <class Points>
[[nodiscard]] Box box_of(const Points& points) {
    Box box;
    for (const Vec2 p : points) box.include(p);
    return box;
}

/// Finds the items whose boxes meet a query. A balanced binary tree: unlike a grid of buckets it
/// keeps O(log n) a query and O(n) memory however unevenly a file distributes its elements.
class BoxTree {
  public:
    BoxTree() = default;
    explicit BoxTree(std::span<const Box> boxes) : items_(boxes.size()) {
        std::iota(items_.begin(), items_.end(), Index{0});
        if (items_.empty()) return;
        nodes_.reserve(boxes.size());
        build(boxes, 0, static_cast<Index>(boxes.size()));
    }

    /// Calls visit(item) for every item of every leaf whose box, and whose parents' boxes, `enter`
    /// accepts. The order is fixed, depends on the boxes, and is not ascending.
    template <class Enter, class Visit>
    void search(Enter&& enter, Visit&& visit) const {
        if (!nodes_.empty()) search_node(0, enter, visit);
    }

  private:
    static constexpr Index kLeafItems = 4;

    /// The first child follows its parent; `second` is 0 in a leaf.
    struct Node {
        Box box;
        Index begin = 0;
        Index end = 0;
        Index second = 0;
    };

    void build(std::span<const Box> boxes, Index begin, Index end) {
        const std::size_t self = nodes_.size();
        nodes_.push_back({{}, begin, end, 0});
        Box box;
        for (Index k = begin; k < end; ++k) box.include(boxes[items_[k]]);
        nodes_[self].box = box;
        if (end - begin <= kLeafItems) return;
        const bool along_x = box.high.x - box.low.x >= box.high.y - box.low.y;
        const auto key = [&](Index item) {
            const Box& b = boxes[item];
            return std::pair(along_x ? b.low.x + b.high.x : b.low.y + b.high.y, item);
        };
        const Index middle = begin + (end - begin) / 2;
        std::nth_element(items_.begin() + begin, items_.begin() + middle, items_.begin() + end,
                         [&](Index a, Index b) { return key(a) < key(b); });
        build(boxes, begin, middle);
        nodes_[self].second = static_cast<Index>(nodes_.size());
        build(boxes, middle, end);
    }

    template <class Enter, class Visit>
    void search_node(Index n, Enter& enter, Visit& visit) const {
        const Node& node = nodes_[n];
        if (!enter(node.box)) return;
        if (node.second == 0) {
            for (Index k = node.begin; k < node.end; ++k) visit(items_[k]);
            return;
        }
        search_node(n + 1, enter, visit);
        search_node(node.second, enter, visit);
    }

    std::vector<Index> items_;
    std::vector<Node> nodes_;
};

}  // namespace relief::mesh
