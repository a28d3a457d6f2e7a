#include "relief/mesh/topology.h"

#include <gtest/gtest.h>

#include "shapes.h"
#include "support.h"

namespace relief::mesh {
namespace {

using test::Shape;

std::string error_of(const FaceList& faces, Index vertices) {
    const auto built = build(faces, vertices);
    return built.ok() ? "" : built.error().text();
}

FaceList list(std::initializer_list<std::vector<Index>> faces) {
    FaceList result;
    for (const auto& face : faces) result.add(face);
    return result;
}

TEST(Topology, HalfEdgesOfTwoTriangles) {
    const Topology mesh = *build(list({{0, 1, 2}, {2, 1, 3}}), 4);
    EXPECT_EQ(mesh.sides, 3);
    EXPECT_EQ(mesh.edge_count, 5U);
    const std::vector<Index> twins(mesh.twin.data(), mesh.twin.data() + 6);
    EXPECT_EQ(twins, (std::vector<Index>{kNone, 3, kNone, 1, kNone, kNone}));
    const std::vector<Index> edges(mesh.edge.data(), mesh.edge.data() + 6);
    EXPECT_EQ(edges, (std::vector<Index>{0, 1, 2, 1, 3, 4}));
    EXPECT_EQ(mesh.target(2), 0U);
    EXPECT_EQ(mesh.prev(3), 5U);
    const auto valence = valences(mesh);
    EXPECT_EQ(std::vector<Index>(valence.data(), valence.data() + 4),
              (std::vector<Index>{2, 3, 3, 2}));
}

TEST(Topology, PolygonsOfSeveralSizes) {
    const Topology mesh = *build(list({{0, 1, 2, 3}, {1, 0, 4}, {2, 1, 4, 5, 6}}), 7);
    EXPECT_EQ(mesh.sides, 0);
    EXPECT_EQ(mesh.face_of(5), 1U);
    EXPECT_EQ(mesh.next(3), 0U);
    EXPECT_EQ(mesh.prev(7), 11U);
    EXPECT_EQ(mesh.twin[0], 4U);
    EXPECT_EQ(mesh.target(mesh.twin[7]), 2U);
    EXPECT_EQ(faces_of(mesh), list({{0, 1, 2, 3}, {1, 0, 4}, {2, 1, 4, 5, 6}}));
}

TEST(Topology, FansAndComponents) {
    const Shape shape = test::both(test::grid(4, 3, true), test::double_torus());
    const Topology mesh = shape.topology();
    EXPECT_EQ(mesh.sides, 0);
    EXPECT_EQ(components(mesh).count, 2U);
    EXPECT_EQ(euler_characteristic(mesh), 1 - 2);  // a disk and a surface of genus 2
    const auto out = outgoing(mesh);
    const auto valence = valences(mesh);
    for (Index v = 0; v < mesh.vertex_count; ++v) {
        ASSERT_EQ(mesh.origin[out[v]], v);
        Index faces = 0;
        for (Index h = out[v]; h != kNone; h = rotated(mesh, h)) {
            if (faces > 0 && h == out[v]) break;
            ASSERT_EQ(mesh.origin[h], v);
            ++faces;
        }
        EXPECT_EQ(valence[v], faces + (mesh.on_boundary(out[v]) ? 1 : 0));
    }
}

TEST(Topology, NamesWhatIsWrong) {
    EXPECT_NE(error_of({}, 3).find("empty_mesh"), std::string::npos);
    EXPECT_NE(error_of(list({{0, 1, 2}, {0, 1, 3}}), 3).find("face 1: index_out_of_range"),
              std::string::npos);
    EXPECT_NE(error_of(list({{0, 1}}), 2).find("too_few_corners"), std::string::npos);
    EXPECT_NE(error_of(list({{0, 1, 1}}), 2).find("repeated_corner"), std::string::npos);
    EXPECT_NE(error_of(list({{0, 1, 2}}), 4).find("vertex 3: unused_vertex"), std::string::npos);
    const std::string edge = error_of(list({{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}), 5);
    EXPECT_NE(edge.find("non_manifold_edge"), std::string::npos) << edge;
    EXPECT_NE(edge.find("face "), std::string::npos);
    EXPECT_NE(error_of(list({{0, 1, 2}, {0, 1, 3}}), 4).find("non_manifold_edge"),
              std::string::npos);
    EXPECT_NE(error_of(list({{0, 1, 2}, {0, 3, 4}}), 5).find("vertex 0: non_manifold_vertex"),
              std::string::npos);
    // A closed fan and an open one; two closed ones.
    Shape pair = test::both(test::tetrahedron(), test::tetrahedron());
    for (Index& v : pair.faces.corners) v = v == 4 ? 0 : v > 4 ? v - 1 : v;
    EXPECT_NE(error_of(pair.faces, 7).find("vertex 0: non_manifold_vertex"), std::string::npos);
    std::vector<Index> long_face(40);
    std::iota(long_face.begin(), long_face.end(), Index{0});
    long_face[39] = 7;
    EXPECT_NE(error_of(list({long_face}), 40).find("repeated_corner"), std::string::npos);
}

/// A hub of 200 000 triangles: buckets are sorted, not searched.
TEST(Topology, LargeFans) {
    FaceList faces;
    const Index rim = 200000;
    for (Index k = 0; k < rim; ++k) faces.add(std::array<Index, 3>{0, k + 1, (k + 1) % rim + 1});
    const Topology mesh = *build(faces, rim + 1);
    EXPECT_EQ(valences(mesh)[0], rim);
    EXPECT_EQ(mesh.edge_count, 2 * rim);
}

}  // namespace
}  // namespace relief::mesh
