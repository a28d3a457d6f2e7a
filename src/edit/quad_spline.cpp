#include "edit/quad_spline.h"

namespace relief::edit {

using mesh::Index;
using spline::PlaneJet;

void QuadSpline::at_vertex(Index v, PlaneJet* jet) const {
    jet->value = number(&Data::value, v);
    jet->gradient = {number(&Data::dx, v), number(&Data::dy, v)};
}

/// On an edge the spline is the cubic, and its derivative along the normal the quadratic, of the
/// edge's own numbers.
void QuadSpline::on_edge(Index e, double part, PlaneJet* jet) const {
    const Vec2 edge = mesh_.edge_vector(e);
    const double size = length(edge);
    const Vec2 along = unit(edge);
    const Vec2 across = turned(along);
    std::array<PlaneJet, 2> end;
    for (std::size_t k = 0; k < 2; ++k) at_vertex(mesh_.edges[e][k], &end[k]);
    const double t = part, s = 1 - part;
    const double b0 = end[0].value;
    const double b1 = b0 + size / 3 * dot(end[0].gradient, along);
    const double b3 = end[1].value;
    const double b2 = b3 - size / 3 * dot(end[1].gradient, along);
    const double slope = 3 / size * (s * s * (b1 - b0) + 2 * s * t * (b2 - b1) + t * t * (b3 - b2));
    const double rise = s * (s - t) * dot(end[0].gradient, across) +
                        4 * s * t * number(&Data::normal, e) +
                        t * (t - s) * dot(end[1].gradient, across);
    jet->value = s * s * (s * b0 + 3 * t * b1) + t * t * (3 * s * b2 + t * b3);
    jet->gradient = slope * along + rise * across;
}

void QuadSpline::in_cell(Index c, std::span<const Vec2> points, PlaneJet* jets) const {
    spline::FvsData data;
    for (std::size_t i = 0; i < 4; ++i) {
        PlaneJet corner;
        at_vertex(mesh_.quads[c][i], &corner);
        data.value[i] = corner.value;
        data.gradient[i] = corner.gradient;
        data.normal[i] = mesh_.quad_signs[c][i] * number(&Data::normal, mesh_.quad_edges[c][i]);
    }
    const spline::FvsElement element(mesh_.corners(c));
    const spline::FvsOrdinates ordinates = element.ordinates(data);
    for (std::size_t k = 0; k < points.size(); ++k) jets[k] = element.jet(ordinates, points[k]);
}

}  // namespace relief::edit
