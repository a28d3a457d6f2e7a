#include "edit/cell_grid.h"

#include <algorithm>
#include <cmath>

namespace relief::edit {

using mesh::Index;

namespace {

constexpr double kMostTriangles = 300000;
constexpr double kMostCuts = 32;

std::size_t cuts_of(const CellMesh& mesh) {
    const double whole = static_cast<double>(mesh.cells.size() * (mesh.sides - 2));
    return static_cast<std::size_t>(std::clamp(std::sqrt(kMostTriangles / whole), 1.0, kMostCuts));
}

}  // namespace

CellGrid::CellGrid(const CellMesh& mesh) : mesh_(&mesh), cuts_(cuts_of(mesh)) {
    inner_row_.assign(1, 0);
    for (std::size_t b = 1; b < cuts_; ++b) {
        inner_row_.push_back(inner_.size());
        for (std::size_t a = 1; a + 1 < row_length(b); ++a) inner_.push_back({a, b});
    }
}

Vec2 CellGrid::edge_place(Index e, std::size_t k) const {
    const auto [from, to] = mesh_->edges[e];
    const Vec2 start = mesh_->vertices[from];
    return start + edge_part(k) * (mesh_->vertices[to] - start);
}

Vec2 CellGrid::cell_place(Index c, std::size_t k) const {
    const double u = static_cast<double>(inner_[k].a) / static_cast<double>(cuts_);
    const double v = static_cast<double>(inner_[k].b) / static_cast<double>(cuts_);
    const auto corner = [&](std::size_t i) { return mesh_->vertices[mesh_->cells[c][i]]; };
    if (mesh_->sides == 3)
        return corner(0) + (u * (corner(1) - corner(0)) + v * (corner(2) - corner(0)));
    const Vec2 low = corner(0) + u * (corner(1) - corner(0));
    const Vec2 high = corner(3) + u * (corner(2) - corner(3));
    return low + v * (high - low);
}

std::uint32_t CellGrid::side_point(Index c, std::size_t side, std::size_t k) const {
    if (k == 0) return mesh_->cells[c][side];
    if (k == cuts_) return mesh_->cells[c][(side + 1) % mesh_->sides];
    return edge_point(mesh_->cell_edges[c][side],
                      (mesh_->runs_forward(c, side) ? k : cuts_ - k) - 1);
}

std::uint32_t CellGrid::point(Index c, Step at) const {
    const std::size_t last = row_length(at.b) - 1;
    if (at.b == 0) return side_point(c, 0, at.a);
    if (at.a == last) return side_point(c, 1, at.b);
    if (at.a == 0) return side_point(c, mesh_->sides - 1, cuts_ - at.b);
    if (at.b == cuts_) return side_point(c, 2, cuts_ - at.a);
    return cell_point(c, inner_row_[at.b] + at.a - 1);
}

std::vector<std::uint32_t> CellGrid::triangles() const {
    std::vector<std::uint32_t> corners;
    corners.reserve(3 * mesh_->cells.size() * (mesh_->sides - 2) * cuts_ * cuts_);
    for (Index c = 0; c < mesh_->cells.size(); ++c)
        for (std::size_t b = 0; b < cuts_; ++b)
            for (std::size_t a = 0; a + 1 < row_length(b); ++a) {
                const std::uint32_t next = point(c, {a + 1, b});
                const std::uint32_t above = point(c, {a, b + 1});
                corners.insert(corners.end(), {point(c, {a, b}), next, above});
                if (a + 1 < row_length(b + 1))
                    corners.insert(corners.end(), {next, point(c, {a + 1, b + 1}), above});
            }
    return corners;
}

std::vector<std::uint32_t> CellGrid::lines() const {
    std::vector<std::uint32_t> ends;
    ends.reserve(2 * mesh_->edges.size() * cuts_);
    for (Index e = 0; e < mesh_->edges.size(); ++e) {
        std::uint32_t last = mesh_->edges[e][0];
        for (std::size_t k = 0; k < edge_points(); ++k) {
            ends.insert(ends.end(), {last, edge_point(e, k)});
            last = edge_point(e, k);
        }
        ends.insert(ends.end(), {last, mesh_->edges[e][1]});
    }
    return ends;
}

}  // namespace relief::edit
