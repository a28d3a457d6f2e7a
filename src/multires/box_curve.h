#pragma once

#include <cstdint>
#include <vector>

/// Rasters of one row or one column: the boundary curves of the surface scheme (cubic B-splines for
/// order 2), with their own update weights.
namespace relief::multires::box {

/// Elements `step` apart.
template <class T>
struct Line {
    T* data;
    std::int64_t size;
    std::int64_t step;

    T& operator[](std::int64_t k) const { return data[k * step]; }
};

/// Update factors of the edges of one level, collapsed in the middle like those of UpdateFactors.
using CurveFactors = std::vector<double>;

/// The factors of levels 1 .. levels of n samples. Time and memory O(levels).
[[nodiscard]] std::vector<CurveFactors> curve_factors(int order, std::int64_t n, int levels);

/// vertices.size == fine.size / 2 + 1, edges.size == vertices.size - 1.
template <class T>
void analyse_curve(int order, const CurveFactors& factors, Line<const T> fine, Line<T> vertices,
                   Line<T> edges);

template <class T>
void synthesise_curve(int order, const CurveFactors& factors, Line<const T> vertices,
                      Line<const T> edges, Line<T> fine);

/// The transpose of synthesise_curve: from fine residuals to both outputs.
template <class T>
void transpose_curve(int order, const CurveFactors& factors, Line<const T> fine, Line<T> vertices,
                     Line<T> edges);

}  // namespace relief::multires::box
