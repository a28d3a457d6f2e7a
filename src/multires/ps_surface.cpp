#include "relief/multires/ps_surface.h"

#include <algorithm>
#include <limits>
#include <string>

#include "multires/ps_block.h"
#include "multires/ps_errors.h"

namespace relief::multires::ps {

using mesh::Index;
using spline::Hessian;
using spline::PlaneJet;
using spline::PsPolynomials;

namespace {

constexpr std::size_t kLine = 8;

constexpr double kParallel = 1e-14;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::size_t stride_of(std::size_t components) {
    const std::size_t used = block::kGeometry + block::kPerComponent * components;
    return (used + kLine - 1) / kLine * kLine;
}

}  // namespace

Surface::Surface(const Space& space, int components)
    : space_(&space),
      components_(components),
      stride_(stride_of(static_cast<std::size_t>(components))),
      blocks_(space.mesh.triangles.size() * stride_) {}

Result<Surface> Surface::create(const Space& space, std::span<const Coefficients> components) {
    if (components.empty() || components.size() > 3)
        return Error{ErrorCode::InvalidArgument, "component_count: pass one to three splines", ""};
    std::vector<TangentPlanes> planes;
    for (const Coefficients& component : components) {
        RELIEF_CHECK(check(space, component));
        planes.push_back(tangent_planes(space, component));
    }
    Surface surface(space, static_cast<int>(components.size()));
    for_each_index(space.mesh.triangles.size(), [&](Index t) {
        const spline::PsElement element = space.element(t);
        double* out = surface.blocks_.data() + std::size_t{t} * surface.stride_;
        const auto put = [&out](std::initializer_list<double> numbers) {
            out = std::copy(numbers.begin(), numbers.end(), out);
        };
        for (int k = 0; k < 3; ++k) put({element.corner(k).x, element.corner(k).y});
        put({element.centre().x, element.centre().y});
        put({element.weights()[0], element.weights()[1], element.weights()[2]});
        for (const TangentPlanes& component : planes) {
            const auto& v = space.mesh.triangles[t];
            const PsPolynomials spline =
                element.polynomials(std::array{component[v[0]], component[v[1]], component[v[2]]});
            put({spline.value, spline.gradient.x, spline.gradient.y});
            for (const Hessian& h : spline.hessian) put({h.xx, h.xy, h.yy});
        }
    });
    return surface;
}

PlaneJet Surface::jet(Index triangle, Vec2 point, int component) const {
    const double* known = numbers(triangle);
    const Vec2 d = point - block::centre(known);
    return quadratic_jet(block::centre_jet(known, block::PieceFinder(known).piece_of(d), component),
                         d);
}

void Surface::jets(Index triangle, Vec2 point, PlaneJet* out) const {
    const double* known = numbers(triangle);
    const Vec2 d = point - block::centre(known);
    const int piece = block::PieceFinder(known).piece_of(d);
    for (int m = 0; m < components_; ++m)
        out[m] = quadratic_jet(block::centre_jet(known, piece, m), d);
}

Status evaluate(const Surface& surface, const mesh::TriangleLocator& locator,
                std::span<const Vec2> points, std::span<PlaneJet> out, Outside outside) {
    const auto components = static_cast<std::size_t>(surface.components());
    if (out.size() != points.size() * components ||
        points.size() > std::numeric_limits<Index>::max())
        return bad_input(
            "size_mismatch: every point needs a place for each component, and there may be at most "
            "2^32 - 1 points");
    std::vector<Index> triangles(points.size());
    locator.locate(points, triangles);
    const Vec2 origin = surface.space().mesh.origin;
    const std::size_t bad = first_failure(points.size(), [&](Index k) {
        PlaneJet* jets = out.data() + k * components;
        mesh::TrianglePlace place{triangles[k], points[k] - origin};
        if (place.triangle == mesh::kNone && outside == Outside::Nearest) {
            if (!std::isfinite(points[k].x) || !std::isfinite(points[k].y)) return false;
            place = locator.nearest(points[k]);
        }
        if (place.triangle != mesh::kNone)
            surface.jets(place.triangle, place.point, jets);
        else
            std::fill_n(jets, components, PlaneJet{kNan, {kNan, kNan}, kNan, kNan, kNan});
        return place.triangle != mesh::kNone || outside == Outside::Nan;
    });
    if (bad == points.size()) return {};
    const std::string where = "point " + std::to_string(bad);
    if (outside == Outside::Nearest)
        return bad_input("non_finite_point: it has no nearest point; leave it out", where);
    return bad_input(
        "outside_domain: no triangle contains the point; leave it out, or ask for NaN or the "
        "nearest point",
        where);
}

Vec3<double> graph_normal(const PlaneJet& jet) {
    const Vec3<double> normal{-jet.gradient.x, -jet.gradient.y, 1};
    return 1 / length(normal) * normal;
}

Vec3<double> parametric_normal(std::span<const PlaneJet, 3> jets) {
    const Vec3<double> u{jets[0].gradient.x, jets[1].gradient.x, jets[2].gradient.x};
    const Vec3<double> v{jets[0].gradient.y, jets[1].gradient.y, jets[2].gradient.y};
    const Vec3<double> normal = cross(u, v);
    const double size = length(normal);
    if (!(size > kParallel * (length(u) * length(v)))) return {kNan, kNan, kNan};
    return 1 / size * normal;
}

}  // namespace relief::multires::ps
