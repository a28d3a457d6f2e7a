#pragma once

#include <limits>
#include <span>
#include <vector>

#include "mesh/box_tree.h"

namespace relief::mesh {

/// The point of a segment that is nearest to p.
inline Vec2 nearest_on_segment(Vec2 from, Vec2 along, Vec2 p) {
    const double t = dot(p - from, along) / dot(along, along);
    return t <= 0 ? from : t >= 1 ? from + along : from + t * along;
}

/// The nearest of some segments.
struct NearestEdge {
    std::size_t edge = 0;  ///< its place among them
    Vec2 point;
    double distance = std::numeric_limits<double>::infinity();
};

/// Finds nearest points on segments, among equally near ones on the first of them.
class EdgeTree {
  public:
    struct Segment {
        Vec2 from;
        Vec2 along;
    };

    EdgeTree() = default;
    explicit EdgeTree(std::vector<Segment> segments) : segments_(std::move(segments)) {
        std::vector<Box> boxes;
        boxes.reserve(segments_.size());
        for (const Segment& s : segments_)
            boxes.push_back(box_of(std::array{s.from, s.from + s.along}));
        tree_ = BoxTree(boxes);
    }

    [[nodiscard]] const Segment& operator[](std::size_t edge) const { return segments_[edge]; }

    [[nodiscard]] NearestEdge nearest(Vec2 p) const {
        NearestEdge best;
        tree_.search(
            [&](const Box& box) { return box.distance(p) <= best.distance; },
            [&](Index k) {
                const Vec2 foot = nearest_on_segment(segments_[k].from, segments_[k].along, p);
                const double distance = length(p - foot);
                if (distance < best.distance || (distance == best.distance && k < best.edge))
                    best = {k, foot, distance};
            });
        return best;
    }

  private:
    std::vector<Segment> segments_;
    BoxTree tree_;
};

}  // namespace relief::mesh
