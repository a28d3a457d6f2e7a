#include <algorithm>
#include <cmath>
#include <random>

#include "relief/io/synthetic_mesh.h"
#include "relief/multires/mesh_frames.h"
#include "reverse.h"

namespace relief::reproduce::reverse {

namespace {

using mesh::Index;
using mesh::kNone;
using mesh::Topology;
using multires::MeshHierarchy;
using multires::MeshMaps;
using multires::StiffResiduals;

/// Flips the edge of half-edge h unless its new place is taken or an end would have two edges.
bool flip(Polyhedron& shape, Index h) {
    const Topology mesh = *mesh::build(shape.faces, static_cast<Index>(shape.points.size()));
    const Index twin = mesh.twin[h];
    if (twin == kNone) return false;
    const auto valences = mesh::valences(mesh);
    const Index a = mesh.origin[h];
    const Index b = mesh.target(h);
    const Index left = mesh.origin[mesh.prev(h)];
    const Index right = mesh.origin[mesh.prev(twin)];
    if (left == right || valences[a] <= 3 || valences[b] <= 3) return false;
    for (Index g = 0; g < mesh.half_edge_count(); ++g)
        if ((mesh.origin[g] == left && mesh.target(g) == right) ||
            (mesh.origin[g] == right && mesh.target(g) == left))
            return false;
    const auto put = [&](Index face, std::array<Index, 3> corners) {
        std::copy(corners.begin(), corners.end(), shape.faces.corners.begin() + 3 * face);
    };
    put(mesh.face_of(h), {left, a, right});
    put(mesh.face_of(twin), {left, right, b});
    return true;
}

/// Every vertex to the mean of its neighbours in the angles of the torus, where no face can turn
/// over.
void relax(Polyhedron& shape) {
    struct Angles {
        double around = 0;
        double along = 0;
    };
    const auto turned = [](double angle) { return std::remainder(angle, 2 * M_PI); };
    const Topology mesh = *mesh::build(shape.faces, static_cast<Index>(shape.points.size()));
    const auto valences = mesh::valences(mesh);
    std::vector<Angles> angles;
    for (const auto& p : shape.points)
        angles.push_back({std::atan2(p.z, std::hypot(p.x, p.y) - 3), std::atan2(p.y, p.x)});
    for (int round = 0; round < 40; ++round) {
        std::vector<Angles> means = angles;
        for (Index h = 0; h < mesh.half_edge_count(); ++h) {
            const Index v = mesh.origin[h];
            const Angles& to = angles[mesh.target(h)];
            means[v].around += turned(to.around - angles[v].around) / valences[v];
            means[v].along += turned(to.along - angles[v].along) / valences[v];
        }
        angles = std::move(means);
    }
    for (std::size_t v = 0; v < angles.size(); ++v) {
        const double radius = 3 + std::cos(angles[v].around);
        shape.points[v] = {radius * std::cos(angles[v].along), radius * std::sin(angles[v].along),
                           std::sin(angles[v].around)};
    }
}

StiffResiduals no_residuals(const MeshHierarchy& hierarchy) {
    StiffResiduals residuals;
    for (int step = 0; step < hierarchy.steps(); ++step)
        residuals.emplace_back(hierarchy.rules(step).stiff.size());
    return residuals;
}

}  // namespace

Polyhedron torus(int size) {
    const PolygonMesh quads = *io::synthetic_mesh("torus", size);
    Polyhedron shape;
    for (const auto& v : quads.vertices) shape.points.push_back({v[0], v[1], v[2]});
    for (std::int64_t f = 0; f < quads.polygon_count(); ++f) {
        const auto quad = quads.polygon(f);
        const auto corner = [&](std::size_t k) { return static_cast<Index>(quad[k]); };
        shape.faces.add(std::array{corner(0), corner(1), corner(2)});
        shape.faces.add(std::array{corner(0), corner(2), corner(3)});
    }
    return shape;
}

Polyhedron irregular_torus(int size) {
    Polyhedron shape = torus(size);
    std::mt19937 random(7);
    const auto half_edges = static_cast<Index>(shape.faces.corners.size());
    for (Index tries = 0; tries < half_edges / 6; ++tries) flip(shape, random() % half_edges);
    relax(shape);
    return shape;
}

std::pair<Polyhedron, Index> torus_with_valence_eight(int size) {
    Polyhedron shape = torus(size);
    const Index vertex = 0;
    for (int valence = 6; valence < 8; ++valence) {
        const Topology mesh = *mesh::build(shape.faces, static_cast<Index>(shape.points.size()));
        // The edge across the vertex, in turn on opposite sides.
        Index h = mesh::outgoing(mesh)[vertex];
        for (int turn = 0; turn < 4 * (valence - 6); ++turn) h = mesh::rotated(mesh, h);
        flip(shape, mesh.next(h));
    }
    return {std::move(shape), vertex};
}

Model subdivided(const Polyhedron& base, multires::MeshScheme scheme, int steps,
                 std::optional<double> alpha) {
    Topology topology = *mesh::build(base.faces, static_cast<Index>(base.points.size()));
    Model model{
        *MeshHierarchy::create(std::move(topology), {}, {.scheme = scheme, .alpha = alpha}, steps),
        base.points};
    model.points.resize(model.hierarchy.vertices(steps));
    MeshMaps::create(model.hierarchy, {})
        ->synthesise(0, steps, model.points.data(), no_residuals(model.hierarchy));
    return model;
}

void put_on_torus(Points& points) {
    for (auto& p : points) {
        const double radius = std::hypot(p.x, p.y);
        const Vec3<double> ring{3 * p.x / radius, 3 * p.y / radius, 0};
        const Vec3<double> out = p - ring;
        p = ring + 1 / length(out) * out;
    }
}

void add_bumps(Model& model) {
    const Topology& mesh = model.hierarchy.topology(model.steps());
    const auto frames = multires::frames(mesh, model.points.data(), 0);
    for (std::size_t v = 0; v < model.points.size(); ++v) {
        Vec3<double>& p = model.points[v];
        const double bumps = 0.15 * std::sin(2 * p.x + 1) * std::cos(3 * p.y) +
                             0.05 * std::sin(7 * p.x) * std::sin(5 * p.y + 6 * p.z);
        const double ridge = 0.2 * std::max(0.0, 1 - std::abs(p.x - p.y) / 0.4);
        p += (bumps + ridge) * frames[v].normal;
    }
}

void add_noise(Points& points, double size, unsigned seed) {
    std::mt19937_64 random(seed);
    // Sums of twelve uniform numbers: nearly normal, and the same on every machine.
    const auto number = [&] {
        double sum = -6;
        for (int k = 0; k < 12; ++k) sum += static_cast<double>(random() >> 11) * 0x1p-53;
        return size * sum;
    };
    for (auto& p : points) {
        p.x += number();
        p.y += number();
        p.z += number();
    }
}

Points reversed(const Model& model, const multires::MeshTransform& transform, int levels,
                Points points) {
    const MeshMaps maps = *MeshMaps::create(model.hierarchy, transform);
    Points residuals;
    for (int step = model.steps() - 1; step >= model.steps() - levels; --step)
        maps.analyse_step(step, points.data(), residuals);
    points.resize(model.hierarchy.vertices(model.steps() - levels));
    return points;
}

Points reversed(const Model& model, multires::LiftKind lift, int levels) {
    return reversed(model, {.lift = lift}, levels, model.points);
}

double residual(const Model& model, const multires::MeshTransform& transform) {
    const int step = model.steps() - 1;
    const Points c = reversed(model, transform, 1, model.points);
    Points off(model.points.size());
    model.hierarchy.step(step).apply(c.data(), off.data(), off.data() + c.size());
    double sum = 0;
    for (std::size_t v = 0; v < off.size(); ++v)
        sum += dot(model.points[v] - off[v], model.points[v] - off[v]);
    return std::sqrt(sum);
}

double root_mean_square(const Points& points) {
    double sum = 0;
    for (const auto& p : points) sum += dot(p, p);
    return std::sqrt(sum / (3 * static_cast<double>(points.size())));
}

PolygonMesh mesh_at(const Model& model, int levels, const Points& points) {
    const mesh::FaceList faces = mesh::faces_of(model.hierarchy.topology(model.steps() - levels));
    PolygonMesh mesh;
    for (const auto& p : points) mesh.vertices.push_back({p.x, p.y, p.z});
    mesh.offsets = faces.offsets;
    mesh.corners.assign(faces.corners.begin(), faces.corners.end());
    return mesh;
}

}  // namespace relief::reproduce::reverse
