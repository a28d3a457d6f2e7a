#include "relief/mesh/recognise.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "mesh/seed_spread.h"
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

std::vector<Shape> triangle_shapes() {
    return {test::tetrahedron(),
            test::flipped(test::icosahedron(), 50, 4),
            test::triangulated(test::double_torus()),
            test::grid(6, 6, true, true),
            test::both(test::octahedron(), test::tetrahedron()),
            test::grid(3, 2, true),
            test::without_faces(test::grid(5, 5, true, true), {7, 8, 30})};
}

std::vector<Shape> polygon_shapes() {
    return {test::cube(), test::double_torus(), test::grid(3, 4, false),
            test::both(test::tetrahedron(), test::grid(2, 2, false)),
            test::grid(4, 6, false, true)};
}

bool same_faces(const Topology& a, const Topology& b) {
    return faces_of(a) == faces_of(b);
}

/// Three levels are read off one after another, and no more.
void expect_in_order(const Shape& shape, Split split) {
    std::vector<Topology> levels;
    levels.push_back(test::shuffled(shape, 3).topology());
    for (int k = 0; k < 3; ++k) levels.push_back(*refine(levels.back(), split));
    Topology mesh = *build(faces_of(levels.back()), levels.back().vertex_count);
    for (std::size_t k = 3; k > 0; --k) {
        auto coarse = unsplit_in_order(mesh, split);
        ASSERT_TRUE(coarse) << k;
        EXPECT_TRUE(is_built(*coarse));
        EXPECT_EQ(coarse->vertex_count, levels[k - 1].vertex_count);
        // sqrt(3) does not tell where faces begin whose edges others have named.
        if (split != Split::Sqrt3Odd || k > 1) {
            EXPECT_TRUE(same_faces(*coarse, levels[k - 1])) << k;
        }
        EXPECT_TRUE(same_faces(*refine(*coarse, split), levels[k]));
        EXPECT_TRUE(std::equal(coarse->edge.data(), coarse->edge.data() + coarse->edge.size(),
                               build(faces_of(*coarse), coarse->vertex_count)->edge.data()));
        mesh = *std::move(coarse);
    }
}

TEST(UnsplitInOrder, LevelsComeBack) {
    for (const Shape& shape : triangle_shapes()) {
        expect_in_order(shape, Split::Loop);
        const bool closed = counts_of(shape.topology()).boundary_edges == 0;
        if (closed) expect_in_order(shape, Split::Sqrt3Odd);
    }
    for (const Shape& shape : polygon_shapes()) expect_in_order(shape, Split::CatmullClark);
}

TEST(UnsplitInOrder, OpenSqrt3) {
    const Topology base = test::grid(3, 2, true).topology();
    const Topology odd = *refine(base, Split::Sqrt3Odd);
    const auto coarse = unsplit_in_order(odd, Split::Sqrt3Odd);
    ASSERT_TRUE(coarse);
    EXPECT_TRUE(same_faces(*refine(*coarse, Split::Sqrt3Odd), odd));
    EXPECT_FALSE(unsplit_in_order(*refine(odd, Split::Sqrt3Even), Split::Sqrt3Even));
}

/// What is read off a spoiled mesh, if anything, is what that mesh is the split of.
TEST(UnsplitInOrder, SpoiledMeshes) {
    std::mt19937 random(11);
    int refused = 0;
    const auto spoil = [&](const Shape& shape, Split split) {
        const Topology fine = *refine(shape.topology(), split);
        FaceList faces = faces_of(fine);
        const auto sides = static_cast<std::size_t>(fine.sides);
        const std::size_t f = random() % faces.size();
        const std::size_t g = random() % faces.size();
        const auto begin = faces.corners.begin();
        const auto corner = [&](std::size_t face) {
            return begin + static_cast<std::ptrdiff_t>(sides * face);
        };
        switch (random() % 3) {
            case 0:  // a face begins elsewhere
                std::rotate(corner(f), corner(f) + 1, corner(f + 1));
                break;
            case 1:  // two faces change places
                if (f != g) std::swap_ranges(corner(f), corner(f + 1), corner(g));
                break;
            default: {  // two vertices change numbers
                const Index v = random() % fine.vertex_count;
                const Index w = random() % fine.vertex_count;
                for (Index& c : faces.corners) c = c == v ? w : c == w ? v : c;
            }
        }
        const Topology mesh = *build(faces, fine.vertex_count);
        const auto coarse = unsplit_in_order(mesh, split);
        if (coarse)
            EXPECT_TRUE(same_faces(*refine(*coarse, split), mesh));
        else
            ++refused;
    };
    for (int k = 0; k < 60; ++k) {
        for (const Shape& shape : triangle_shapes()) {
            spoil(shape, Split::Loop);
            spoil(shape, Split::Sqrt3Odd);
        }
        for (const Shape& shape : polygon_shapes()) spoil(shape, Split::CatmullClark);
    }
    EXPECT_GT(refused, 1000);
}

/// Two edges with the same ends: the split is a mesh, but what was split is none.
TEST(UnsplitInOrder, DoubleEdges) {
    const std::array<std::array<Index, 6>, 6> corners_and_edges{{{0, 1, 2, 0, 1, 2},
                                                                 {1, 0, 3, 0, 3, 4},
                                                                 {3, 0, 5, 3, 5, 6},
                                                                 {0, 1, 5, 7, 8, 5},
                                                                 {1, 0, 4, 7, 9, 10},
                                                                 {1, 3, 5, 4, 6, 8}}};
    FaceList faces;
    for (const auto& c : corners_and_edges) {
        const std::array<Index, 3> e{6 + c[3], 6 + c[4], 6 + c[5]};
        for (std::size_t k = 0; k < 3; ++k)
            faces.add(std::array<Index, 3>{c[k], e[k], e[(k + 2) % 3]});
        faces.add(e);
    }
    const auto fine = build(faces, 17);
    ASSERT_TRUE(fine.ok()) << fine.error().text();
    const auto coarse = unsplit_in_order(*fine, Split::Loop);
    ASSERT_TRUE(coarse);
    EXPECT_FALSE(is_built(*coarse));
    EXPECT_FALSE(Recognition(*fine, Split::Loop).ok());
}

/// Way by way, as a single label spreads.
struct PlainSpread {
    std::vector<mesh::Label> labels;
    std::array<Conflict, kMostWays> conflicts;
};
PlainSpread plain_spread(const Topology& fine, Split split, std::size_t way) {
    PlainSpread result{std::vector<Label>(fine.face_count, kUnlabelled), {}};
    const auto sides = static_cast<Index>(fine.sides);
    result.labels[0] = label_in(split, static_cast<PackedLabels>(0xE4), way);
    std::vector<Index> queue = {0};
    for (std::size_t k = 0; k < queue.size(); ++k)
        for (Index side = 0; side < sides; ++side) {
            const Index f = queue[k];
            const Index twin = fine.twin[sides * f + side];
            const Label label = result.labels[f];
            if (twin == kNone && !may_end(split, label, side)) {
                result.conflicts[way] = {kBoundaryPattern, f};
                return result;
            }
            if (twin == kNone) continue;
            const auto wanted = label_across(split, label, side, twin % sides);
            Label& other = result.labels[twin / sides];
            if (other == kUnlabelled) {
                other = static_cast<Label>(wanted);
                queue.push_back(twin / sides);
            } else if (other != wanted) {
                result.conflicts[way] = {kLabelConflict, twin / sides};
                return result;
            }
        }
    return result;
}

/// All labels at once are those of each way alone, and end at the same faces.
TEST(SeedSpread, AsWayByWay) {
    unsigned seed = 1;
    const auto compare = [&](const Topology& fine, Split split) {
        const SeedSpread packed = spread_seeds(fine, split);
        for (std::size_t way = 0; way < way_count(split); ++way) {
            const PlainSpread plain = plain_spread(fine, split, way);
            const Conflict& expected = plain.conflicts[way];
            const Conflict& found = packed.conflicts[0][way];
            ASSERT_STREQ(found.reason, expected.reason);
            ASSERT_EQ(found.face, expected.face);
            for (Index f = 0; !expected.reason && f < fine.face_count; ++f)
                ASSERT_EQ(label_in(split, packed.labels[f], way), plain.labels[f]);
        }
    };
    for (const Shape& shape : triangle_shapes()) {
        if (components(shape.topology()).count > 1) continue;
        for (const Split split : {Split::Loop, Split::Sqrt3Odd}) {
            const Shape fine = shape_of(*refine(shape.topology(), split));
            for (const Shape& mixed : {test::shuffled(fine, ++seed),
                                       test::shuffled(test::flipped(fine, 1, seed), seed)}) {
                compare(mixed.topology(), Split::Loop);
                compare(mixed.topology(), Split::Sqrt3Odd);
                compare(mixed.topology(), Split::Sqrt3Even);
            }
        }
    }
    for (const Shape& shape : {test::cube(), test::double_torus(), test::grid(3, 4, false)})
        compare(test::shuffled(shape_of(*refine(shape.topology(), Split::CatmullClark)), ++seed)
                    .topology(),
                Split::CatmullClark);
}

}  // namespace
}  // namespace relief::mesh
