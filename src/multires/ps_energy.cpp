#include "relief/multires/ps_energy.h"

#include <algorithm>

#include "multires/ps_errors.h"

namespace relief::multires::ps {

using mesh::Index;
using mesh::kNone;
using spline::PsElement;
using spline::PsMatrix;
using spline::PsPolynomials;

namespace {

constexpr std::size_t kChunk = 8192;  ///< triangles whose matrices are held at a time

BlockMatrix empty_matrix(const mesh::Triangulation& mesh) {
    const mesh::VertexStars neighbours = mesh::vertex_neighbours(mesh);
    BlockMatrix matrix;
    matrix.first.push_back(0);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        const auto others = neighbours.of(v);
        const auto above = std::lower_bound(others.begin(), others.end(), v);
        matrix.column.insert(matrix.column.end(), others.begin(), above);
        matrix.column.push_back(v);
        matrix.column.insert(matrix.column.end(), above, others.end());
        matrix.first.push_back(matrix.column.size());
    }
    matrix.block.resize(matrix.column.size());
    return matrix;
}

void add_element(const std::array<Index, 3>& vertices, const PsMatrix& element,
                 BlockMatrix& matrix) {
    for (int i = 0; i < 3; ++i) {
        const auto columns = matrix.columns(vertices[i]);
        for (int k = 0; k < 3; ++k) {
            const auto at = std::find(columns.begin(), columns.end(), vertices[k]);
            auto& block =
                matrix.block[matrix.first[vertices[i]] + std::size_t(at - columns.begin())];
            for (int j = 0; j < 3; ++j)
                for (int l = 0; l < 3; ++l)
                    block[3 * j + l] += element[9 * (3 * i + j) + 3 * k + l];
        }
    }
}

/// Sums of the triangles' matrices, always in the order of triangles.
template <class ElementMatrix>
BlockMatrix assemble(const Space& space, ElementMatrix element_matrix) {
    BlockMatrix matrix = empty_matrix(space.mesh);
    std::vector<PsMatrix> elements(std::min(kChunk, space.mesh.triangles.size()));
    for (std::size_t begin = 0; begin < space.mesh.triangles.size(); begin += kChunk) {
        const std::size_t count = std::min(kChunk, space.mesh.triangles.size() - begin);
        for_each_index(count, [&](Index k) {
            const auto t = static_cast<Index>(begin + k);
            elements[k] = element_matrix(space.element(t), space.basis(t));
        });
        for (std::size_t k = 0; k < count; ++k)
            add_element(space.mesh.triangles[begin + k], elements[k], matrix);
    }
    return matrix;
}

PsPolynomials polynomials(const Space& space, const TangentPlanes& planes, Index t) {
    const auto& v = space.mesh.triangles[t];
    return space.element(t).polynomials(std::array{planes[v[0]], planes[v[1]], planes[v[2]]});
}

/// The pieces of a triangle at an edge, that at its lower end first.
std::array<int, 2> pieces_at(const mesh::Triangulation& mesh, Index t, Index e) {
    Index k = 0;
    while (mesh.triangle_edges[t][k] != e) ++k;
    const int first = 2 * static_cast<int>(k);
    if (mesh.runs_forward(t, k)) return {first, first + 1};
    return {first + 1, first};
}

}  // namespace

const BlockMatrix::Block* BlockMatrix::find(Index row, Index col) const {
    const auto in_row = columns(row);
    const auto at = std::find(in_row.begin(), in_row.end(), col);
    return at == in_row.end() ? nullptr : &block[first[row] + std::size_t(at - in_row.begin())];
}

Coefficients BlockMatrix::times(std::span<const Heights> spline) const {
    Coefficients product(rows());
    for_each_index(rows(), [&](Index row) {
        for (std::size_t k = first[row]; k < first[row + 1]; ++k)
            for (int j = 0; j < 3; ++j)
                for (int l = 0; l < 3; ++l)
                    product[row][j] += block[k][3 * j + l] * spline[column[k]][l];
    });
    return product;
}

BlockMatrix gram_matrix(const Space& space) {
    return assemble(space, [](const PsElement& element, const spline::PsBasis& basis) {
        return element.mass_matrix(basis);
    });
}

BlockMatrix thin_plate_matrix(const Space& space) {
    return assemble(space, [](const PsElement& element, const spline::PsBasis& basis) {
        return element.thin_plate_matrix(basis);
    });
}

double thin_plate_energy(const Space& space, std::span<const Heights> spline) {
    const TangentPlanes planes = tangent_planes(space, spline);
    double energy = 0;
    for (Index t = 0; t < space.mesh.triangle_count(); ++t)
        energy += space.element(t).thin_plate_energy(polynomials(space, planes, t));
    return energy;
}

double jump_energy(const Space& space, std::span<const Heights> spline) {
    const mesh::Triangulation& mesh = space.mesh;
    const TangentPlanes planes = tangent_planes(space, spline);
    double energy = 0;
    for (Index t = 0; t < mesh.triangle_count(); ++t)
        energy += space.element(t).inner_jump_energy(polynomials(space, planes, t));
    for (Index e = 0; e < mesh.edge_count(); ++e) {
        if (mesh.on_boundary(e)) continue;
        const auto [left, right] = mesh.edge_triangles[e];
        const auto here = pieces_at(mesh, left, e);
        const auto there = pieces_at(mesh, right, e);
        const PsPolynomials a = polynomials(space, planes, left);
        const PsPolynomials b = polynomials(space, planes, right);
        const Vec2 middle = edge_point(mesh, space.split, e);
        for (int end = 0; end < 2; ++end)
            energy += spline::jump_energy(mesh.vertex(mesh.edges[e][end]), middle,
                                          a.hessian[here[end]], b.hessian[there[end]]);
    }
    return energy;
}

std::vector<std::array<Moments, 3>> moments(const Space& space, const BlockMatrix& gram) {
    std::vector<std::array<Moments, 3>> all(space.mesh.vertex_count());
    for_each_index(all.size(), [&](Index v) {
        for (std::size_t k = gram.first[v]; k < gram.first[v + 1]; ++k) {
            const Index w = gram.column[k];
            const Vec2 way = space.mesh.vertex(w) - space.mesh.vertex(v);
            for (int j = 0; j < 3; ++j)
                for (int l = 0; l < 3; ++l) {
                    const double product = gram.block[k][3 * j + l];
                    all[v][j].mass += product;
                    all[v][j].first = all[v][j].first + product * (way + space.control[w][l]);
                }
        }
    });
    return all;
}

}  // namespace relief::multires::ps
