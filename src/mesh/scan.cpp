#include "relief/mesh/scan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "mesh/box_tree.h"
#include "mesh/containment.h"

namespace relief::mesh {

namespace {

constexpr Index kBand = 8;  ///< rows that share a list of triangles

/// Numbers of samples, from begin to end - 1.
struct Span {
    Index begin = 0;
    Index end = 0;
};

/// Those between two places along an axis, up to rounding.
Span samples_between(double low, double high, double first, double step, Index count) {
    const double a = (low - first) / step;
    const double b = (high - first) / step;
    const auto clamped = [count](double t) {
        return static_cast<Index>(std::clamp(t, 0.0, static_cast<double>(count)));
    };
    const Index begin = clamped(std::ceil(std::min(a, b)));
    return {begin, std::max(begin, clamped(std::floor(std::max(a, b)) + 1))};
}

}  // namespace

RowScan::RowScan(const Triangulation& mesh, const SampleRows& samples)
    : mesh_(mesh), samples_(samples), first_(samples.rows / kBand + 2) {
    const auto each_band = [&](auto visit) {
        for (Index t = 0; t < mesh.triangle_count(); ++t) {
            const Box box = box_of(mesh.corners(t)).grown(std::abs(samples.step.y));
            const Span rows =
                samples_between(box.low.y, box.high.y, samples.first.y - mesh.origin.y,
                                samples.step.y, samples.rows);
            if (rows.begin == rows.end) continue;
            for (Index b = rows.begin / kBand; b <= (rows.end - 1) / kBand; ++b) visit(b, t);
        }
    };
    each_band([&](Index b, Index) { ++first_[b + 1]; });
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    triangles_.resize(first_.back());
    std::vector<Index> place(first_);
    each_band([&](Index b, Index t) { triangles_[place[b]++] = t; });
}

/// The row meets the sides of the triangle near the ends; what is in it is asked there.
SampleRun RowScan::run_of(Index triangle, Index row) const {
    const auto inside = [&](Index column) {
        return contains(mesh_, triangle, samples_.at(row, column) - mesh_.origin);
    };
    const double y = samples_.at(row, 0).y - mesh_.origin.y;
    const TriangleCorners corners = mesh_.corners(triangle);
    const Box box = box_of(corners);
    double left = box.low.x;
    double right = box.high.x;
    for (int k = 0; k < 3; ++k) {
        const Vec2 from = corners[k];
        const Vec2 along = corners[(k + 1) % 3] - from;
        if (along.y == 0) continue;
        const double x = from.x + along.x * (y - from.y) / along.y;
        if (along.y < 0)
            left = std::max(left, x);
        else
            right = std::min(right, x);
    }
    Span columns = samples_between(left, std::max(left, right), samples_.first.x - mesh_.origin.x,
                                   samples_.step.x, samples_.columns);
    while (columns.begin > 0 && inside(columns.begin - 1)) --columns.begin;
    while (columns.begin < columns.end && !inside(columns.begin)) ++columns.begin;
    while (columns.end > columns.begin && !inside(columns.end - 1)) --columns.end;
    while (columns.end > columns.begin && columns.end < samples_.columns && inside(columns.end))
        ++columns.end;
    return {triangle, columns.begin, columns.end};
}

std::vector<SampleRun> RowScan::runs(Index row) const {
    const double y = samples_.at(row, 0).y - mesh_.origin.y;
    const double margin = std::abs(samples_.step.y);
    std::vector<Index> triangle_at(samples_.columns, kNone);
    // Where triangles share samples, the smallest comes last.
    for (Index k = first_[row / kBand + 1]; k-- > first_[row / kBand];) {
        const auto [a, b, c] = mesh_.corners(triangles_[k]);
        if (std::max({a.y, b.y, c.y}) < y - margin || std::min({a.y, b.y, c.y}) > y + margin)
            continue;
        const SampleRun run = run_of(triangles_[k], row);
        std::fill(triangle_at.begin() + run.begin, triangle_at.begin() + run.end, run.triangle);
    }
    std::vector<SampleRun> found;
    for (Index begin = 0, end = 0; begin < samples_.columns; begin = end) {
        while (end < samples_.columns && triangle_at[end] == triangle_at[begin]) ++end;
        if (triangle_at[begin] != kNone) found.push_back({triangle_at[begin], begin, end});
    }
    return found;
}

}  // namespace relief::mesh
