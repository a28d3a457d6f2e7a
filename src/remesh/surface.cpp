#include "relief/remesh/surface.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "relief/mesh/repair.h"
#include "remesh/angles.h"

namespace relief::remesh {

namespace {

using mesh::Index;
using mesh::kNone;
using Point = Vec3<double>;

/// Squares of areas must be numbers.
constexpr double kLargest = 1e75;
/// Features of fewer edges are taken for noise.
constexpr Index kShortestFeature = 4;

Error bad(std::string message, std::string where) {
    return {ErrorCode::BadInput, std::move(message), std::move(where)};
}

/// What `build` would refuse, in the numbers of the mesh. Unused vertices are no harm.
Status check_manifold(const PolygonMesh& mesh) {
    const auto diagnosis =
        mesh::diagnose(mesh::faces_of(mesh), static_cast<Index>(mesh.vertices.size()), 1);
    for (const mesh::MeshProblem& problem : diagnosis.problems) {
        if (problem.kind == mesh::MeshProblemKind::UnusedVertex) continue;
        const bool vertex = problem.kind == mesh::MeshProblemKind::SeveralFans;
        const std::uint64_t count = diagnosis.count(problem.kind);
        return bad(problem.message +
                       (count > 1 ? " (the first of " + std::to_string(count) + ")" : "") +
                       "; --repair mends it, 'relief info' lists all",
                   (vertex ? "vertex " : "face ") + std::to_string(problem.element));
    }
    return {};
}

/// The triangles, with vertices counted anew without those that are unused.
mesh::FaceList add_triangles(const PolygonMesh& mesh, Surface& surface) {
    std::vector<Index> number(mesh.vertices.size(), kNone);
    const auto number_of = [&](std::int64_t corner) {
        const auto v = static_cast<std::size_t>(mesh.corners[static_cast<std::size_t>(corner)]);
        if (number[v] == kNone) {
            number[v] = static_cast<Index>(surface.vertex_sources.size());
            surface.vertex_sources.push_back(static_cast<Index>(v));
        }
        return number[v];
    };
    mesh::FaceList faces;
    for (std::size_t f = 0; f + 1 < mesh.offsets.size(); ++f)
        for (std::int64_t k = mesh.offsets[f] + 1; k + 1 < mesh.offsets[f + 1]; ++k) {
            const std::array<std::int64_t, 3> corners = {mesh.offsets[f], k, k + 1};
            faces.add(
                std::array{number_of(corners[0]), number_of(corners[1]), number_of(corners[2])});
            surface.corner_sources.push_back(corners);
            surface.face_sources.push_back(static_cast<Index>(f));
        }
    return faces;
}

Status add_points(const PolygonMesh& mesh, Surface& surface) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Point low{kInfinity, kInfinity, kInfinity};
    Point high{-kInfinity, -kInfinity, -kInfinity};
    for (const Index v : surface.vertex_sources) {
        const auto& [x, y, z] = mesh.vertices[v];
        if (std::max({std::abs(x), std::abs(y), std::abs(z)}) > kLargest)
            return bad("too_large: coordinates above 1e75 can not be measured; scale the mesh",
                       "vertex " + std::to_string(v));
        low = {std::min(low.x, x), std::min(low.y, y), std::min(low.z, z)};
        high = {std::max(high.x, x), std::max(high.y, y), std::max(high.z, z)};
    }
    surface.lowest = low;
    surface.diagonal = length(high - low);
    if (!(surface.diagonal > 0)) return bad("no_area: all vertices are at one place", "mesh");
    for (const Index v : surface.vertex_sources) {
        const auto& [x, y, z] = mesh.vertices[v];
        surface.points.push_back({(x - low.x) / surface.diagonal, (y - low.y) / surface.diagonal,
                                  (z - low.z) / surface.diagonal});
    }
    return {};
}

Point unit(const Point& a) {
    const double size = length(a);
    return size > 0 ? 1 / size * a : Point{};
}

Status add_normals(Surface& surface) {
    const Buffer<Index>& corner = surface.mesh.origin;
    surface.normals.assign(surface.points.size(), {});
    double area = 0;
    for (Index f = 0; f < surface.mesh.face_count; ++f) {
        const Point& a = surface.points[corner[3 * f]];
        const Point doubled =
            cross(surface.points[corner[3 * f + 1]] - a, surface.points[corner[3 * f + 2]] - a);
        area += length(doubled);
        surface.face_normals.push_back(unit(doubled));
        for (Index k = 0; k < 3; ++k) surface.normals[corner[3 * f + k]] += doubled;
    }
    for (Point& n : surface.normals) n = unit(n);
    if (area > 0) return {};
    return bad("no_area: all faces are lines or points", "mesh");
}

/// Creases of the mesh that are sharp for ever.
void add_creases(const PolygonMesh& mesh, Surface& surface) {
    std::vector<std::pair<Index, Index>> creases;
    for (const CreaseEdge& crease : mesh.creases)
        if (std::isinf(crease.sharpness))
            creases.push_back(
                std::minmax(static_cast<Index>(crease.a), static_cast<Index>(crease.b)));
    std::sort(creases.begin(), creases.end());
    for (Index h = 0; h < surface.mesh.half_edge_count(); ++h) {
        const std::pair<Index, Index> ends =
            std::minmax(surface.vertex_sources[surface.mesh.origin[h]],
                        surface.vertex_sources[surface.mesh.target(h)]);
        if (std::binary_search(creases.begin(), creases.end(), ends)) surface.sharp[h] = 1;
    }
}

/// Whether edges between faces turn by more than this belong to curves; but not those that make up
/// curves of a few edges only.
void add_folds(Surface& surface, double degrees) {
    const mesh::Topology& mesh = surface.mesh;
    const double least = -direction_of(kPi + degrees * kPi / 180).x;
    std::vector<Index> folds;
    std::vector<Index> group(mesh.vertex_count);
    std::iota(group.begin(), group.end(), Index{0});
    const auto root = [&](Index v) {
        while (group[v] != v) v = group[v] = group[group[v]];
        return v;
    };
    for (Index h = 0; h < mesh.half_edge_count(); ++h) {
        if (mesh.on_boundary(h) || !mesh.is_first(h)) continue;
        const Point& a = surface.face_normals[mesh.face_of(h)];
        const Point& b = surface.face_normals[mesh.face_of(mesh.twin[h])];
        if (dot(a, a) == 0 || dot(b, b) == 0 || dot(a, b) >= least) continue;
        folds.push_back(h);
        group[root(mesh.origin[h])] = root(mesh.target(h));
    }
    std::vector<Index> edges(mesh.vertex_count, 0);
    for (const Index h : folds) ++edges[root(mesh.origin[h])];
    for (const Index h : folds)
        if (edges[root(mesh.origin[h])] >= kShortestFeature)
            surface.sharp[h] = surface.sharp[mesh.twin[h]] = 1;
}

/// The other ends of the sharp edges at each vertex, of at most two.
struct CurveEnds {
    Index count = 0;
    std::array<Index, 2> ends{};
};

void find_kinds(Surface& surface, double corner_degrees) {
    const mesh::Topology& mesh = surface.mesh;
    std::vector<CurveEnds> curves(mesh.vertex_count);
    const auto add = [&](Index from, Index to) {
        CurveEnds& curve = curves[from];
        if (curve.count < 2) curve.ends[curve.count] = to;
        ++curve.count;
    };
    for (Index h = 0; h < mesh.half_edge_count(); ++h) {
        if (!surface.sharp[h] || !mesh.is_first(h)) continue;
        add(mesh.origin[h], mesh.target(h));
        add(mesh.target(h), mesh.origin[h]);
    }
    const double straightest = direction_of(corner_degrees * kPi / 180).x;
    for (Index v = 0; v < mesh.vertex_count; ++v) {
        const CurveEnds& curve = curves[v];
        if (curve.count == 0) continue;
        surface.kinds[v] = VertexKind::Corner;
        if (curve.count > 2) continue;
        const Point before = unit(surface.points[v] - surface.points[curve.ends[0]]);
        const Point after = unit(surface.points[curve.ends[1]] - surface.points[v]);
        if (curve.count == 2 && dot(before, after) >= straightest)
            surface.kinds[v] = VertexKind::Curve;
    }
}

}  // namespace

Point Surface::point(const Place& place) const {
    const Index* corner = mesh.origin.data() + 3 * place.face;
    return place.weights[0] * points[corner[0]] + place.weights[1] * points[corner[1]] +
           place.weights[2] * points[corner[2]];
}

Point Surface::normal(const Place& place) const {
    const Index* corner = mesh.origin.data() + 3 * place.face;
    return place.weights[0] * normals[corner[0]] + place.weights[1] * normals[corner[1]] +
           place.weights[2] * normals[corner[2]];
}

void find_features(Surface& surface, const SurfaceOptions& options) {
    surface.kinds.assign(surface.points.size(), VertexKind::Smooth);
    for (Index h = 0; h < surface.mesh.half_edge_count(); ++h)
        if (surface.mesh.on_boundary(h)) surface.sharp[h] = 1;
    if (options.feature_degrees) add_folds(surface, *options.feature_degrees);
    find_kinds(surface, options.corner_degrees);
}

Result<Surface> surface_of(const PolygonMesh& mesh, const SurfaceOptions& options) {
    RELIEF_CHECK(check(mesh));
    if (mesh.polygon_count() == 0) return bad("empty_mesh: there is no face", "mesh");
    RELIEF_CHECK(check_manifold(mesh));
    Surface surface;
    const mesh::FaceList faces = add_triangles(mesh, surface);
    RELIEF_TRY(surface.mesh, mesh::build(faces, static_cast<Index>(surface.vertex_sources.size())));
    RELIEF_CHECK(add_points(mesh, surface));
    RELIEF_CHECK(add_normals(surface));
    surface.sharp.assign(surface.mesh.half_edge_count(), 0);
    add_creases(mesh, surface);
    find_features(surface, options);
    return surface;
}

}  // namespace relief::remesh
