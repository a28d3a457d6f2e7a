#include "spline/fvs_kernels.h"

#include <algorithm>
#include <cmath>

#include "relief/core/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "spline/fvs_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "spline/fvs_element-inl.h"

HWY_BEFORE_NAMESPACE();
namespace relief::spline {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class T>
SurfaceJet<T> scalar_jet(const T* numbers, T fi, T fj) {
    const auto set = [](double c) { return static_cast<T>(c); };
    const T rest = 1 - fj - fi;
    const bool above = fi > fj;
    const auto pick = [&](T v0, T v1, T v2, T v3) {
        return above ? (rest <= 0 ? v2 : v3) : (rest >= 0 ? v0 : v1);
    };
    return cell_jet(ordinates_of(numbers, set), fj, fi, set, pick);
}

template <class T>
void load_numbers(const FvsKernel<T>& surface, CellIndex<T> row, CellIndex<T> col, T* numbers) {
    for (int k = 0; k < kFvsCellNumbers; ++k) {
        const FvsCellNumber& number = kFvsCell[k];
        const CellIndex<T> stride = surface.stride[number.plane];
        numbers[k] = surface.plane[number.plane][(row + number.row) * stride + col + number.col];
    }
}

template <class T>
void scalar_jets(const FvsKernel<T>& surface, const FvsPoints<T>& points, std::int64_t first,
                 const JetRows<T>& out) {
    for (std::int64_t k = first; k < points.count; ++k) {
        T numbers[kFvsCellNumbers];
        load_numbers(surface, points.row[k], points.col[k], numbers);
        store_jet(scalar_jet(numbers, points.fi[k], points.fj[k]), out, k);
    }
}

template <class T>
void vector_jets(const FvsKernel<T>& surface, const FvsPoints<T>& points, const JetRows<T>& out) {
    const hn::ScalableTag<T> d;
    const hn::Rebind<CellIndex<T>, decltype(d)> di;
    using V = hn::Vec<decltype(d)>;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    const auto set = [d](double c) { return hn::Set(d, static_cast<T>(c)); };
    std::int64_t k = 0;
    for (; k + lanes <= points.count; k += lanes) {
        const V y = hn::LoadU(d, points.fi + k);
        const V x = hn::LoadU(d, points.fj + k);
        const auto row = hn::LoadU(di, points.row + k);
        const auto col = hn::LoadU(di, points.col + k);
        alignas(64) CellIndex<T> rows[hn::MaxLanes(d)];
        alignas(64) CellIndex<T> element[kFvsPlanes][hn::MaxLanes(d)];
        hn::Store(row, di, rows);
        for (int p = 0; p < kFvsPlanes; ++p)
            for (std::int64_t lane = 0; lane < lanes; ++lane)
                element[p][lane] = rows[lane] * surface.stride[p];
        V numbers[kFvsCellNumbers];
        for (int n = 0; n < kFvsCellNumbers; ++n) {
            const auto [plane, down, right] = kFvsCell[n];
            const T* origin = surface.plane[plane] + down * surface.stride[plane] + right;
            numbers[n] = hn::GatherIndex(d, origin, hn::Add(hn::Load(di, element[plane]), col));
        }
        const V rest = set(1) - x - y;
        const auto above = hn::Gt(y, x);
        const auto at_two = hn::Le(rest, hn::Zero(d));
        const auto at_zero = hn::Ge(rest, hn::Zero(d));
        const auto pick = [&](V v0, V v1, V v2, V v3) {
            return hn::IfThenElse(above, hn::IfThenElse(at_two, v2, v3),
                                  hn::IfThenElse(at_zero, v0, v1));
        };
        const SurfaceJet<V> jet = cell_jet(ordinates_of(numbers, set), x, y, set, pick);
        hn::StoreU(jet.value, d, out.value + k);
        if (out.derivatives >= 1) {
            hn::StoreU(jet.di, d, out.di + k);
            hn::StoreU(jet.dj, d, out.dj + k);
        }
        if (out.derivatives >= 2) {
            hn::StoreU(jet.dii, d, out.dii + k);
            hn::StoreU(jet.dij, d, out.dij + k);
            hn::StoreU(jet.djj, d, out.djj + k);
        }
    }
    scalar_jets(surface, points, k, out);
}

/// Left to the compiler to vectorise: every operation is exact. NaN fails the first comparison. The
/// last row and column belong to the cells before them.
template <class T>
void locate(const FvsKernel<T>& surface, std::int64_t count, const T* HWY_RESTRICT i,
            const T* HWY_RESTRICT j, CellIndex<T>* HWY_RESTRICT row, CellIndex<T>* HWY_RESTRICT col,
            T* HWY_RESTRICT fi, T* HWY_RESTRICT fj) {
    for (std::int64_t k = 0; k < count; ++k) {
        const T y = i[k] > surface.first_row ? (i[k] < surface.last_row ? i[k] : surface.last_row)
                                             : surface.first_row;
        const T x = j[k] > surface.first_col ? (j[k] < surface.last_col ? j[k] : surface.last_col)
                                             : surface.first_col;
        const auto r = std::min(static_cast<CellIndex<T>>(y), surface.end_row);
        const auto c = std::min(static_cast<CellIndex<T>>(x), surface.end_col);
        row[k] = r - surface.row0;
        col[k] = c - surface.col0;
        fi[k] = y - static_cast<T>(r);
        fj[k] = x - static_cast<T>(c);
    }
}

template <class V, class Max>
HWY_INLINE V largest_ordinate(const CellOrdinates<V>& b, V zero, Max max) {
    V largest = max(zero, b.centre);
    for (int k = 0; k < 4; ++k)
        for (const V* group : {b.corner, b.first, b.second, b.spoke, b.inner, b.diagonal})
            largest = max(largest, group[k]);
    return largest + zero * b.centre;  // the centre depends on all numbers: NaN if one is
}

template <class T>
void scalar_bounds(const std::array<const T*, kFvsCellNumbers>& numbers, T a, T b,
                   std::int64_t first, std::int64_t cells, T* bounds) {
    const T scales[4] = {1, a, b, 0};
    const T side_scales[4] = {b, a, b, a};
    for (std::int64_t c = first; c < cells; ++c) {
        T n[kFvsCellNumbers];
        for (int k = 0; k < kFvsCellNumbers; ++k)
            n[k] = (k < 12 ? scales[k / 4] : side_scales[k - 12]) * numbers[k][c];
        bounds[c] = largest_ordinate(ordinates_of(n, [](double v) { return static_cast<T>(v); }),
                                     T(0), [](T v, T w) { return std::max(v, std::abs(w)); });
    }
}

template <class T>
void vector_bounds(const std::array<const T*, kFvsCellNumbers>& numbers, T a, T b,
                   std::int64_t cells, T* bounds) {
    const hn::ScalableTag<T> d;
    using V = hn::Vec<decltype(d)>;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    const auto set = [d](double c) { return hn::Set(d, static_cast<T>(c)); };
    const T scales[4] = {1, a, b, 0};
    const T side_scales[4] = {b, a, b, a};
    std::int64_t c = 0;
    for (; c + lanes <= cells; c += lanes) {
        V n[kFvsCellNumbers];
        for (int k = 0; k < kFvsCellNumbers; ++k)
            n[k] = hn::Set(d, k < 12 ? scales[k / 4] : side_scales[k - 12]) *
                   hn::LoadU(d, numbers[k] + c);
        const V largest = largest_ordinate(ordinates_of(n, set), hn::Zero(d),
                                           [](V v, V w) { return hn::Max(v, hn::Abs(w)); });
        hn::StoreU(largest, d, bounds + c);
    }
    scalar_bounds(numbers, a, b, c, cells, bounds);
}

#define RELIEF_FVS_KERNELS(T, S)                                                              \
    void vector_jets_##S(const FvsKernel<T>& s, const FvsPoints<T>& p, const JetRows<T>& o) { \
        vector_jets(s, p, o);                                                                 \
    }                                                                                         \
    void locate_##S(const FvsKernel<T>& s, std::int64_t n, const T* i, const T* j,            \
                    CellIndex<T>* r, CellIndex<T>* c, T* fi, T* fj) {                         \
        locate(s, n, i, j, r, c, fi, fj);                                                     \
    }                                                                                         \
    void vector_bounds_##S(const std::array<const T*, kFvsCellNumbers>& n, T a, T b,          \
                           std::int64_t c, T* o) {                                            \
        vector_bounds(n, a, b, c, o);                                                         \
    }
RELIEF_FVS_KERNELS(float, f)
RELIEF_FVS_KERNELS(double, d)
#undef RELIEF_FVS_KERNELS

}  // namespace HWY_NAMESPACE
}  // namespace relief::spline
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace relief::spline {

namespace {

constexpr int kTriangleOrdinates = 10;
using Numbers = std::array<double, kFvsCellNumbers>;

double number(double c) {
    return c;
}

/// The multi-index (p, q, r) of each ordinate of a cubic triangle.
constexpr int kIndex[kTriangleOrdinates][3] = {{3, 0, 0}, {2, 1, 0}, {2, 0, 1}, {1, 2, 0},
                                               {1, 1, 1}, {1, 0, 2}, {0, 3, 0}, {0, 2, 1},
                                               {0, 1, 2}, {0, 0, 3}};
constexpr double kFactorial[] = {1, 1, 2, 6, 24, 120, 720};

/// The integral of the product of two cubic Bernstein polynomials over a triangle of area 1:
/// 2 C(3, p) C(3, q) (p + q)! / 8!.
double bernstein_product(const int* p, const int* q) {
    double product = 2 / 40320.0;
    for (const int* index : {p, q})
        product *= 6 / (kFactorial[index[0]] * kFactorial[index[1]] * kFactorial[index[2]]);
    for (int k = 0; k < 3; ++k) product *= kFactorial[p[k] + q[k]];
    return product;
}

std::array<Numbers, kFvsCellNumbers> integrate_products() {
    HWY_NAMESPACE::CellOrdinates<double> basis[kFvsCellNumbers];
    for (int k = 0; k < kFvsCellNumbers; ++k) {
        Numbers unit{};
        unit[k] = 1;
        basis[k] = HWY_NAMESPACE::ordinates_of(unit.data(), number);
    }
    std::array<Numbers, kFvsCellNumbers> mass{};
    for (int t = 0; t < 4; ++t) {
        double net[kFvsCellNumbers][kTriangleOrdinates];
        for (int k = 0; k < kFvsCellNumbers; ++k) {
            const auto& b = basis[k];
            const int next = (t + 1) % 4;
            const double ordinates[] = {
                b.corner[t],   b.first[t],     b.spoke[t],    b.second[t],      b.inner[t],
                b.diagonal[t], b.corner[next], b.spoke[next], b.diagonal[next], b.centre};
            std::copy_n(ordinates, kTriangleOrdinates, net[k]);
        }
        for (int m = 0; m < kFvsCellNumbers; ++m)
            for (int n = 0; n < kFvsCellNumbers; ++n)
                for (int p = 0; p < kTriangleOrdinates; ++p)
                    for (int q = 0; q < kTriangleOrdinates; ++q)
                        mass[m][n] += net[m][p] * net[n][q] *
                                      (0.25 * bernstein_product(kIndex[p], kIndex[q]));
    }
    return mass;
}

}  // namespace

std::array<double, kFvsCellNumbers> fvs_value_weights(double i, double j) {
    Numbers weights{};
    for (int k = 0; k < kFvsCellNumbers; ++k) {
        Numbers unit{};
        unit[k] = 1;
        weights[k] = HWY_NAMESPACE::scalar_jet(unit.data(), i, j).value;
    }
    return weights;
}

const std::array<std::array<double, kFvsCellNumbers>, kFvsCellNumbers>& fvs_cell_mass() {
    static const auto mass = integrate_products();
    return mass;
}

template <class T>
SurfaceJet<T> fvs_jet_at(const FvsGridView<const T>& grid, std::int64_t row, std::int64_t col, T fi,
                         T fj) {
    T numbers[kFvsCellNumbers];
    for (int k = 0; k < kFvsCellNumbers; ++k)
        numbers[k] = grid[kFvsCell[k].plane](row + kFvsCell[k].row, col + kFvsCell[k].col);
    return HWY_NAMESPACE::scalar_jet(numbers, fi, fj);
}

template <class T>
void fvs_ordinate_bounds(const FvsGridView<const T>& grid, GridView<T> bounds) {
    for (std::int64_t r = 0; r < bounds.rows; ++r) {
        std::array<const T*, kFvsCellNumbers> numbers;
        for (std::size_t k = 0; k < kFvsCellNumbers; ++k)
            numbers[k] = grid[kFvsCell[k].plane].row(r + kFvsCell[k].row) + kFvsCell[k].col;
        fvs_ordinate_bounds_row(numbers, static_cast<T>(grid.a), static_cast<T>(grid.b),
                                bounds.cols, bounds.row(r));
    }
}

#define RELIEF_EXPORT(T, S)                                                                       \
    HWY_EXPORT(vector_jets_##S);                                                                  \
    HWY_EXPORT(locate_##S);                                                                       \
    HWY_EXPORT(vector_bounds_##S);                                                                \
    template <>                                                                                   \
    void fvs_jets_at(const FvsKernel<T>& surface, const FvsPoints<T>& points,                     \
                     const JetRows<T>& out) {                                                     \
        simd_enabled() ? HWY_DYNAMIC_DISPATCH(vector_jets_##S)(surface, points, out)              \
                       : HWY_NAMESPACE::scalar_jets(surface, points, 0, out);                     \
    }                                                                                             \
    template <>                                                                                   \
    void locate_fvs_points(const FvsKernel<T>& surface, std::int64_t count, const T* i,           \
                           const T* j, CellIndex<T>* row, CellIndex<T>* col, T* fi, T* fj) {      \
        simd_enabled() ? HWY_DYNAMIC_DISPATCH(locate_##S)(surface, count, i, j, row, col, fi, fj) \
                       : HWY_NAMESPACE::locate(surface, count, i, j, row, col, fi, fj);           \
    }                                                                                             \
    template <>                                                                                   \
    void fvs_ordinate_bounds_row(const std::array<const T*, kFvsCellNumbers>& numbers, T a, T b,  \
                                 std::int64_t cells, T* bounds) {                                 \
        simd_enabled() ? HWY_DYNAMIC_DISPATCH(vector_bounds_##S)(numbers, a, b, cells, bounds)    \
                       : HWY_NAMESPACE::scalar_bounds(numbers, a, b, 0, cells, bounds);           \
    }                                                                                             \
    template void fvs_ordinate_bounds(const FvsGridView<const T>&, GridView<T>);                  \
    template SurfaceJet<T> fvs_jet_at(const FvsGridView<const T>&, std::int64_t, std::int64_t, T, \
                                      T);
RELIEF_EXPORT(float, f)
RELIEF_EXPORT(double, d)
#undef RELIEF_EXPORT

}  // namespace relief::spline
#endif  // HWY_ONCE
