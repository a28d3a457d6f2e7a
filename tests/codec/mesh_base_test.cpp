#include "codec/mesh_base.h"

#include <gtest/gtest.h>

#include "shapes.h"
#include "support.h"

namespace relief::codec {
namespace {

using mesh::Index;
using test::Shape;

std::vector<GridPoint> on_grid(const Shape& shape, double step) {
    std::vector<GridPoint> points;
    for (const auto& p : shape.points)
        points.push_back(
            {std::llround(p[0] / step), std::llround(p[1] / step), std::llround(p[2] / step)});
    return points;
}

/// What is decoded is the mesh in the order that the encoder tells.
double expect_round_trip(const Shape& shape, double step) {
    const mesh::Topology mesh = shape.topology();
    const auto points = on_grid(shape, step);
    const CodedBase coded = encode_base(mesh, points);
    const auto decoded = decode_base(coded.bytes, mesh.sides, mesh.vertex_count, mesh.face_count);
    EXPECT_TRUE(decoded.ok()) << (decoded.ok() ? "" : decoded.error().text());
    if (!decoded.ok()) return 0;
    EXPECT_EQ(decoded->points.size(), points.size());
    for (std::size_t v = 0; v < points.size(); ++v)
        EXPECT_EQ(decoded->points[v], points[coded.vertices[v]]);
    EXPECT_EQ(decoded->faces.size(), mesh.face_count);
    for (std::size_t f = 0; f < decoded->faces.size(); ++f) {
        Index h = coded.corners[f];
        for (const Index v : decoded->faces[f]) {
            EXPECT_EQ(coded.vertices[v], mesh.origin[h]);
            h = mesh.next(h);
        }
        EXPECT_EQ(h, coded.corners[f]);
    }
    return 8.0 * static_cast<double>(coded.bytes.size()) / static_cast<double>(points.size());
}

TEST(MeshBase, RoundTrips) {
    const Shape holed = test::without_faces(test::grid(5, 5, true, true), {7, 8, 30});
    const Shape annulus = test::without_faces(test::grid(4, 4, true), {10, 11, 12, 13});
    Shape triangle{{}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
    triangle.add({0, 1, 2});
    for (const Shape& shape :
         {triangle, test::tetrahedron(), test::octahedron(), test::icosahedron(), test::cube(),
          test::flipped(test::icosahedron(), 60, 5), test::grid(7, 5, true),
          test::grid(7, 5, false), test::grid(6, 7, true, true), test::grid(6, 7, false, true),
          holed, annulus, test::double_torus(), test::triangulated(test::double_torus()),
          test::both(test::tetrahedron(), test::double_torus()),
          test::both(holed, test::both(annulus, test::icosahedron()))})
        for (unsigned seed = 1; seed < 6; ++seed)
            expect_round_trip(test::shuffled(shape, seed), 1e-3);
}

TEST(MeshBase, RandomTriangulations) {
    for (unsigned seed = 1; seed < 30; ++seed) {
        const bool periodic = seed % 2 == 0;
        Shape shape = test::flipped(test::grid(6, 6, true, periodic), 80, seed);
        if (seed % 3 == 0) shape = test::without_faces(shape, {seed, 2 * seed % 72});
        if (!mesh::build(shape.faces, shape.size()).ok()) continue;
        expect_round_trip(shape, 1e-2);
    }
}

/// Regular meshes take few bits.
TEST(MeshBase, ConnectivityIsSmall) {
    Shape flat = test::grid(40, 40, true);
    for (auto& p : flat.points) p[2] = 0;
    EXPECT_LT(expect_round_trip(flat, 1), 0.5);  // predicted exactly
    Shape irregular = test::flipped(test::grid(20, 20, true), 400, 3);
    for (auto& p : irregular.points) p = {0, 0, 0};
    EXPECT_LT(expect_round_trip(irregular, 1), 4.5);
}

TEST(MeshBase, HostileBytes) {
    const Shape shape = test::flipped(test::double_torus(), 0, 1);
    const mesh::Topology mesh = shape.topology();
    const Bytes bytes = encode_base(mesh, on_grid(shape, 1e-3)).bytes;
    std::mt19937 random(1);
    for (int k = 0; k < 3000; ++k) {
        Bytes altered = bytes;
        for (unsigned edits = 0; edits <= random() % 4; ++edits)
            altered[random() % altered.size()] = static_cast<std::uint8_t>(random());
        if (random() % 4 == 0) altered.resize(random() % altered.size());
        const int sides = random() % 3 == 0 ? 0 : random() % 2 ? 3 : 4;
        const auto decoded =
            decode_base(altered, sides, mesh.vertex_count, mesh.face_count + random() % 3);
        if (!decoded.ok()) continue;
        for (const Index v : decoded->faces.corners) ASSERT_LT(v, mesh.vertex_count);
    }
}

}  // namespace
}  // namespace relief::codec
