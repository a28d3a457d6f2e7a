#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "edit/session_testing.h"
#include "relief/codec/mesh_codec.h"
#include "relief/multires/subdivide.h"
#include "shapes.h"
#include "support.h"

/// Files of meshes for tests of the editor.
namespace relief::edit {

using mesh::Index;
using multires::MeshScheme;

/// Base edges [first corner, next corner] of some faces that are creases.
using Creases = std::vector<std::array<Index, 2>>;

/// A subdivided mesh with noise.
inline PolygonMesh subdivided(const test::Shape& base, MeshScheme scheme, int steps, double noise,
                              const Creases& creases = {}) {
    multires::SubdividedMesh<double> mesh{base.topology(), {{}}, {}};
    for (const auto& p : base.points) mesh.arrays[0].push_back({p[0], p[1], p[2]});
    if (!creases.empty()) mesh.sharpness.edges.assign(mesh.mesh.edge_count, 0);
    for (const auto& [a, b] : creases)
        for (Index h = 0; h < mesh.mesh.half_edge_count(); ++h)
            if (mesh.mesh.origin[h] == a && mesh.mesh.target(h) == b)
                mesh.sharpness.edges[mesh.mesh.edge[h]] = HUGE_VAL;
    mesh = *multires::subdivide(std::move(mesh), {.scheme = scheme}, steps);
    test::Noise random(5);
    PolygonMesh result;
    for (auto& p : mesh.arrays[0])
        result.vertices.push_back(
            {p.x + noise * random(), p.y + noise * random(), p.z + noise * random()});
    const mesh::FaceList faces = mesh::faces_of(mesh.mesh);
    result.offsets = faces.offsets;
    result.corners.assign(faces.corners.begin(), faces.corners.end());
    for (Index h = 0; !creases.empty() && h < mesh.mesh.half_edge_count(); ++h)
        if (mesh.mesh.is_first(h) && mesh.sharpness.edges[mesh.mesh.edge[h]] > 0)
            result.creases.push_back({static_cast<std::int32_t>(mesh.mesh.origin[h]),
                                      static_cast<std::int32_t>(mesh.mesh.target(h)), HUGE_VAL});
    return result;
}

/// A grid of quads of which some are triangles and others, in pairs, hexagons: vertices between
/// those have three edges.
inline test::Shape polygons(Index size) {
    const test::Shape quads = test::grid(size, size, false);
    test::Shape shape{{}, quads.points};
    for (Index r = 0; r < size; ++r)
        for (Index c = 0; c < size; ++c) {
            const Index a = r * (size + 1) + c;
            const Index d = a + size + 1;
            if (r % 5 == 2 && c % 6 == 1) {
                shape.add({a, a + 1, a + 2, d + 2, d + 1, d});
                ++c;
            } else if (r % 4 == 1 && c % 7 == 4) {
                shape.add({a, a + 1, d + 1});
                shape.add({a, d + 1, d});
            } else {
                shape.add({a, a + 1, d + 1, d});
            }
        }
    return shape;
}

struct MeshCase {
    const char* name;
    PolygonMesh mesh;
    MeshScheme scheme;
};

/// Wide enough that moves of one vertex leave vertices of all levels alone.
inline std::vector<MeshCase> wide_meshes() {
    const test::Shape open = test::flipped(test::grid(24, 24, true), 60, 2);
    const test::Shape torus = test::grid(32, 24, true, true);
    Creases creases;
    for (Index k = 0; k < 12; ++k) creases.push_back({25 * 6 + 3 + k, 25 * 6 + 4 + k});
    for (Index k = 0; k < 24; ++k) creases.push_back({25 * k + 10, 25 * k + 35});
    return {
        {"loop", subdivided(torus, MeshScheme::Loop, 2, 0.01), MeshScheme::Loop},
        {"loop_open", subdivided(open, MeshScheme::Loop, 2, 0.01), MeshScheme::Loop},
        {"loop_creases", subdivided(test::grid(24, 24, true), MeshScheme::Loop, 2, 0.01, creases),
         MeshScheme::Loop},
        {"polygons", subdivided(polygons(24), MeshScheme::CatmullClark, 2, 0.01),
         MeshScheme::CatmullClark},
        {"quads_creases",
         subdivided(test::grid(24, 24, false), MeshScheme::CatmullClark, 2, 0.01, creases),
         MeshScheme::CatmullClark},
        {"sqrt3_open", subdivided(open, MeshScheme::Sqrt3, 3, 0.01), MeshScheme::Sqrt3},
        {"sqrt3", subdivided(torus, MeshScheme::Sqrt3, 2, 0.01), MeshScheme::Sqrt3},
    };
}

inline Bytes encoded(const PolygonMesh& mesh, codec::MeshEncodeOptions options) {
    auto file = codec::encode_mesh(mesh, options);
    EXPECT_TRUE(file.ok()) << file.error().text();
    return std::move(file->bytes);
}

inline Bytes encoded(const MeshCase& c, codec::Goal goal) {
    return encoded(c.mesh, {.goal = goal, .scheme = c.scheme});
}

/// What the saved file decodes to.
inline PolygonMesh decoded(const Session& session, int level = 0) {
    auto bytes = session.file();
    EXPECT_TRUE(bytes.ok()) << bytes.error().text();
    auto file = codec::MeshFile::open(*std::move(bytes));
    EXPECT_TRUE(file.ok()) << file.error().text();
    auto mesh = file->decode(level);
    EXPECT_TRUE(mesh.ok()) << mesh.error().text();
    return *std::move(mesh);
}

/// The largest side of the box around what is shown.
inline double size_of(const Session& session) {
    const Bounds box = session.bounds();
    const Vec3<double> size = box.max - box.min;
    return std::max({size.x, size.y, size.z});
}

inline double largest_difference(const Session& session, const SurfaceGeometry& shown,
                                 const PolygonMesh& mesh) {
    EXPECT_EQ(shown.position.size(), mesh.vertices.size());
    const Vec3<double>& o = session.description().origin;
    double most = 0;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        const auto& [x, y, z] = mesh.vertices[v];
        const Vec3<double> was = Vec3<double>{x, y, z} - o;
        const Point& p = shown.position[v];
        most = std::max(most, length(Vec3<double>{p[0], p[1], p[2]} - was));
    }
    return most;
}

}  // namespace relief::edit
