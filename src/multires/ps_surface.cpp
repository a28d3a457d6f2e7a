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

constexpr std::size_t kLine = 8;  ///< numbers of a line of cache
constexpr double kParallel = 1e-14;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::size_t stride_of(std::size_t components) {
    const std::size_t used = block::kGeometry + block::kPerComponent * components;
    return (used + kLine - 1) / kLine * kLine;
}

}  // namespace

Surface::Surface(const mesh::PlaneTriangles& triangles, int components)
    : triangles_(&triangles),
      components_(components),
      stride_(stride_of(static_cast<std::size_t>(components))),
      blocks_(triangles.triangles.size() * stride_) {}

Result<Surface> Surface::create(const Space& space, std::span<const Coefficients> components) {
    std::vector<TangentPlanes> planes;
    for (const Coefficients& component : components) {
        RELIEF_CHECK(check(space.mesh, component));
        planes.push_back(tangent_planes(space, component));
    }
    return made(space.mesh, space.split, planes);
}

Result<Surface> Surface::create(const mesh::Triangulation& mesh, const Split& split,
                                std::span<const TangentPlanes> components) {
    for (const TangentPlanes& component : components) RELIEF_CHECK(check(mesh, component));
    return made(mesh, split, components);
}

Result<Surface> Surface::made(const mesh::Triangulation& mesh, const Split& split,
                              std::span<const TangentPlanes> components) {
    if (components.empty() || components.size() > 3)
        return Error{ErrorCode::InvalidArgument, "component_count: pass one to three splines", ""};
    Surface surface(mesh, static_cast<int>(components.size()));
    for_each_index(mesh.triangles.size(), [&](Index t) {
        const spline::PsElement element = ps::element(mesh, split, t);
        double* out = surface.blocks_.data() + std::size_t{t} * surface.stride_;
        const auto put = [&out](std::initializer_list<double> numbers) {
            out = std::copy(numbers.begin(), numbers.end(), out);
        };
        for (int k = 0; k < 3; ++k) put({element.corner(k).x, element.corner(k).y});
        put({element.centre().x, element.centre().y});
        put({element.weights()[0], element.weights()[1], element.weights()[2]});
        for (const TangentPlanes& component : components) {
            const auto& v = mesh.triangles[t];
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

namespace {

/// So many points ahead, a point and the place of its jets are fetched: in the order of visits both
/// lie anywhere.
constexpr std::size_t kAhead = 16;

struct Visits {
    const Surface& surface;
    const mesh::TriangleLocator& locator;
    std::span<const Vec2> points;
    std::span<PlaneJet> out;
    Outside outside;
    Buffer<Index> order;

    /// The number of the k-th point; those to come are fetched. (A function that does only that
    /// would count as one without effect, and go.)
    [[nodiscard]] std::size_t number(std::size_t k) const {
        if (order.size() == 0) return k;
        const auto components = static_cast<std::size_t>(surface.components());
        const std::size_t soon = order[std::min(k + kAhead, order.size() - 1)];
        const PlaneJet* jets = out.data() + soon * components;
        __builtin_prefetch(&points[soon]);
        __builtin_prefetch(jets, 1);
        // The last byte: jets may straddle two lines.
        __builtin_prefetch(reinterpret_cast<const char*>(jets + components) - 1, 1);
        return order[k];
    }

    /// Whether a point is as `outside` allows.
    [[nodiscard]] bool visit(std::size_t k) const {
        const auto components = static_cast<std::size_t>(surface.components());
        PlaneJet* jets = out.data() + k * components;
        const Vec2 point = points[k];
        mesh::TrianglePlace place{locator.locate(point), point - surface.triangles().origin};
        if (place.triangle == mesh::kNone && outside == Outside::Nearest) {
            if (!std::isfinite(point.x) || !std::isfinite(point.y)) return false;
            place = locator.nearest(point);
        }
        if (place.triangle == mesh::kNone) {
            std::fill_n(jets, components, PlaneJet{kNan, {kNan, kNan}, kNan, kNan, kNan});
            return outside == Outside::Nan;
        }
        surface.jets(place.triangle, place.point, jets);
        return true;
    }
};

}  // namespace

Status evaluate(const Surface& surface, const mesh::TriangleLocator& locator,
                std::span<const Vec2> points, std::span<PlaneJet> out, Outside outside) {
    if (out.size() != points.size() * static_cast<std::size_t>(surface.components()) ||
        points.size() > std::numeric_limits<Index>::max())
        return bad_input(
            "size_mismatch: every point needs a place for each component, and there may be at most "
            "2^32 - 1 points");
    const Visits visits{surface, locator, points, out, outside, locator.visiting_order(points)};
    std::atomic<std::size_t> first_bad = points.size();
    for_each_index(points.size(), [&](Index k) {
        const std::size_t number = visits.number(k);
        if (!visits.visit(number)) lower(first_bad, number);
    });
    const std::size_t bad = first_bad;
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
