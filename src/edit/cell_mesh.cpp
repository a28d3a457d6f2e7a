#include "edit/cell_mesh.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <iterator>

namespace relief::edit {

using mesh::Index;

namespace {

/// The smallest cell of each edge.
std::vector<Index> first_cells(const CellMesh& mesh) {
    std::vector<Index> first(mesh.edges.size(), mesh::kNone);
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
        for (std::size_t i = 0; i < mesh.sides; ++i) {
            Index& cell = first[mesh.cell_edges[c][i]];
            cell = std::min(cell, static_cast<Index>(c));
        }
    return first;
}

template <std::size_t kSides>
std::vector<std::array<Index, 4>> padded(const std::vector<std::array<Index, kSides>>& lists) {
    std::vector<std::array<Index, 4>> out(lists.size());
    for (std::size_t k = 0; k < lists.size(); ++k)
        std::copy(lists[k].begin(), lists[k].end(), out[k].begin());
    return out;
}

template <class Mesh>
std::vector<Vec2> places(const Mesh& mesh) {
    std::vector<Vec2> out(mesh.x.size());
    for (Index v = 0; v < out.size(); ++v) out[v] = mesh.vertex(v);
    return out;
}

}  // namespace

CellMesh::CellMesh(const mesh::Triangulation& mesh)
    : sides(3),
      origin(mesh.origin),
      vertices(places(mesh)),
      cells(padded(mesh.triangles)),
      cell_edges(padded(mesh.triangle_edges)),
      edges(mesh.edges),
      edge_cell(first_cells(*this)),
      vertex_cells(mesh::vertex_triangles(mesh)) {}

CellMesh::CellMesh(const mesh::Quadrangulation& mesh)
    : sides(4),
      origin(mesh.origin),
      vertices(places(mesh)),
      cells(mesh.quads),
      cell_edges(mesh.quad_edges),
      edges(mesh.edges),
      edge_cell(first_cells(*this)) {
    mesh::VertexQuads quads = mesh::vertex_quads(mesh);
    vertex_cells = {std::move(quads.first), std::move(quads.quads)};
}

std::vector<Index> CellMesh::neighbours(Index v) const {
    std::vector<Index> found;
    for (const Index c : vertex_cells.of(v)) {
        const auto& corners = cells[c];
        const std::size_t k = static_cast<std::size_t>(
            std::find(corners.begin(), corners.end(), v) - corners.begin());
        found.push_back(corners[(k + 1) % sides]);
        found.push_back(corners[(k + sides - 1) % sides]);
    }
    sort_unique(found, vertices.size());
    return found;
}

std::vector<Index> CellMesh::cells_at(const std::vector<Index>& some) const {
    std::vector<Index> found;
    for (const Index v : some) {
        const auto star = vertex_cells.of(v);
        found.insert(found.end(), star.begin(), star.end());
    }
    sort_unique(found, cells.size());
    return found;
}

std::vector<Index> CellMesh::edges_at(const std::vector<Index>& some) const {
    std::vector<Index> found;
    for (const Index v : some)
        for (const Index c : vertex_cells.of(v))
            for (std::size_t i = 0; i < sides; ++i)
                if (cells[c][i] == v || cells[c][(i + 1) % sides] == v)
                    found.push_back(cell_edges[c][i]);
    sort_unique(found, edges.size());
    return found;
}

std::vector<Index> CellMesh::corners_of(const std::vector<Index>& some) const {
    std::vector<Index> found;
    for (const Index c : some)
        found.insert(found.end(), cells[c].begin(), cells[c].begin() + std::ptrdiff_t(sides));
    sort_unique(found, vertices.size());
    return found;
}

void sort_unique(std::vector<Index>& numbers, std::size_t end) {
    constexpr std::size_t kBits = 64;
    if (numbers.size() < end / kBits) {
        std::sort(numbers.begin(), numbers.end());
        numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
        return;
    }
    std::vector<std::uint64_t> present(end / kBits + 1);
    for (const Index number : numbers)
        present[number / kBits] |= std::uint64_t{1} << number % kBits;
    numbers.clear();
    for (std::size_t word = 0; word < present.size(); ++word)
        for (std::uint64_t bits = present[word]; bits != 0; bits &= bits - 1)
            numbers.push_back(
                static_cast<Index>(word * kBits + std::size_t(std::countr_zero(bits))));
}

std::vector<Index> merged(const std::vector<Index>& a, const std::vector<Index>& b) {
    std::vector<Index> both;
    both.reserve(a.size() + b.size());
    std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
    return both;
}

}  // namespace relief::edit
