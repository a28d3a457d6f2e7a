#include "relief/mesh/split.h"

#include <gtest/gtest.h>

#include "shapes.h"
#include "support.h"

namespace relief::mesh {
namespace {

using test::Shape;

const std::vector<Split> kTriangleSplits = {Split::Loop, Split::Sqrt3Odd, Split::Sqrt3Even};

std::vector<Index> vector_of(const Buffer<Index>& buffer) {
    return {buffer.data(), buffer.data() + buffer.size()};
}

/// Half-edges by arithmetic are those that are found by searching.
void expect_consistent(const Topology& coarse, Split split) {
    const auto fine = refine(coarse, split);
    ASSERT_TRUE(fine.ok()) << fine.error().text();
    const MeshCounts expected = refined(counts_of(coarse), split);
    EXPECT_EQ(fine->vertex_count, expected.vertices);
    EXPECT_EQ(fine->edge_count, expected.edges);
    EXPECT_EQ(fine->face_count, expected.faces);
    EXPECT_EQ(counts_of(*fine).boundary_edges, expected.boundary_edges);
    const auto built = build(faces_of(*fine), fine->vertex_count);
    ASSERT_TRUE(built.ok()) << built.error().text();
    EXPECT_EQ(vector_of(fine->twin), vector_of(built->twin));
    EXPECT_EQ(vector_of(fine->edge), vector_of(built->edge));
    EXPECT_EQ(fine->edge_count, built->edge_count);
    EXPECT_EQ(euler_characteristic(*fine), euler_characteristic(coarse));
}

TEST(Split, ReferenceFaces) {
    const auto golden = test::reference("reverse_subdivision.json");
    for (const auto& record : golden["decompositions"]) {
        const std::string scheme = record["scheme"];
        FaceList coarse_faces;
        for (const auto& face : record["coarse_faces"])
            coarse_faces.add(face.get<std::vector<Index>>());
        const Topology coarse = *build(coarse_faces, static_cast<Index>(record["coarse"].size()));
        const Split split = scheme == "loop"      ? Split::Loop
                            : scheme == "cc"      ? Split::CatmullClark
                            : record["mode"] == 2 ? Split::Sqrt3Even
                                                  : Split::Sqrt3Odd;
        const Topology fine = *refine(coarse, split);
        FaceList expected;
        for (const auto& face : record["fine_faces"]) expected.add(face.get<std::vector<Index>>());
        EXPECT_EQ(faces_of(fine), expected) << record["name"];
        EXPECT_EQ(fine.vertex_count, record["fine"].size());
    }
}

TEST(Split, HalfEdgesByArithmetic) {
    const std::vector<Shape> shapes = {test::tetrahedron(),
                                       test::icosahedron(),
                                       test::flipped(test::icosahedron(), 40, 3),
                                       test::grid(4, 5, true, true),
                                       test::triangulated(test::double_torus()),
                                       test::both(test::octahedron(), test::tetrahedron())};
    for (const Shape& shape : shapes)
        for (const Split split : kTriangleSplits) {
            expect_consistent(shape.topology(), split);
            expect_consistent(*refine(shape.topology(), split), split);
        }
    for (const Shape& shape :
         {test::cube(), test::double_torus(), test::grid(3, 4, false), test::grid(3, 3, true),
          test::both(test::tetrahedron(), test::grid(2, 2, false)), test::icosahedron()}) {
        expect_consistent(shape.topology(), Split::CatmullClark);
        expect_consistent(*refine(shape.topology(), Split::CatmullClark), Split::CatmullClark);
    }
}

TEST(Split, Boundaries) {
    Shape triangle{{}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
    triangle.add({0, 1, 2});
    const Shape annulus = test::without_faces(test::grid(4, 4, true), {10, 11, 12, 13});
    const Shape punctured = test::without_faces(test::grid(5, 5, true, true), {7, 8, 30});
    for (const Shape& shape : {triangle, test::grid(3, 2, true), annulus, punctured,
                               test::flipped(test::grid(4, 4, true), 30, 9)}) {
        const Topology base = shape.topology();
        expect_consistent(base, Split::Loop);
        expect_consistent(base, Split::Sqrt3Odd);
        const Topology odd = *refine(base, Split::Sqrt3Odd);
        expect_consistent(odd, Split::Sqrt3Even);
        const Topology even = *refine(odd, Split::Sqrt3Even);
        EXPECT_EQ(even.face_count, 9 * base.face_count);
        EXPECT_EQ(counts_of(even).boundary_edges, 3 * counts_of(base).boundary_edges);
        const Topology third = *refine(even, Split::Sqrt3Odd);
        expect_consistent(third, Split::Sqrt3Even);
    }
}

TEST(Split, Refusals) {
    const auto error_of = [](const Shape& shape, Split split) {
        const auto fine = refine(shape.topology(), split);
        return fine.ok() ? std::string() : fine.error().text();
    };
    EXPECT_NE(error_of(test::cube(), Split::Loop).find("face 0: not_triangles"), std::string::npos);
    const Shape mixed = test::both(test::tetrahedron(), test::cube());
    EXPECT_NE(error_of(mixed, Split::Sqrt3Odd).find("face 4: not_triangles"), std::string::npos);
    // Both triangles of a square have two boundary edges.
    EXPECT_NE(error_of(test::grid(1, 1, true), Split::Sqrt3Even).find("face 0: sqrt3_parity"),
              std::string::npos);
}

}  // namespace
}  // namespace relief::mesh
