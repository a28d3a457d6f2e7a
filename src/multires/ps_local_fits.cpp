#include "multires/ps_local_fits.h"

#include <cmath>
#include <limits>

#include "relief/core/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "multires/ps_local_fits.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace relief::multires::ps {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Columns of the design matrix: dx, dy, dx^2, dx dy, dy^2, dx^3, dx^2 dy, dx dy^2, dy^3.
constexpr std::size_t kColumns = 9;
constexpr std::size_t kQuadraticColumns = 5;
constexpr double kNear = 1e-3;       ///< keeps the weight of near points finite
constexpr double kFlat = 1e-12;      ///< of the trace, so that collinear stencils have a plane
constexpr double kDependent = 1e-8;  ///< a column that keeps less of its square depends on others
constexpr double kLeastFreedom = 0.02;  ///< of 1 - leverage
constexpr double kUndetermined = 0.05;  ///< a free constant needs so much of its own square

/// Vectors of a target.
struct VectorOps {
    using Tag = hn::CappedTag<double, kFitLanes>;
    using V = hn::Vec<Tag>;
    static std::size_t lanes() { return hn::Lanes(Tag()); }
    static V load(const double* p) { return hn::Load(Tag(), p); }
    static void store(V v, double* p) { hn::Store(v, Tag(), p); }
    static V set(double c) { return hn::Set(Tag(), c); }
    static V add(V a, V b) { return hn::Add(a, b); }
    static V sub(V a, V b) { return hn::Sub(a, b); }
    static V mul(V a, V b) { return hn::Mul(a, b); }
    static V div(V a, V b) { return hn::Div(a, b); }
    static V max(V a, V b) { return hn::Max(a, b); }
    static V sqrt(V a) { return hn::Sqrt(a); }
    /// a > b ? yes : no
    static V choose(V a, V b, V yes, V no) { return hn::IfThenElse(hn::Gt(a, b), yes, no); }
};

/// Their scalar twin.
struct ScalarOps {
    using V = double;
    static std::size_t lanes() { return 1; }
    static V load(const double* p) { return *p; }
    static void store(V v, double* p) { *p = v; }
    static V set(double c) { return c; }
    static V add(V a, V b) { return a + b; }
    static V sub(V a, V b) { return a - b; }
    static V mul(V a, V b) { return a * b; }
    static V div(V a, V b) { return a / b; }
    static V max(V a, V b) { return a > b ? a : b; }
    static V sqrt(V a) { return std::sqrt(a); }
    static V choose(V a, V b, V yes, V no) { return a > b ? yes : no; }
};

/// Some lanes of the stencils.
template <class Ops>
class Fitter {
    using V = typename Ops::V;

  public:
    Fitter(const FitStencils& stencils, std::size_t lane, LocalFits& fits)
        : in_(stencils), lane_(lane), out_(fits) {}

    void run() {
        weigh();
        fit_plane();
        fill_columns();
        V alive = Ops::set(1);
        for (std::size_t c = 0; c < kQuadraticColumns; ++c) alive = orthogonalise(c, alive);
        finish(kQuadratic, kQuadraticColumns, 7, alive);
        predict_without();
        for (std::size_t c = kQuadraticColumns; c < kColumns; ++c) alive = orthogonalise(c, alive);
        finish(kCubic, kColumns, 11, alive);
    }

  private:
    [[nodiscard]] V at(const double (*rows)[kFitLanes], std::size_t q) const {
        return Ops::load(rows[q] + lane_);
    }
    static V add_product(V sum, V a, V b) { return Ops::add(sum, Ops::mul(a, b)); }

    /// r2 = |d|^2 + 1e-3, the weights 1 / r2 of rows, and the sum of them.
    void weigh() {
        sum_weights_ = Ops::set(0);
        V zero = Ops::set(0);
        for (std::size_t q = 0; q < in_.rows; ++q) {
            const V dx = at(in_.dx, q);
            const V dy = at(in_.dy, q);
            const V z = at(in_.dz, q);
            const V r2 = Ops::add(add_product(Ops::mul(dx, dx), dy, dy), Ops::set(kNear));
            const V weight = Ops::div(at(in_.present, q), r2);
            Ops::store(r2, r2_[q]);
            Ops::store(weight, weight_[q]);
            sum_weights_ = Ops::add(sum_weights_, weight);
            zero = add_product(zero, Ops::mul(z, z), weight);
        }
        Ops::store(Ops::div(zero, sum_weights_), out_.zero_error + lane_);
    }

    /// The plane through the vertex, all points alike, and what the plane with a free constant says
    /// of the vertex.
    void fit_plane() {
        V xx = Ops::set(0), xy = xx, yy = xx, x = xx, y = xx, xz = xx, yz = xx, z = xx;
        for (std::size_t q = 0; q < in_.rows; ++q) {
            const V dx = at(in_.dx, q);
            const V dy = at(in_.dy, q);
            const V dz = at(in_.dz, q);
            xx = add_product(xx, dx, dx);
            xy = add_product(xy, dx, dy);
            yy = add_product(yy, dy, dy);
            xz = add_product(xz, dx, dz);
            yz = add_product(yz, dy, dz);
            x = Ops::add(x, dx);
            y = Ops::add(y, dy);
            z = Ops::add(z, dz);
        }
        const V more = Ops::mul(Ops::set(kFlat), Ops::add(xx, yy));
        xx = Ops::add(xx, more);
        yy = Ops::add(yy, more);
        const V determinant = Ops::sub(Ops::mul(xx, yy), Ops::mul(xy, xy));
        const V a = Ops::div(yy, determinant);
        const V b = Ops::div(Ops::sub(Ops::set(0), xy), determinant);
        const V c = Ops::div(xx, determinant);
        const V gx = add_product(Ops::mul(a, xz), b, yz);
        const V gy = add_product(Ops::mul(b, xz), c, yz);
        Ops::store(gx, out_.gradient[kLinear][0] + lane_);
        Ops::store(gy, out_.gradient[kLinear][1] + lane_);
        V error = Ops::set(0);
        for (std::size_t q = 0; q < in_.rows; ++q) {
            const V dx = at(in_.dx, q);
            const V dy = at(in_.dy, q);
            const V leverage = add_product(Ops::mul(dx, add_product(Ops::mul(a, dx), b, dy)), dy,
                                           add_product(Ops::mul(b, dx), c, dy));
            const V residual = Ops::sub(at(in_.dz, q), add_product(Ops::mul(gx, dx), gy, dy));
            const V e = left_out(residual, leverage);
            error = add_product(error, Ops::mul(e, e), Ops::load(weight_[q]));
        }
        Ops::store(Ops::div(error, sum_weights_), out_.error[kLinear] + lane_);
        const V ux = add_product(Ops::mul(a, x), b, y);
        const V uy = add_product(Ops::mul(b, x), c, y);
        const V count = Ops::load(in_.count + lane_);
        const V free = Ops::sub(count, add_product(Ops::mul(ux, x), uy, y));
        const V off = Ops::sub(z, add_product(Ops::mul(ux, xz), uy, yz));
        plain_ = Ops::choose(free, Ops::mul(Ops::set(kUndetermined), count), Ops::div(off, free),
                             Ops::set(0));
        Ops::store(plain_, out_.plain + lane_);
    }

    static V left_out(V residual, V leverage) {
        return Ops::div(residual,
                        Ops::max(Ops::sub(Ops::set(1), leverage), Ops::set(kLeastFreedom)));
    }

    void fill_columns() {
        for (std::size_t q = 0; q < in_.rows; ++q) {
            const V weight = Ops::load(weight_[q]);
            const V dx = at(in_.dx, q);
            const V dy = at(in_.dy, q);
            const V wx = Ops::mul(weight, dx);
            const V wy = Ops::mul(weight, dy);
            const V wxx = Ops::mul(wx, dx);
            const V wxy = Ops::mul(wx, dy);
            const V wyy = Ops::mul(wy, dy);
            const V all[kColumns] = {wx,
                                     wy,
                                     wxx,
                                     wxy,
                                     wyy,
                                     Ops::mul(wxx, dx),
                                     Ops::mul(wxx, dy),
                                     Ops::mul(wyy, dx),
                                     Ops::mul(wyy, dy)};
            for (std::size_t c = 0; c < kColumns; ++c) Ops::store(all[c], column_[c][q]);
            Ops::store(Ops::mul(weight, at(in_.dz, q)), column_[kData][q]);
            Ops::store(weight, column_[kConstant][q]);
            Ops::store(Ops::set(0), leverage_[q]);
        }
        for (std::size_t c = 0; c < kColumns; ++c) square_[c] = dot(c, c);
    }

    [[nodiscard]] V dot(std::size_t a, std::size_t b) const {
        V sum = Ops::set(0);
        for (std::size_t q = 0; q < in_.rows; ++q)
            sum = add_product(sum, Ops::load(column_[a][q]), Ops::load(column_[b][q]));
        return sum;
    }

    /// Column c to length 1, and those behind it orthogonal to it. Where it depends on those
    /// before it, it becomes zero and the lane is not alive any more.
    V orthogonalise(std::size_t c, V alive) {
        const V left = dot(c, c);
        alive = Ops::choose(left, Ops::mul(Ops::set(kDependent), square_[c]), alive, Ops::set(0));
        const V norm = Ops::sqrt(left);
        diagonal_[c] = Ops::choose(alive, Ops::set(0.5), norm, Ops::set(1));
        const V scale =
            Ops::choose(alive, Ops::set(0.5), Ops::div(Ops::set(1), diagonal_[c]), Ops::set(0));
        for (std::size_t q = 0; q < in_.rows; ++q) {
            const V unit = Ops::mul(scale, Ops::load(column_[c][q]));
            Ops::store(unit, column_[c][q]);
            Ops::store(add_product(Ops::load(leverage_[q]), unit, unit), leverage_[q]);
        }
        const std::size_t last = c < kQuadraticColumns ? kConstant : kData;
        for (std::size_t j = c + 1; j <= last; ++j) {
            const V share = dot(c, j);
            triangle_[c][j] = share;
            for (std::size_t q = 0; q < in_.rows; ++q)
                Ops::store(
                    Ops::sub(Ops::load(column_[j][q]), Ops::mul(share, Ops::load(column_[c][q]))),
                    column_[j][q]);
        }
        return alive;
    }

    /// The fit by the first `columns`: the gradient by substitution, the error of values left out.
    void finish(Degree degree, std::size_t columns, double points, V alive) {
        V solution[kColumns];
        for (std::size_t c = columns; c-- > 0;) {
            V sum = triangle_[c][kData];
            for (std::size_t j = c + 1; j < columns; ++j)
                sum = Ops::sub(sum, Ops::mul(triangle_[c][j], solution[j]));
            solution[c] = Ops::div(sum, diagonal_[c]);
        }
        V error = Ops::set(0);
        for (std::size_t q = 0; q < in_.rows; ++q) {
            const V residual = Ops::mul(Ops::load(column_[kData][q]), Ops::load(r2_[q]));
            const V e = left_out(residual, Ops::load(leverage_[q]));
            error = add_product(error, Ops::mul(e, e), Ops::load(weight_[q]));
        }
        const V enough =
            Ops::choose(Ops::load(in_.count + lane_), Ops::set(points - 0.5), alive, Ops::set(0));
        const V none = Ops::set(std::numeric_limits<double>::infinity());
        const auto keep = [&](V value, V otherwise, double* place) {
            Ops::store(Ops::choose(enough, Ops::set(0.5), value, otherwise), place + lane_);
        };
        keep(Ops::div(error, sum_weights_), none, out_.error[degree]);
        keep(solution[0], Ops::set(0), out_.gradient[degree][0]);
        keep(solution[1], Ops::set(0), out_.gradient[degree][1]);
        exists_ = enough;
    }

    /// What the quadratic with a free constant says of the vertex.
    void predict_without() {
        V most = Ops::set(0);
        for (std::size_t q = 0; q < in_.rows; ++q) {
            const V weight = Ops::load(weight_[q]);
            most = add_product(most, weight, weight);
        }
        const V own = dot(kConstant, kConstant);
        const V curved = Ops::div(dot(kConstant, kData), own);
        const V determined =
            Ops::choose(own, Ops::mul(Ops::set(kUndetermined), most), curved, plain_);
        Ops::store(Ops::choose(exists_, Ops::set(0.5), determined, plain_), out_.curved + lane_);
    }

    static constexpr std::size_t kData = kColumns;
    static constexpr std::size_t kConstant = kColumns + 1;
    using Row = double[kFitLanes];

    const FitStencils& in_;
    std::size_t lane_;
    LocalFits& out_;
    V sum_weights_, plain_, exists_;
    V square_[kColumns];
    V diagonal_[kColumns];
    V triangle_[kColumns][kColumns + 2];
    alignas(64) Row r2_[kStencilSize];
    alignas(64) Row weight_[kStencilSize];
    alignas(64) Row leverage_[kStencilSize];
    alignas(64) Row column_[kColumns + 2][kStencilSize];
};

template <class Ops>
void fit_all(const FitStencils& stencils, LocalFits& fits) {
    for (std::size_t lane = 0; lane < kFitLanes; lane += Ops::lanes())
        Fitter<Ops>(stencils, lane, fits).run();
}

void fit_vectors(const FitStencils& stencils, LocalFits& fits) {
    if (simd_enabled()) return fit_all<VectorOps>(stencils, fits);
    fit_all<ScalarOps>(stencils, fits);
}

}  // namespace HWY_NAMESPACE
}  // namespace relief::multires::ps
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace relief::multires::ps {

HWY_EXPORT(fit_vectors);

void fit_stencils(const FitStencils& stencils, LocalFits& fits) {
    HWY_DYNAMIC_DISPATCH(fit_vectors)(stencils, fits);
}

}  // namespace relief::multires::ps
#endif
