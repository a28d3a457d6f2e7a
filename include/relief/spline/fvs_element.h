#pragma once

#include <array>

#include "relief/core/vec2.h"

/// The C1 cubic element of Fraeijs de Veubeke and Sander: a strictly convex quad, cut by both
/// diagonals into four triangles T_i = (v_i, v_(i+1), c), with a cubic on each, joined C1.
/// Source: fvs-hierarchical.md sections 2, 4, 9 and 10; docs/fvs.md.
namespace relief::spline {

/// The 16 numbers that determine the surface on a quad: at each corner the value and the gradient,
/// at each side's midpoint the derivative along the inward normal.
struct FvsData {
    std::array<double, 4> value{};
    std::array<Vec2, 4> gradient{};
    std::array<double, 4> normal{};
};

/// Bezier ordinates of a cubic on a triangle, in the order 300, 210, 201, 120, 111, 102, 030, 021,
/// 012, 003.
using CubicNet = std::array<double, 10>;

/// The 25 different ordinates of the four nets.
struct FvsOrdinates {
    std::array<double, 4> corner{};               ///< 300 of T_i
    std::array<std::array<double, 2>, 4> side{};  ///< 210 and 120 of T_i
    std::array<double, 4> spoke{};                ///< 201 of T_i and 021 of T_(i-1)
    std::array<double, 4> inner{};                ///< 111 of T_i
    std::array<double, 4> ring{};                 ///< 102 of T_i and 012 of T_(i-1)
    double centre = 0;                            ///< 003 of all

    /// The net of T_triangle, triangle 0 .. 3.
    [[nodiscard]] CubicNet net(int triangle) const;
};

/// A value with first and second derivatives.
struct PlaneJet {
    double value = 0;
    Vec2 gradient;
    double xx = 0;
    double xy = 0;
    double yy = 0;
};

/// What refinement adds on an edge from a to b (section 4).
struct FvsEdgeMiddle {
    double value = 0;
    double tangential = 0;                 ///< derivative along the edge
    std::array<double, 2> half_normals{};  ///< normal derivative at 1/4 and 3/4 of the edge
};

/// From the values, tangential and normal derivatives at the ends and the normal derivative in the
/// middle. Requires: length > 0.
[[nodiscard]] FvsEdgeMiddle fvs_edge_middle(double length, const std::array<double, 2>& value,
                                            const std::array<double, 2>& tangential,
                                            const std::array<double, 2>& normal,
                                            double middle_normal);

/// What refinement adds inside a quad.
struct FvsQuadMiddle {
    double value = 0;                       ///< at c
    Vec2 gradient;                          ///< at c
    std::array<double, 4> inner_normals{};  ///< at the middle of the edge from M_i to c, along its
                                            ///< direction turned by +90 degrees
};

/// The geometry of one element. Invariant: made from a strictly convex, counter-clockwise quad.
class FvsElement {
  public:
    /// Requires: v is strictly convex and counter-clockwise.
    explicit FvsElement(const QuadCorners& v);

    [[nodiscard]] const QuadCorners& corners() const { return v_; }
    [[nodiscard]] Vec2 centre() const { return diagonals_.centre; }
    /// c = (1-s) v0 + s v2 = (1-t) v1 + t v3.
    [[nodiscard]] double s() const { return diagonals_.s; }
    [[nodiscard]] double t() const { return diagonals_.t; }

    [[nodiscard]] FvsOrdinates ordinates(const FvsData& data) const;
    /// The inverse of `ordinates`: reads corner, side, spoke and inner.
    [[nodiscard]] FvsData data(const FvsOrdinates& ordinates) const;

    /// Which triangle a point of the quad is evaluated in. On the diagonal v0 v2 that is T_0 or
    /// T_1, on the diagonal v1 v3 beside it T_0 or T_2, at c T_0. A point outside gets the triangle
    /// of its sector.
    [[nodiscard]] int triangle_of(Vec2 point) const;

    /// Value, gradient and Hessian in `triangle`. Value and gradient are continuous; the Hessian
    /// jumps across all edges of the triangles.
    [[nodiscard]] PlaneJet jet(const FvsOrdinates& ordinates, int triangle, Vec2 point) const;
    [[nodiscard]] PlaneJet jet(const FvsOrdinates& ordinates, Vec2 point) const {
        return jet(ordinates, triangle_of(point), point);
    }

    [[nodiscard]] FvsQuadMiddle middle(const FvsOrdinates& ordinates) const;

    /// The value at a point as a combination of the 16 data, in the order value, d/dx, d/dy of
    /// corners 0 .. 3, then the normals of sides 0 .. 3.
    [[nodiscard]] std::array<double, 16> weights(int triangle, Vec2 point) const;

    /// Integrals over the quad of the products of the 16 basis functions, in the same order;
    /// entry (i, j) is at 16 i + j.
    [[nodiscard]] std::array<double, 256> mass_matrix() const;

  private:
    using Barycentric = std::array<double, 3>;
    [[nodiscard]] std::array<Vec2, 3> barycentric_gradients(int triangle) const;
    [[nodiscard]] Barycentric barycentric(int triangle, Vec2 point) const;
    [[nodiscard]] std::array<CubicNet, 16> basis_nets(int triangle) const;

    QuadCorners v_;
    Diagonals diagonals_;
    std::array<Vec2, 4> normal_;    ///< unit, inward, of side i
    std::array<double, 4> along_;   ///< alpha: the foot of c on side i, 0 at v_i and 1 at v_(i+1)
    std::array<double, 4> height_;  ///< h: the distance of c from side i
};

/// The data as 16 numbers, and back; the order is that of FvsElement::weights.
[[nodiscard]] std::array<double, 16> fvs_flat(const FvsData& data);
[[nodiscard]] FvsData fvs_data(const std::array<double, 16>& flat);

}  // namespace relief::spline
