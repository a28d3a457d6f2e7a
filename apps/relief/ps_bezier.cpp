#include <array>

#include "ps_verbs.h"
#include "relief/io/vtk.h"

namespace relief::cli {

namespace ps = multires::ps;
using mesh::Index;

namespace {

/// The control points of an element: those of corner or edge k, three after each other.
enum Point : std::uint32_t {
    kCorner = 0,
    kNext = 3,
    kPrevious = 6,
    kInner = 9,
    kEdge = 12,
    kSpoke = 15,
    kCentre = 18,
    kPoints = 19
};

/// The six control points of each piece, corners first (io::BezierTriangles).
constexpr std::array<std::array<std::uint32_t, 6>, 6> kPieces = [] {
    std::array<std::array<std::uint32_t, 6>, 6> pieces{};
    for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t after = k == 2 ? 0 : k + 1;
        pieces[2 * k] = {kCorner + k, kEdge + k, kCentre, kNext + k, kSpoke + k, kInner + k};
        pieces[2 * k + 1] = {kEdge + k,         kCorner + after, kCentre,
                             kPrevious + after, kInner + after,  kSpoke + k};
    }
    return pieces;
}();

/// Where the control points of an element lie, relative to Z.
std::array<Vec2, kPoints> places_of(const spline::PsElement& element) {
    std::array<Vec2, kPoints> places{};
    for (int k = 0; k < 3; ++k) {
        const Vec2 corner = element.corner(k);
        const Vec2 edge = element.edge_point(k);
        places[kCorner + k] = corner;
        places[kNext + k] = midpoint(corner, edge);
        places[kPrevious + k] = midpoint(corner, element.edge_point(k == 0 ? 2 : k - 1));
        places[kInner + k] = midpoint(corner, {});
        places[kEdge + k] = edge;
        places[kSpoke + k] = midpoint(edge, {});
    }
    return places;
}

std::array<double, kPoints> values_of(const spline::PsOrdinates& ordinates) {
    std::array<double, kPoints> values{};
    for (int k = 0; k < 3; ++k) {
        values[kCorner + k] = ordinates.corner[k];
        values[kNext + k] = ordinates.next[k];
        values[kPrevious + k] = ordinates.previous[k];
        values[kInner + k] = ordinates.inner[k];
        values[kEdge + k] = ordinates.edge[k];
        values[kSpoke + k] = ordinates.spoke[k];
    }
    values[kCentre] = ordinates.centre;
    return values;
}

/// Control points and fields of one value after the other.
struct Nets {
    std::vector<std::array<double, 3>> points;
    std::vector<std::array<std::uint32_t, 6>> cells;
    std::vector<double> values;     ///< components a point
    std::vector<double> gradients;  ///< of the first component; linear, so its net are its values
};

void add_triangle(const PsLevel& level, std::span<const ps::TangentPlanes> planes, Index t,
                  Nets& nets) {
    const mesh::Triangulation& mesh = level.space().mesh;
    const spline::PsElement element = level.space().element(t);
    const auto& v = mesh.triangles[t];
    std::array<std::array<double, kPoints>, 3> values{};
    for (std::size_t m = 0; m < planes.size(); ++m)
        values[m] =
            values_of(element.ordinates({planes[m][v[0]], planes[m][v[1]], planes[m][v[2]]}));
    const auto first = static_cast<std::uint32_t>(nets.points.size());
    const auto places = places_of(element);
    for (std::uint32_t k = 0; k < kPoints; ++k) {
        const Vec2 place = mesh.origin + element.centre() + places[k];
        const auto first_value = static_cast<std::ptrdiff_t>(nets.values.size());
        for (std::size_t m = 0; m < planes.size(); ++m) nets.values.push_back(values[m][k]);
        nets.points.push_back(
            codec::in_space(place, {nets.values.begin() + first_value, nets.values.end()}));
        const Vec2 gradient = level.surface.jet(t, element.centre() + places[k]).gradient;
        nets.gradients.insert(nets.gradients.end(), {gradient.x, gradient.y});
    }
    for (auto cell : kPieces) {
        for (std::uint32_t& point : cell) point += first;
        nets.cells.push_back(cell);
    }
}

}  // namespace

Status write_bezier(const PsLevel& level, const std::string& path) {
    const int components = level.surface.components();
    RELIEF_CHECK(codec::check_in_space(components));
    const mesh::Triangulation& mesh = level.space().mesh;
    if (mesh.triangles.size() > UINT32_MAX / kPoints)
        return Error{ErrorCode::Unsupported, "too many triangles for one .vtu file", path};
    std::vector<ps::TangentPlanes> planes;
    for (const ps::Coefficients& spline : level.data->components)
        planes.push_back(ps::tangent_planes(level.space(), spline));
    Nets nets;
    for (Index t = 0; t < mesh.triangle_count(); ++t) add_triangle(level, planes, t, nets);
    return io::write_vtu(path,
                         {nets.points,
                          nets.cells,
                          {{"value", components, nets.values}, {"gradient", 2, nets.gradients}}});
}

}  // namespace relief::cli
