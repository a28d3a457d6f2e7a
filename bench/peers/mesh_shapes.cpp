#include "mesh_shapes.h"

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "relief/mesh/split.h"
#include "relief/multires/subdivide.h"

namespace relief::peers {

namespace {

using mesh::Index;
using multires::MeshScheme;

using Points = std::vector<Vec3<double>>;

struct Base {
    mesh::FaceList faces;
    Points points;
};

Base icosahedron() {
    Base base;
    const double g = std::numbers::phi;
    for (const double a : {-1.0, 1.0})
        for (const double b : {-g, g})
            for (const Vec3<double>& p : {Vec3<double>{0, a, b}, {a, b, 0}, {b, 0, a}})
                base.points.push_back(1 / length(p) * p);
    // Neighbours are the nearest ones; faces are seen counter-clockwise from outside.
    const auto near = [&](Index a, Index b) {
        return dot(base.points[a], base.points[b]) > 0.4 && a != b;
    };
    for (Index a = 0; a < 12; ++a)
        for (Index b = a + 1; b < 12; ++b)
            for (Index c = b + 1; c < 12; ++c) {
                if (!near(a, b) || !near(b, c) || !near(c, a)) continue;
                const Vec3<double>& p = base.points[a];
                const bool outwards = dot(p, cross(base.points[b], base.points[c])) > 0;
                base.faces.add(std::array<Index, 3>{a, outwards ? b : c, outwards ? c : b});
            }
    return base;
}

Base cube() {
    Base base;
    for (const auto& face : {std::array<Index, 4>{0, 2, 3, 1},
                             {4, 5, 7, 6},
                             {0, 1, 5, 4},
                             {2, 6, 7, 3},
                             {0, 4, 6, 2},
                             {1, 3, 7, 5}})
        base.faces.add(face);
    for (const double z : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0})
            for (const double x : {-1.0, 1.0}) base.points.push_back({x, y, z});
    return base;
}

PolygonMesh polygons(const mesh::Topology& mesh, const Points& points) {
    const mesh::FaceList faces = mesh::faces_of(mesh);
    PolygonMesh result;
    for (const auto& p : points) result.vertices.push_back({p.x, p.y, p.z});
    result.offsets = faces.offsets;
    result.corners.assign(faces.corners.begin(), faces.corners.end());
    return result;
}

/// Uniform in -1 .. 1, the same everywhere.
class Noise {
  public:
    double operator()() { return static_cast<double>(random_()) / 0x1p31 - 1; }
    Vec3<double> direction() {
        while (true) {
            const Vec3<double> v{(*this)(), (*this)(), (*this)()};
            if (const double size = length(v); size > 0.1 && size < 1) return 1 / size * v;
        }
    }

  private:
    std::mt19937 random_{1};
};

PolygonMesh surface(Base base, MeshScheme scheme, int steps) {
    Noise noise;
    for (auto& p : base.points) p += 0.2 * noise.direction();
    const auto count = static_cast<Index>(base.points.size());
    multires::SubdividedMesh<double> mesh{*mesh::build(base.faces, count), {base.points}, {}};
    mesh = *multires::subdivide(std::move(mesh), {.scheme = scheme}, steps);
    return polygons(mesh.mesh, mesh.arrays[0]);
}

struct Wave {
    Vec3<double> frequency;
    double phase = 0;
    double height = 0;
};

std::vector<Wave> waves() {
    constexpr std::array<std::pair<double, double>, 6> kinds = {
        {{2, 0.15}, {4, 0.08}, {7, 0.04}, {12, 0.02}, {20, 0.01}, {33, 0.005}}};
    Noise noise;
    std::vector<Wave> all;
    for (const auto& [frequency, height] : kinds)
        for (int k = 0; k < 3; ++k)
            all.push_back({frequency * noise.direction(), std::numbers::pi * noise(), height});
    return all;
}

}  // namespace

PolygonMesh wavy_sphere(int steps, double noise) {
    Base base = icosahedron();
    mesh::Topology mesh = *mesh::build(base.faces, 12);
    Points& points = base.points;
    for (int step = 0; step < steps; ++step) {
        points.resize(std::size_t{mesh.vertex_count} + mesh.edge_count);
        for (Index h = 0; h < mesh.half_edge_count(); ++h) {
            const Vec3<double> middle = points[mesh.origin[h]] + points[mesh.target(h)];
            points[mesh.vertex_count + mesh.edge[h]] = 1 / length(middle) * middle;
        }
        mesh = *mesh::refine(mesh, mesh::Split::Loop);
    }
    Noise random;
    for (auto& p : points) {
        double radius = 1 + noise * random();
        for (const Wave& wave : waves())
            radius += wave.height * std::sin(dot(wave.frequency, p) + wave.phase);
        p = radius * p;
    }
    return polygons(mesh, points);
}

std::vector<NamedMesh> exact_surfaces() {
    return {{"Loop surface", surface(icosahedron(), MeshScheme::Loop, 5)},
            {"sqrt(3) surface", surface(icosahedron(), MeshScheme::Sqrt3, 6)},
            {"Catmull-Clark surface", surface(cube(), MeshScheme::CatmullClark, 6)}};
}

}  // namespace relief::peers
