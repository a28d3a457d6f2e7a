#include "relief/mesh/recognise.h"

#include <gtest/gtest.h>

#include <set>

#include "shapes.h"
#include "support.h"

namespace relief::mesh {
namespace {

using test::Shape;

/// The mesh of a topology; places do not matter.
Shape shape_of(const Topology& mesh) {
    return {faces_of(mesh), std::vector<test::Point>(mesh.vertex_count)};
}

/// Each face from its smallest corner, sorted.
std::set<std::vector<Index>> face_set(const FaceList& faces) {
    std::set<std::vector<Index>> set;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        std::vector<Index> face(faces[f].begin(), faces[f].end());
        std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
        set.insert(face);
    }
    return set;
}

/// The split of what was found is the mesh that was given.
void expect_origin(const Topology& fine, const Unsplit& found, Split split) {
    const auto again = refine(found.mesh, split);
    ASSERT_TRUE(again.ok()) << again.error().text();
    ASSERT_EQ(again->half_edge_count(), fine.half_edge_count());
    const auto half_edges = fine_half_edges(found.mesh, split, fine, found.fine);
    std::vector<Index> vertices(fine.vertex_count, kNone);
    for (Index h = 0; h < fine.half_edge_count(); ++h) {
        Index& vertex = vertices[again->origin[h]];
        if (vertex == kNone) vertex = fine.origin[half_edges[h]];
        ASSERT_EQ(vertex, fine.origin[half_edges[h]]);
        ASSERT_EQ(half_edges[again->next(h)], fine.next(half_edges[h]));
        const Index twin = again->twin[h];
        ASSERT_EQ(twin == kNone ? kNone : half_edges[twin], fine.twin[half_edges[h]]);
    }
    for (std::size_t v = 0; v < found.old_vertices.size(); ++v)
        EXPECT_EQ(vertices[v], found.old_vertices[v]);
    EXPECT_TRUE(std::is_sorted(found.old_vertices.begin(), found.old_vertices.end()));
}

/// All ways of all components are tried together: way k of each, as far as there are so many.
void expect_found(const Topology& coarse, Split split, unsigned seed) {
    const Topology split_mesh = *refine(coarse, split);
    std::vector<Index> numbers;
    const Shape mixed = test::shuffled(shape_of(split_mesh), seed, &numbers);
    const Topology fine = mixed.topology();
    const Recognition recognition(fine, split);
    ASSERT_TRUE(recognition.ok()) << recognition.error().text();
    // The truth, in the numbers of the shuffled mesh.
    FaceList truth = faces_of(coarse);
    for (Index& v : truth.corners) v = numbers[v];
    const auto expected = face_set(truth);
    std::set<std::vector<Index>> seen;
    for (std::size_t k = 0; k < 4; ++k) {
        std::vector<std::size_t> choice;
        for (std::size_t c = 0; c < recognition.components(); ++c)
            choice.push_back(std::min(k, recognition.ways(c) - 1));
        const auto found = recognition.unsplit(choice);
        ASSERT_TRUE(found.ok()) << found.error().text();
        expect_origin(fine, *found, split);
        FaceList faces = faces_of(found->mesh);
        for (Index& v : faces.corners) v = found->old_vertices[v];
        const auto some = face_set(faces);
        seen.insert(some.begin(), some.end());
    }
    for (const auto& face : expected) EXPECT_TRUE(seen.count(face));
}

TEST(Recognition, ReferenceCases) {
    const auto golden = test::reference("reverse_subdivision.json");
    for (const auto& record : golden["recognition"]) {
        FaceList faces;
        for (const auto& face : record["faces"]) faces.add(face.get<std::vector<Index>>());
        const Topology fine = *build(faces, record["n_vertices"].get<Index>());
        const std::string scheme = record["scheme"];
        std::vector<Split> splits = {Split::Sqrt3Odd, Split::Sqrt3Even};
        if (scheme == "loop") splits = {Split::Loop};
        if (scheme == "cc") splits = {Split::CatmullClark};
        bool contains_truth = false;
        for (const Split split : splits) {
            const Recognition recognition(fine, split, true);
            if (!recognition.ok()) continue;
            const auto expected =
                record["candidates_per_component"].get<std::vector<std::size_t>>();
            ASSERT_EQ(recognition.components(), expected.size());
            EXPECT_EQ(recognition.ways(0), expected[0]) << record["name"];
            FaceList truth;
            for (const auto& face : record["true_coarse_faces"])
                truth.add(face.get<std::vector<Index>>());
            for (std::size_t way = 0; way < recognition.ways(0); ++way) {
                const Unsplit found = *recognition.unsplit({way});
                expect_origin(fine, found, split);
                FaceList coarse = faces_of(found.mesh);
                for (Index& v : coarse.corners) v = found.old_vertices[v];
                contains_truth = contains_truth || coarse == truth;
            }
        }
        EXPECT_TRUE(contains_truth) << record["name"];
    }
}

TEST(Recognition, ShuffledMeshesAreRecognised) {
    const Shape holed = test::without_faces(test::grid(5, 5, true, true), {7, 8, 30});
    const Shape annulus = test::without_faces(test::grid(4, 4, true), {10, 11, 12, 13});
    unsigned seed = 1;
    for (const Shape& shape :
         {test::tetrahedron(), test::flipped(test::icosahedron(), 50, 4),
          test::triangulated(test::double_torus()), test::grid(3, 2, true), holed, annulus,
          test::both(test::icosahedron(), test::grid(2, 2, true)),
          test::both(test::octahedron(), test::flipped(test::icosahedron(), 30, 4))}) {
        const Topology base = shape.topology();
        expect_found(base, Split::Loop, ++seed);
        expect_found(*refine(base, Split::Loop), Split::Loop, ++seed);
        expect_found(base, Split::Sqrt3Odd, ++seed);
        const Topology odd = *refine(base, Split::Sqrt3Odd);
        expect_found(odd, Split::Sqrt3Even, ++seed);
        expect_found(*refine(odd, Split::Sqrt3Even), Split::Sqrt3Odd, ++seed);
    }
    for (const Shape& shape :
         {test::cube(), test::double_torus(), test::grid(3, 4, false), test::tetrahedron(),
          test::both(test::tetrahedron(), test::grid(2, 2, false)), test::octahedron()}) {
        const Topology base = shape.topology();
        expect_found(base, Split::CatmullClark, ++seed);
        expect_found(*refine(base, Split::CatmullClark), Split::CatmullClark, ++seed);
    }
}

TEST(Recognition, RegularToriHaveSeveralWays) {
    const Topology triangles = test::grid(6, 6, true, true).topology();
    EXPECT_EQ(Recognition(*refine(triangles, Split::Loop), Split::Loop).ways(0), 4U);
    EXPECT_EQ(Recognition(*refine(triangles, Split::Sqrt3Odd), Split::Sqrt3Odd).ways(0), 3U);
    const Topology quads = test::grid(6, 6, false, true).topology();
    EXPECT_EQ(Recognition(*refine(quads, Split::CatmullClark), Split::CatmullClark, true).ways(0),
              4U);
    // Polygons: coarse vertices and face points may be exchanged.
    const Topology solid = *refine(test::double_torus().topology(), Split::CatmullClark);
    EXPECT_EQ(Recognition(solid, Split::CatmullClark).ways(0), 2U);
    EXPECT_EQ(Recognition(solid, Split::CatmullClark, true).ways(0), 1U);
}

TEST(Recognition, SpoiledMeshesAreRefused) {
    for (unsigned seed = 1; seed <= 12; ++seed) {
        for (const Split split : {Split::Loop, Split::Sqrt3Odd}) {
            const Topology base = test::flipped(test::icosahedron(), 30, seed).topology();
            const Shape fine = shape_of(*refine(base, split));
            const Shape flipped = test::flipped(fine, 1, seed);
            if (face_set(flipped.faces) == face_set(fine.faces)) continue;
            const Topology spoiled = flipped.topology();
            const Recognition recognition(spoiled, split);
            EXPECT_FALSE(recognition.ok());
            EXPECT_NE(recognition.error().text().find("component 0: no_subdivision_connectivity"),
                      std::string::npos);
        }
        for (const Split split : {Split::Loop, Split::Sqrt3Odd, Split::CatmullClark}) {
            const bool quads = split == Split::CatmullClark;
            const Topology base =
                quads ? test::double_torus().topology() : test::icosahedron().topology();
            const Shape fine = shape_of(*refine(base, split));
            const Topology holed =
                test::without_faces(fine, {(7 * seed) % fine.faces.size()}).topology();
            EXPECT_FALSE(Recognition(holed, split).ok());
            if (!quads) {
                EXPECT_FALSE(Recognition(holed, Split::Sqrt3Even).ok());
            }
        }
    }
    // One component of two; other faces than the split has.
    const Topology pair = test::both(shape_of(*refine(test::icosahedron().topology(), Split::Loop)),
                                     test::tetrahedron())
                              .topology();
    const Recognition some(pair, Split::Loop);
    EXPECT_FALSE(some.ok());
    EXPECT_EQ(some.ways(0), 1U);
    EXPECT_EQ(some.error().where, "component 1");
    const Topology cube = test::cube().topology();
    EXPECT_NE(Recognition(cube, Split::Loop).error().message.find("not_triangles"),
              std::string::npos);
    const Topology triangles = test::octahedron().topology();
    EXPECT_NE(Recognition(triangles, Split::CatmullClark).error().message.find("not_quads"),
              std::string::npos);
}

}  // namespace
}  // namespace relief::mesh
