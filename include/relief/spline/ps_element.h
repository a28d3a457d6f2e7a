#pragma once

#include <array>
#include <cstdint>

#include "relief/spline/control_triangle.h"
#include "relief/spline/fvs_element.h"

/// The C1 quadratic element of Powell and Sabin: a triangle, cut into six by the lines from an
/// inner point Z to its corners V_k and to a point R_k of each edge, with a quadratic on each,
/// joined C1. It is determined by the tangent planes at its corners. Corners and edges are counted
/// modulo 3; edge k joins corner k to corner k + 1. Source: powell-sabin.md sections 2, 3, 10 and
/// 11; docs/powell-sabin.md.
namespace relief::spline {

/// A plane over the neighbourhood of a point: its value there and its gradient.
struct TangentPlane {
    double value = 0;
    Vec2 gradient;

    /// The height at a point, given relative to that of the plane.
    [[nodiscard]] constexpr double at(Vec2 offset) const { return value + dot(gradient, offset); }
};

/// Bezier ordinates of a quadratic on a triangle, in the order 200, 020, 002, 110, 011, 101.
using QuadraticNet = std::array<double, 6>;

/// Second derivatives.
struct Hessian {
    double xx = 0;
    double xy = 0;
    double yy = 0;
};

/// The 19 different ordinates of the six nets; of corner k and edge k.
struct PsOrdinates {
    std::array<double, 3> corner{};    ///< s: at V_k
    std::array<double, 3> next{};      ///< u: halfway from V_k to R_k
    std::array<double, 3> previous{};  ///< v: halfway from V_k to R_(k-1)
    std::array<double, 3> inner{};     ///< w: halfway from V_k to Z
    std::array<double, 3> edge{};      ///< r: at R_k
    std::array<double, 3> spoke{};     ///< theta: halfway from R_k to Z
    double centre = 0;                 ///< omega: at Z

    /// The net of a piece, 0 .. 5: piece 2k is (V_k, R_k, Z), piece 2k + 1 is (R_k, V_(k+1), Z).
    [[nodiscard]] QuadraticNet net(int piece) const;
};

/// The jet of a quadratic at a point, from its jet at another point; `way`: from there to here.
[[nodiscard]] constexpr PlaneJet quadratic_jet(const PlaneJet& start, Vec2 way) {
    const double along_x = start.gradient.x + start.xy * way.y;
    const double along_y = start.gradient.y + start.yy * way.y;
    return {(0.5 * start.xx * way.x + along_x) * way.x +
                (start.value + (start.gradient.y + 0.5 * start.yy * way.y) * way.y),
            {along_x + start.xx * way.x, along_y + start.xy * way.x},
            start.xx,
            start.xy,
            start.yy};
}

/// A spline on an element as polynomials about Z. Being C1, the six pieces have the same value and
/// gradient there; only their Hessians differ.
struct PsPolynomials {
    double value = 0;
    Vec2 gradient;
    std::array<Hessian, 6> hessian{};

    /// Value, gradient and Hessian of a piece at a point relative to Z.
    [[nodiscard]] constexpr PlaneJet jet(int piece, Vec2 offset) const {
        const Hessian& h = hessian[piece];
        return quadratic_jet({value, gradient, h.xx, h.xy, h.yy}, offset);
    }
};

/// Nine functions on an element: function 3k + j has the tangent plane number 3k + j at corner k
/// and none at the others.
using PsBasis = std::array<TangentPlane, 9>;

/// Value, d/dx and d/dy of corners 0, 1, 2.
inline constexpr PsBasis kPsNodalBasis = {{{1, {}},
                                           {0, {1, 0}},
                                           {0, {0, 1}},
                                           {1, {}},
                                           {0, {1, 0}},
                                           {0, {0, 1}},
                                           {1, {}},
                                           {0, {1, 0}},
                                           {0, {0, 1}}}};

/// A symmetric matrix of nine functions; entry (i, j) is at 9 i + j.
using PsMatrix = std::array<double, 81>;

/// The corner k after whose line from Z a point follows, counter-clockwise, before that of corner
/// k + 1, by the lines it is not to the right of: bit k of the index is that of corner k. 0 at Z.
inline constexpr std::array<std::uint8_t, 8> kPsSector = {0, 0, 1, 1, 2, 0, 2, 0};

/// The geometry of one element.
class PsElement {
  public:
    /// R_k = weights[k] V_k + (1 - weights[k]) V_(k+1). Requires: corners counter-clockwise, centre
    /// strictly inside, weights in (0, 1).
    PsElement(const TriangleCorners& corners, Vec2 centre, const std::array<double, 3>& weights);

    [[nodiscard]] Vec2 centre() const { return centre_; }
    /// V_k and R_k relative to Z.
    [[nodiscard]] Vec2 corner(int k) const { return corner_[k]; }
    [[nodiscard]] Vec2 edge_point(int k) const { return edge_point_[k]; }
    [[nodiscard]] const std::array<double, 3>& weights() const { return weight_; }
    /// The barycentric coordinates of Z.
    [[nodiscard]] const std::array<double, 3>& centre_weights() const { return centre_weight_; }

    /// 1 / rho_k, where rho_k is the part of V_k Z that lies before the line R_k R_(k-1) (section
    /// 6). Refinement at that corner by a factor kappa needs kappa < 1 / rho_k.
    [[nodiscard]] std::array<double, 3> inverse_ratios() const;

    [[nodiscard]] PsOrdinates ordinates(const std::array<TangentPlane, 3>& planes) const;
    [[nodiscard]] PsPolynomials polynomials(const PsOrdinates& ordinates) const;
    [[nodiscard]] PsPolynomials polynomials(const std::array<TangentPlane, 3>& planes) const {
        return polynomials(ordinates(planes));
    }

    /// The piece in whose sector around Z a point lies, given relative to Z; on a line from Z the
    /// piece that follows it counter-clockwise. Points outside the triangle have a sector, too.
    [[nodiscard]] int piece_of(Vec2 offset) const;

    /// The value at a point (relative to Z) of a piece as a combination of nine numbers: of value,
    /// d/dx, d/dy at corners 0, 1, 2, or of the coefficients of another basis.
    [[nodiscard]] std::array<double, 9> weights_at(int piece, Vec2 offset) const;
    [[nodiscard]] std::array<double, 9> weights_at(const PsBasis& basis, int piece,
                                                   Vec2 offset) const;

    /// Integrals over the triangle of the products of the basis functions, and of f_xx g_xx + 2
    /// f_xy g_xy + f_yy g_yy. Exact up to rounding.
    [[nodiscard]] PsMatrix mass_matrix(const PsBasis& basis) const;
    [[nodiscard]] PsMatrix thin_plate_matrix(const PsBasis& basis) const;
    /// The integral of s_xx^2 + 2 s_xy^2 + s_yy^2.
    [[nodiscard]] double thin_plate_energy(const PsPolynomials& spline) const;

    /// Sum over the six lines from Z of their squared length times the squared jump of the second
    /// derivative across them: the part of the jump energy that lies inside the triangle.
    [[nodiscard]] double inner_jump_energy(const PsPolynomials& spline) const;

  private:
    using Pair = std::array<Vec2, 2>;
    /// The two outer corners of a piece, relative to Z.
    [[nodiscard]] Pair piece_corners(int piece) const;
    [[nodiscard]] Hessian hessian(int piece, const QuadraticNet& net) const;
    [[nodiscard]] std::array<PsOrdinates, 9> basis_ordinates(const PsBasis& basis) const;

    Vec2 centre_;
    TriangleCorners corner_;
    TriangleCorners edge_point_;
    std::array<double, 3> weight_;
    std::array<double, 3> centre_weight_;
};

/// The squared length of the segment from a to b times the square of n^T (h1 - h2) n, n being its
/// unit normal: what it adds to the jump energy.
[[nodiscard]] double jump_energy(Vec2 a, Vec2 b, const Hessian& h1, const Hessian& h2);

}  // namespace relief::spline
