#include "relief/multires/ps_energy.h"

#include <algorithm>

#include "multires/ps_triangles.h"

namespace relief::multires::ps {

using mesh::Index;
using mesh::kNone;
using spline::PsElement;
using spline::PsMatrix;
using spline::PsPolynomials;

namespace {

/// Sums of the triangles' matrices.
template <class ElementMatrix>
BlockMatrix assemble(const Space& space, ElementMatrix element_matrix) {
    BlockMatrix matrix(mesh::vertex_neighbours(space.mesh));
    each_triangle<PsMatrix>(
        space.mesh.triangle_count(),
        [&](Index t) { return element_matrix(space.element(t), space.basis(t)); },
        [&](Index t, const PsMatrix& element) { matrix.add(space.mesh.triangles[t], element); });
    return matrix;
}

PsPolynomials polynomials(const Space& space, const TangentPlanes& planes, Index t) {
    const auto& v = space.mesh.triangles[t];
    return space.element(t).polynomials(std::array{planes[v[0]], planes[v[1]], planes[v[2]]});
}

}  // namespace

BlockMatrix::BlockMatrix(const mesh::VertexStars& coupled) {
    first.push_back(0);
    for (Index v = 0; v + 1 < coupled.first.size(); ++v) {
        const auto others = coupled.of(v);
        const auto above = std::lower_bound(others.begin(), others.end(), v);
        column.insert(column.end(), others.begin(), above);
        column.push_back(v);
        column.insert(column.end(), above, others.end());
        first.push_back(column.size());
    }
    block.resize(column.size());
}

const BlockMatrix::Block* BlockMatrix::find(Index row, Index col) const {
    const auto in_row = columns(row);
    const auto at = std::lower_bound(in_row.begin(), in_row.end(), col);
    if (at == in_row.end() || *at != col) return nullptr;
    return &block[first[row] + static_cast<std::size_t>(at - in_row.begin())];
}

BlockMatrix::Block& BlockMatrix::at(Index row, Index col) {
    const auto in_row = columns(row);
    const auto place = std::lower_bound(in_row.begin(), in_row.end(), col) - in_row.begin();
    return block[first[row] + static_cast<std::size_t>(place)];
}

void BlockMatrix::add(const std::array<Index, 3>& vertices, const PsMatrix& element) {
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            Block& sum = at(vertices[i], vertices[k]);
            for (int j = 0; j < 3; ++j)
                for (int l = 0; l < 3; ++l) sum[3 * j + l] += element[9 * (3 * i + j) + 3 * k + l];
        }
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
