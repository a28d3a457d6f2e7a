#include "relief/mesh/triangle_locator.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "mesh/box_tree.h"
#include "mesh/containment.h"
#include "mesh/nearest_edge.h"
#include "relief/core/parallel.h"

namespace relief::mesh {

namespace {

constexpr double kMargin = 1e-9;       ///< of cells, relative: covers the tolerance of contains()
constexpr Index kCrowded = 24;         ///< triangles of a cell from which on the tree is asked
constexpr double kMostEntries = 8;     ///< of all cells, a triangle
constexpr std::int64_t kGrain = 4096;  ///< queries of a task

/// Equal cells of a rectangle, row by row.
struct Cells {
    Vec2 low;
    Vec2 size{1, 1};  ///< of a cell
    Index columns = 1;
    Index rows = 1;

    [[nodiscard]] Index count() const { return columns * rows; }
    /// The nearest column or row; the first for what is not a number.
    [[nodiscard]] static Index clamped(double t, Index n) {
        return static_cast<Index>(std::min(t > 0 ? t : 0.0, n - 1.0));
    }
    [[nodiscard]] Index column(double x) const { return clamped((x - low.x) / size.x, columns); }
    [[nodiscard]] Index row(double y) const { return clamped((y - low.y) / size.y, rows); }
    [[nodiscard]] Index of(Vec2 p) const { return row(p.y) * columns + column(p.x); }
};

/// Columns and rows that a box reaches into.
struct CellRange {
    Index left, right, bottom, top;

    [[nodiscard]] double count() const { return (right - left + 1.0) * (top - bottom + 1.0); }
};

CellRange range_of(const Cells& cells, const TriangleCorners& corners) {
    const Box tight = box_of(corners);
    const Box box = tight.grown(kMargin * length(tight.high - tight.low));
    return {cells.column(box.low.x), cells.column(box.high.x), cells.row(box.low.y),
            cells.row(box.high.y)};
}

/// As square as can be, about `count` of them.
Cells cells_over(const Box& box, double count) {
    const Vec2 extent = box.high - box.low;
    const double side = std::sqrt(extent.x * extent.y / count);
    const auto along = [&](double length) {
        return static_cast<Index>(std::clamp(std::ceil(length / side), 1.0, std::max(1.0, count)));
    };
    Cells cells{box.low, extent, along(extent.x), along(extent.y)};
    cells.size = {extent.x / cells.columns, extent.y / cells.rows};
    return cells;
}

Cells cells_of(const PlaneTriangles& mesh) {
    Box box;
    for (Index v = 0; v < mesh.vertex_count(); ++v) box.include(mesh.vertex(v));
    for (double count = 0.5 * mesh.triangle_count();; count /= 4) {
        const Cells cells = cells_over(box, count);
        double entries = 0;
        for (Index t = 0; t < mesh.triangle_count(); ++t)
            entries += range_of(cells, mesh.corners(t)).count();
        if (cells.count() == 1 || entries <= kMostEntries * mesh.triangle_count()) return cells;
    }
}

/// Whether a triangle may reach into a rectangle.
bool reaches(const TriangleCorners& corners, Vec2 centre, Vec2 half) {
    for (int k = 0; k < 3; ++k) {
        const Vec2 along = corners[(k + 1) % 3] - corners[k];
        const double farthest =
            cross(along, centre - corners[k]) +
            (1 + kMargin) * (std::abs(along.x) * half.y + std::abs(along.y) * half.x);
        if (farthest < -kMargin * dot(along, along)) return false;
    }
    return true;
}

template <class Visit>
void each_cell(const Cells& cells, const TriangleCorners& corners, Visit&& visit) {
    const CellRange range = range_of(cells, corners);
    const Vec2 half = 0.5 * cells.size;
    for (Index r = range.bottom; r <= range.top; ++r)
        for (Index c = range.left; c <= range.right; ++c) {
            const Vec2 centre{cells.low.x + (c + 0.5) * cells.size.x,
                              cells.low.y + (r + 0.5) * cells.size.y};
            if (range.count() == 1 || reaches(corners, centre, half)) visit(r * cells.columns + c);
        }
}

}  // namespace

struct TriangleLocator::Data {
    const PlaneTriangles& mesh;
    Cells cells;
    std::vector<Index> first;  ///< the triangles of cell c, ascending, are items[first[c]] ..
    std::vector<Index> items;  ///< .. items[first[c + 1] - 1]; only kNone: the tree knows them
    std::vector<Index> crowd;  ///< the triangles in such cells
    BoxTree crowd_tree;
    std::vector<Index> boundary_triangles;
    EdgeTree boundary;

    Data(const PlaneTriangles& of, std::span<const TriangleSide> sides)
        : mesh(of), cells(cells_of(of)) {
        fill_cells();
        std::vector<EdgeTree::Segment> segments;
        for (const auto& [triangle, side] : sides) {
            const auto& corner = mesh.triangles[triangle];
            // From the lower vertex, so that the same edge gives the same bits on both its sides.
            const auto [a, b] = std::minmax(corner[side], corner[side == 2 ? 0 : side + 1]);
            boundary_triangles.push_back(triangle);
            segments.push_back({mesh.vertex(a), mesh.vertex(b) - mesh.vertex(a)});
        }
        boundary = EdgeTree(std::move(segments));
    }

    void fill_cells() {
        std::vector<Index> counts(cells.count());
        for (Index t = 0; t < mesh.triangle_count(); ++t)
            each_cell(cells, mesh.corners(t), [&](Index c) { ++counts[c]; });
        first.resize(counts.size() + 1);
        for (std::size_t c = 0; c < counts.size(); ++c)
            first[c + 1] = first[c] + (counts[c] > kCrowded ? 1 : counts[c]);
        items.assign(first.back(), kNone);
        std::vector<Index> place(first.begin(), first.end() - 1);
        std::vector<Box> boxes;
        for (Index t = 0; t < mesh.triangle_count(); ++t) {
            bool in_crowd = false;
            each_cell(cells, mesh.corners(t), [&](Index c) {
                if (counts[c] > kCrowded)
                    in_crowd = true;
                else
                    items[place[c]++] = t;
            });
            if (!in_crowd) continue;
            const Box box = box_of(mesh.corners(t));
            crowd.push_back(t);
            boxes.push_back(box.grown(kMargin * length(box.high - box.low)));
        }
        crowd_tree = BoxTree(boxes);
    }

    /// p is relative to the mesh's origin.
    [[nodiscard]] Index triangle_at(Vec2 p) const {
        const Index c = cells.of(p);
        for (Index k = first[c]; k < first[c + 1]; ++k) {
            if (items[k] == kNone) return triangle_in_crowd(p);
            if (contains(mesh, items[k], p)) return items[k];
        }
        return kNone;
    }

    [[nodiscard]] Index triangle_in_crowd(Vec2 p) const {
        Index found = kNone;
        crowd_tree.search([&](const Box& box) { return box.contains(p); },
                          [&](Index k) {
                              if (crowd[k] < found && contains(mesh, crowd[k], p)) found = crowd[k];
                          });
        return found;
    }

    /// The places of the points in the order of their cells.
    [[nodiscard]] Buffer<Index> sorted_by_cell(std::span<const Vec2> points) const {
        Buffer<Index> cell(points.size());
        std::vector<Index> next(std::size_t{cells.count()} + 1);
        for (std::size_t k = 0; k < points.size(); ++k) {
            cell[k] = cells.of(points[k] - mesh.origin);
            ++next[cell[k]];
        }
        std::exclusive_scan(next.begin(), next.end(), next.begin(), Index{0});
        Buffer<Index> order(points.size());
        for (std::size_t k = 0; k < points.size(); ++k)
            order[next[cell[k]]++] = static_cast<Index>(k);
        return order;
    }
};

TriangleLocator::TriangleLocator(const PlaneTriangles& triangles,
                                 std::span<const TriangleSide> boundary)
    : data_(std::make_unique<const Data>(triangles, boundary)) {}
TriangleLocator::TriangleLocator(TriangleLocator&&) noexcept = default;
TriangleLocator& TriangleLocator::operator=(TriangleLocator&&) noexcept = default;
TriangleLocator::~TriangleLocator() = default;

Index TriangleLocator::locate(Vec2 point) const {
    return data_->triangle_at(point - data_->mesh.origin);
}

void TriangleLocator::locate(std::span<const Vec2> points, std::span<Index> triangles) const {
    const Buffer<Index> order = visiting_order(points);
    parallel_for(0, static_cast<std::int64_t>(points.size()), kGrain,
                 [&](std::int64_t begin, std::int64_t end) {
                     for (auto k = static_cast<std::size_t>(begin);
                          k < static_cast<std::size_t>(end); ++k) {
                         const std::size_t query = order.size() > 0 ? order[k] : k;
                         triangles[query] = locate(points[query]);
                     }
                 });
}

Buffer<Index> TriangleLocator::visiting_order(std::span<const Vec2> points) const {
    // Sorting costs a look at every cell.
    const bool many = points.size() >= data_->cells.count() / 8;
    return many ? data_->sorted_by_cell(points) : Buffer<Index>();
}

TrianglePlace TriangleLocator::nearest(Vec2 point) const {
    const Vec2 p = point - data_->mesh.origin;
    if (const Index t = data_->triangle_at(p); t != kNone) return {t, p};
    const NearestEdge border = data_->boundary.nearest(p);
    return {data_->boundary_triangles[border.edge], border.point};
}

}  // namespace relief::mesh
