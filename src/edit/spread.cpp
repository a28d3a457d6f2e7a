#include <algorithm>
#include <cmath>
#include <queue>
#include <string>
#include <unordered_map>

#include "edit/model.h"

namespace relief::edit {

namespace {

/// A point that was reached, from which of the moved points, and how far that is.
struct Reached {
    double distance = 0;
    std::uint64_t point = 0;
    std::uint64_t source = 0;

    /// Nearest first; equal distances in the order of numbers, so that results have no choice.
    friend bool operator>(const Reached& a, const Reached& b) {
        if (a.distance != b.distance) return a.distance > b.distance;
        if (a.source != b.source) return a.source > b.source;
        return a.point > b.point;
    }
};

using Queue = std::priority_queue<Reached, std::vector<Reached>, std::greater<>>;

/// Distances below the radius from the nearest of the points, by the shortest paths.
std::unordered_map<std::uint64_t, double> distances(const Move& move, const NetGraph& graph) {
    std::unordered_map<std::uint64_t, double> done;
    Queue queue;
    for (const std::uint64_t point : move.points) queue.push({0, point, point});
    std::vector<std::uint64_t> around;
    while (!queue.empty()) {
        const Reached here = queue.top();
        queue.pop();
        if (!done.emplace(here.point, here.distance).second) continue;
        around.clear();
        graph.neighbours(here.point, around);
        for (const std::uint64_t next : around) {
            if (done.contains(next)) continue;
            const double d = graph.distance(here.source, here.point, here.distance, next);
            if (d < move.falloff.radius) queue.push({d, next, here.source});
        }
    }
    return done;
}

}  // namespace

Result<std::vector<PointMove>> spread(const Move& move, const NetGraph& graph) {
    std::vector<std::uint64_t> sorted = move.points;
    std::sort(sorted.begin(), sorted.end());
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (twice != sorted.end())
        return Error{ErrorCode::InvalidArgument,
                     "control point " + std::to_string(*twice) + " is named twice", ""};
    if (!sorted.empty() && sorted.back() >= graph.count())
        return Error{ErrorCode::InvalidArgument,
                     "there is no control point " + std::to_string(sorted.back()) + " at level " +
                         std::to_string(move.level) + "; it has 0 to " +
                         std::to_string(graph.count() - 1),
                     ""};
    std::vector<PointMove> moves;
    if (move.falloff.radius <= 0) {
        for (const std::uint64_t point : sorted)
            moves.push_back({move.level, point, move.delta, move.slope});
        return moves;
    }
    for (const auto& [point, d] : distances(move, graph)) {
        const double weight = move.falloff.weight(d);
        if (weight == 0) continue;
        moves.push_back({move.level, point, weight * move.delta, weight * move.slope});
    }
    std::sort(moves.begin(), moves.end(),
              [](const PointMove& a, const PointMove& b) { return a.point < b.point; });
    return moves;
}

}  // namespace relief::edit
