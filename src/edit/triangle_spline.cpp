#include "edit/triangle_spline.h"

namespace relief::edit {

using mesh::Index;
using multires::ps::Heights;
using spline::PlaneJet;
using spline::TangentPlane;
namespace ps = multires::ps;

namespace {

/// The spline on an edge: two quadratics, that join C1 at R. All of it follows from the planes at
/// the edge's ends: across the edge, along the line from Z through R, the derivative at R is the
/// mean of theirs.
class EdgeSpline {
  public:
    EdgeSpline(Vec2 edge, Vec2 across, double weight, const TangentPlane& from,
               const TangentPlane& to)
        : cut_(1 - weight), from_(from), to_(to) {
        after_ = from.at(0.5 * cut_ * edge);
        before_ = to.at(-0.5 * weight * edge);
        middle_ = weight * after_ + cut_ * before_;
        const double slope = 2 * (before_ - after_);
        const double rise = weight * dot(from.gradient, across) + cut_ * dot(to.gradient, across);
        const double size = cross(edge, across);
        gradient_ = {(slope * across.y - rise * edge.y) / size,
                     (rise * edge.x - slope * across.x) / size};
    }

    [[nodiscard]] TangentPlane at(double part) const {
        if (part < cut_)
            return piece(part / cut_, from_.value, after_, middle_, from_.gradient, gradient_);
        return piece((part - cut_) / (1 - cut_), middle_, before_, to_.value, gradient_,
                     to_.gradient);
    }

  private:
    static TangentPlane piece(double t, double b0, double b1, double b2, Vec2 start, Vec2 end) {
        return {(1 - t) * ((1 - t) * b0 + t * b1) + t * ((1 - t) * b1 + t * b2),
                (1 - t) * start + t * end};
    }

    double cut_;  ///< where R lies
    TangentPlane from_;
    TangentPlane to_;
    double after_ = 0;  ///< ordinates halfway to R, and at R
    double before_ = 0;
    double middle_ = 0;
    Vec2 gradient_;  ///< at R
};

}  // namespace

Heights TriangleSpline::heights(std::size_t component, Index v) const {
    Heights sum = original_[component][v];
    if (!added_) return sum;
    for (std::size_t j = 0; j < 3; ++j) sum[j] += (*added_)[component][v][j];
    return sum;
}

TangentPlane TriangleSpline::plane(std::size_t component, Index v) const {
    return ps::tangent_plane(space_.control[v], heights(component, v));
}

void TriangleSpline::at_vertex(Index v, PlaneJet* jets) const {
    for (std::size_t c = 0; c < components_; ++c) {
        const TangentPlane here = plane(c, v);
        jets[c].value = here.value;
        jets[c].gradient = here.gradient;
    }
}

void TriangleSpline::on_edge(Index e, double part, PlaneJet* jets) const {
    const mesh::Triangulation& mesh = space_.mesh;
    const auto [from, to] = mesh.edges[e];
    const auto [left, right] = mesh.edge_triangles[e];
    const Vec2 centre = space_.split.centre[left == mesh::kNone ? right : left];
    const Vec2 across = centre - ps::edge_point(mesh, space_.split, e);
    for (std::size_t c = 0; c < components_; ++c) {
        const EdgeSpline spline(mesh.edge_vector(e), across, space_.split.edge_weight[e],
                                plane(c, from), plane(c, to));
        const TangentPlane here = spline.at(part);
        jets[c].value = here.value;
        jets[c].gradient = here.gradient;
    }
}

void TriangleSpline::in_cell(Index c, std::span<const Vec2> points, PlaneJet* jets) const {
    const spline::PsElement element = space_.element(c);
    const auto& corner = space_.mesh.triangles[c];
    for (std::size_t m = 0; m < components_; ++m) {
        const spline::PsPolynomials pieces = element.polynomials(
            std::array{plane(m, corner[0]), plane(m, corner[1]), plane(m, corner[2])});
        for (std::size_t k = 0; k < points.size(); ++k) {
            const Vec2 offset = points[k] - element.centre();
            jets[components_ * k + m] = pieces.jet(element.piece_of(offset), offset);
        }
    }
}

}  // namespace relief::edit
