#include <gtest/gtest.h>

#include "mesh/twins.h"
#include "shapes.h"
#include "support.h"

namespace relief::mesh {
namespace {

Topology faces_alone(const FaceList& faces, Index vertex_count) {
    Topology mesh;
    mesh.vertex_count = vertex_count;
    set_faces(faces.offsets, faces.corners, mesh);
    return mesh;
}

/// The same twins as by sorting half-edges.
void expect_links(const test::Shape& shape) {
    Topology mesh = faces_alone(shape.faces, shape.size());
    Topology sorted = faces_alone(shape.faces, shape.size());
    ASSERT_EQ(link_corners(mesh), shape.size());
    ASSERT_TRUE(find_twins(sorted).empty());
    for (Index h = 0; h < mesh.half_edge_count(); ++h) ASSERT_EQ(mesh.twin[h], sorted.twin[h]);
}

/// Triangles around one vertex.
test::Shape wheel(Index spokes, bool closed) {
    test::Shape shape;
    shape.points.resize(spokes + 1);
    for (Index k = 1; k < spokes; ++k) shape.add({0, k, k + 1});
    if (closed) shape.add({0, spokes, 1});
    return shape;
}

TEST(LinkCorners, SameTwinsAsBySorting) {
    unsigned seed = 0;
    for (const test::Shape& shape :
         {test::icosahedron(), test::cube(), test::double_torus(), test::grid(5, 4, false),
          test::both(test::cube(), test::tetrahedron()), wheel(5, false), wheel(16, true),
          wheel(17, true), wheel(200, true), wheel(200, false)}) {
        expect_links(shape);
        expect_links(test::shuffled(shape, ++seed));
    }
    // More vertices than are linked at a time.
    expect_links(test::shuffled(test::grid(80, 90, true), ++seed));
}

TEST(LinkCorners, VerticesWithoutFacesAreNotCounted) {
    Topology mesh = faces_alone(test::cube().faces, 11);
    EXPECT_EQ(link_corners(mesh), 8U);
}

TEST(LinkCorners, Refusals) {
    for (const Index spokes : {4U, 40U}) {
        test::Shape shape = wheel(spokes, true);
        shape.points.resize(spokes + 3);
        test::Shape twice = shape;
        twice.add({0, 1, 2});  // a face twice
        test::Shape third = shape;
        third.add({2, 1, spokes + 1});
        third.add({1, 2, spokes + 2});  // three faces at an edge
        test::Shape fans = shape;
        fans.add({0, spokes + 1, spokes + 2});  // a second fan at vertex 0
        for (const test::Shape& bad : {twice, third, fans}) {
            Topology mesh = faces_alone(bad.faces, bad.size());
            EXPECT_FALSE(link_corners(mesh));
            EXPECT_FALSE(build(bad.faces, bad.size()).ok());
        }
    }
}

}  // namespace
}  // namespace relief::mesh
