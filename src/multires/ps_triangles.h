#pragma once

#include <algorithm>
#include <vector>

#include "multires/ps_errors.h"
#include "relief/multires/ps_space.h"

/// Loops over triangles, their B-splines, and their pieces at edges.
namespace relief::multires::ps {

/// Calls local(t) for all triangles from several threads, and scatter(t, result) in their order;
/// some thousand results are held at a time.
template <class Result, class Local, class Scatter>
void each_triangle(mesh::Index count, Local&& local, Scatter&& scatter) {
    constexpr mesh::Index kChunk = 8192;
    std::vector<Result> results(std::min(count, kChunk));
    for (mesh::Index begin = 0; begin < count; begin += kChunk) {
        const mesh::Index size = std::min(kChunk, count - begin);
        for_each_index(size, [&](mesh::Index k) { results[k] = local(begin + k); });
        for (mesh::Index k = 0; k < size; ++k) scatter(begin + k, results[k]);
    }
}

/// The nine B-splines of the corners of a triangle.
using BasisPolynomials = std::array<spline::PsPolynomials, 9>;
[[nodiscard]] inline BasisPolynomials basis_polynomials(const Space& space, mesh::Index t) {
    const spline::PsElement element = space.element(t);
    const spline::PsBasis basis = space.basis(t);
    BasisPolynomials polynomials;
    for (std::size_t i = 0; i < 9; ++i) {
        std::array<spline::TangentPlane, 3> planes{};
        planes[i / 3] = basis[i];
        polynomials[i] = element.polynomials(planes);
    }
    return polynomials;
}

/// Which edge of triangle t edge e is.
[[nodiscard]] inline mesh::Index side_of(const mesh::Triangulation& mesh, mesh::Index t,
                                         mesh::Index e) {
    mesh::Index k = 0;
    while (mesh.triangle_edges[t][k] != e) ++k;
    return k;
}

/// The pieces of a triangle at an edge, that at its lower end first.
[[nodiscard]] inline std::array<int, 2> pieces_at(const mesh::Triangulation& mesh, mesh::Index t,
                                                  mesh::Index e) {
    const mesh::Index k = side_of(mesh, t, e);
    const int first = 2 * static_cast<int>(k);
    if (mesh.runs_forward(t, k)) return {first, first + 1};
    return {first + 1, first};
}

}  // namespace relief::multires::ps
