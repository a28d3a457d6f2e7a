#include "relief/mesh/repair.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "mesh/real_meshes.h"
#include "shapes.h"

namespace relief::mesh {
namespace {

using Kind = MeshProblemKind;
using Faces = std::vector<std::vector<Index>>;

FaceList list(const Faces& faces) {
    FaceList result;
    for (const auto& face : faces) result.add(face);
    return result;
}

Faces vectors(const FaceList& faces) {
    Faces result;
    for (std::size_t f = 0; f < faces.size(); ++f)
        result.emplace_back(faces[f].begin(), faces[f].end());
    return result;
}

MeshProblem only_problem(const FaceList& faces, Index vertices) {
    const MeshDiagnosis diagnosis = diagnose(faces, vertices);
    EXPECT_EQ(diagnosis.problems.size(), 1U);
    return diagnosis.problems.empty() ? MeshProblem{} : diagnosis.problems[0];
}

/// What every repair promises.
void expect_sound(const FaceList& faces, const Repaired& repaired) {
    ASSERT_EQ(repaired.vertices.size(), repaired.vertex_count);
    ASSERT_EQ(repaired.sources.size(), repaired.faces.size());
    ASSERT_EQ(repaired.turned.size(), repaired.faces.size());
    ASSERT_EQ(repaired.corners.size(), repaired.faces.corners.size());
    for (std::size_t c = 0; c < repaired.corners.size(); ++c)
        ASSERT_EQ(repaired.vertices[repaired.faces.corners[c]], faces.corners[repaired.corners[c]]);
    for (std::size_t f = 0; f < repaired.faces.size(); ++f)
        for (auto c = repaired.faces.offsets[f]; c < repaired.faces.offsets[f + 1]; ++c) {
            const std::int64_t corner = repaired.corners[static_cast<std::size_t>(c)];
            ASSERT_GE(corner, faces.offsets[repaired.sources[f]]);
            ASSERT_LT(corner, faces.offsets[repaired.sources[f] + 1]);
        }
    if (repaired.faces.size() == 0) return;
    const auto built = build(repaired.faces, repaired.vertex_count);
    ASSERT_TRUE(built.ok()) << built.error().text();
    const Repaired again = repair(repaired.faces, repaired.vertex_count);
    EXPECT_TRUE(again.counts.nothing());
    EXPECT_EQ(again.faces, repaired.faces);
    EXPECT_TRUE(diagnose(repaired.faces, repaired.vertex_count).healthy());
}

Repaired sound_repair(const FaceList& faces, Index vertices) {
    Repaired repaired = repair(faces, vertices);
    expect_sound(faces, repaired);
    return repaired;
}

TEST(Repair, LeavesHealthyMeshesAsTheyAre) {
    for (const test::Shape& shape :
         {test::tetrahedron(), test::grid(4, 3, false), test::grid(5, 4, true, true),
          test::double_torus(), test::both(test::cube(), test::octahedron())}) {
        EXPECT_TRUE(diagnose(shape.faces, shape.size()).healthy());
        const Repaired repaired = sound_repair(shape.faces, shape.size());
        EXPECT_EQ(repaired.faces, shape.faces);
        EXPECT_EQ(repaired.vertex_count, shape.size());
        EXPECT_TRUE(repaired.counts.nothing());
    }
}

TEST(Repair, DropsFacesOfMissingVertices) {
    const FaceList faces = list({{0, 1, 2}, {0, 2, 7}});
    const MeshProblem problem = only_problem(faces, 3);
    EXPECT_EQ(problem.kind, Kind::MissingVertex);
    EXPECT_EQ(problem.element, 1U);
    EXPECT_EQ(problem.message.find("index_out_of_range: it names vertex 7 of 3"), 0U);
    const Repaired repaired = sound_repair(faces, 3);
    EXPECT_EQ(vectors(repaired.faces), (Faces{{0, 1, 2}}));
    EXPECT_EQ(repaired.counts, (RepairCounts{.faces_dropped = 1}));
}

TEST(Repair, RemovesRepeatedCornersAndSpikes) {
    const FaceList faces = list({{0, 1, 1, 2}, {2, 1, 3, 4, 3}, {0, 2, 2}});
    const MeshDiagnosis diagnosis = diagnose(faces, 5);
    EXPECT_EQ(diagnosis.count(Kind::RepeatedCorner), 3U);
    EXPECT_EQ(diagnosis.count(Kind::TooFewCorners), 1U);
    EXPECT_EQ(diagnosis.count(Kind::UnusedVertex), 1U);  // the tip of the spike
    ASSERT_EQ(diagnosis.problems.size(), 5U);
    EXPECT_EQ(diagnosis.problems[1].message, "repeated_corner: it names vertex 3 twice");
    EXPECT_EQ(diagnosis.problems[3].element, 2U);
    EXPECT_EQ(diagnosis.problems[3].message,
              "too_few_corners: no three different ones are left of its 3");
    const Repaired repaired = sound_repair(faces, 5);
    EXPECT_EQ(vectors(repaired.faces), (Faces{{0, 1, 2}, {2, 1, 3}}));
    EXPECT_EQ(repaired.corners, (std::vector<Index>{0, 2, 3, 4, 5, 8}));
    EXPECT_EQ(repaired.counts,
              (RepairCounts{.faces_dropped = 1, .corners_dropped = 3, .vertices_dropped = 1}));
}

/// A figure of eight becomes its two loops, which touch at a vertex.
TEST(Repair, CutsFacesAtRepeatedCorners) {
    const FaceList faces = list({{0, 1, 2, 0, 3, 4}});
    EXPECT_EQ(diagnose(faces, 5).count(Kind::RepeatedCorner), 1U);
    EXPECT_EQ(diagnose(faces, 5).count(Kind::SeveralFans), 1U);
    const Repaired repaired = sound_repair(faces, 5);
    EXPECT_EQ(vectors(repaired.faces), (Faces{{0, 1, 2}, {5, 3, 4}}));
    EXPECT_EQ(repaired.sources, (std::vector<Index>{0, 0}));
    EXPECT_EQ(repaired.vertices, (std::vector<Index>{0, 1, 2, 3, 4, 0}));
    EXPECT_EQ(repaired.counts, (RepairCounts{.faces_added = 1, .vertices_added = 1}));
}

TEST(Repair, DropsDuplicatesOfEitherDirection) {
    const FaceList faces = list({{0, 1, 2, 3}, {2, 1, 4}, {3, 2, 1, 0}, {1, 4, 2}, {1, 2, 3, 0}});
    const MeshDiagnosis diagnosis = diagnose(faces, 5);
    ASSERT_EQ(diagnosis.problems.size(), 3U);
    EXPECT_EQ(diagnosis.problems[0].element, 2U);
    EXPECT_EQ(diagnosis.problems[1].message, "duplicate_face: it has the corners of face 1");
    EXPECT_EQ(diagnosis.problems[2].message, "duplicate_face: it has the corners of face 0");
    const Repaired repaired = sound_repair(faces, 5);
    EXPECT_EQ(vectors(repaired.faces), (Faces{{0, 1, 2, 3}, {2, 1, 4}}));
    EXPECT_EQ(repaired.counts, (RepairCounts{.duplicates_dropped = 3}));
    // The same vertices in another order are another face.
    EXPECT_EQ(diagnose(list({{0, 1, 2, 3}, {0, 2, 1, 3}}), 4).count(Kind::DuplicateFace), 0U);
}

TEST(Repair, TurnsTheMinority) {
    FaceList faces = test::cube().faces;
    std::reverse(faces.corners.begin() + 4, faces.corners.begin() + 8);    // face 1
    std::reverse(faces.corners.begin() + 16, faces.corners.begin() + 20);  // face 4
    const MeshDiagnosis diagnosis = diagnose(faces, 8);
    EXPECT_EQ(diagnosis.count(Kind::TurnedFace), diagnosis.problems.size());
    EXPECT_EQ(diagnosis.count(Kind::TurnedFace), 6U);  // all sides but the one they share
    const Repaired repaired = sound_repair(faces, 8);
    EXPECT_EQ(repaired.turned, (std::vector<std::uint8_t>{0, 1, 0, 0, 1, 0}));
    EXPECT_EQ(repaired.counts, (RepairCounts{.faces_turned = 2}));
    EXPECT_EQ(repaired.corners[4], 4U);  // the first corner stays
    EXPECT_EQ(repaired.corners[5], 7U);
    for (std::size_t c = 0; c < 24; ++c)
        EXPECT_EQ(faces.corners[repaired.corners[c]], repaired.faces.corners[c]);
}

TEST(Repair, TheFirstFaceDecidesWithoutMajority) {
    const FaceList faces = list({{0, 1, 2}, {1, 2, 3}});
    const MeshProblem problem = only_problem(faces, 4);
    EXPECT_EQ(problem.kind, Kind::TurnedFace);
    EXPECT_EQ(problem.element, 1U);
    EXPECT_EQ(problem.edge, (std::array<Index, 2>{1, 2}));
    EXPECT_NE(problem.message.find("in the same direction as face 0"), std::string::npos);
    EXPECT_EQ(vectors(sound_repair(faces, 4).faces), (Faces{{0, 1, 2}, {1, 3, 2}}));
}

/// A strip of n quads whose ends are joined with a half turn.
FaceList moebius_band(Index n) {
    FaceList faces;
    for (Index k = 0; k < n; ++k) {
        const Index a = 2 * k;
        const bool last = k + 1 == n;
        faces.add(std::array<Index, 4>{a, last ? 1 : a + 2, last ? 0 : a + 3, a + 1});
    }
    return faces;
}

TEST(Repair, CutsMoebiusBandsWhereTheyDisagree) {
    const FaceList faces = moebius_band(7);
    const MeshProblem problem = only_problem(faces, 14);
    EXPECT_EQ(problem.kind, Kind::TurnedFace);
    EXPECT_EQ(problem.edge, (std::array<Index, 2>{0, 1}));
    const Repaired repaired = sound_repair(faces, 14);
    EXPECT_EQ(repaired.counts, (RepairCounts{.edges_cut = 1, .vertices_added = 2}));
    EXPECT_EQ(repaired.vertex_count, 16U);
    EXPECT_EQ(repaired.vertices[14], 1U);
    EXPECT_EQ(repaired.vertices[15], 0U);
    const Topology band = *build(repaired.faces, 16);
    EXPECT_EQ(euler_characteristic(band), 1);
}

/// Two cubes that touch along an edge come apart there, and both stay closed.
TEST(Repair, SplitsCrowdedEdges) {
    const test::Shape cubes = test::voxels({{0, 0, 0}, {1, 1, 0}});
    const MeshProblem problem = only_problem(cubes.faces, cubes.size());
    EXPECT_EQ(problem.kind, Kind::CrowdedEdge);
    EXPECT_NE(problem.message.find("has 4 faces"), std::string::npos);
    const Repaired apart = sound_repair(cubes.faces, cubes.size());
    EXPECT_EQ(apart.counts, (RepairCounts{.edges_split = 1, .vertices_added = 2}));
    const Topology two = *build(apart.faces, apart.vertex_count);
    EXPECT_EQ(components(two).count, 2U);
    EXPECT_EQ(euler_characteristic(two), 4);
    EXPECT_EQ(std::count(two.twin.data(), two.twin.data() + two.twin.size(), kNone), 0);
}

TEST(Repair, KeepsSurfacesWholeUnderFins) {
    test::Shape shape = test::grid(4, 4, false);
    const Index tip = shape.size();
    shape.points.push_back({2, 2, 5});
    shape.add({12, 13, tip});  // on an inner edge
    EXPECT_EQ(diagnose(shape.faces, shape.size()).count(Kind::CrowdedEdge), 1U);
    const Repaired repaired = sound_repair(shape.faces, shape.size());
    EXPECT_EQ(repaired.counts, (RepairCounts{.edges_split = 1, .vertices_added = 2}));
    EXPECT_EQ(vectors(repaired.faces).back(), (std::vector<Index>{26, 27, 25}));
}

TEST(Repair, ThreeFinsAreAllApart) {
    const FaceList faces = list({{0, 1, 2}, {1, 0, 3}, {0, 1, 4}});
    EXPECT_EQ(only_problem(faces, 5).message,
              "non_manifold_edge: the edge from vertex 0 to 1 has 3 faces");
    const Repaired repaired = sound_repair(faces, 5);
    EXPECT_EQ(vectors(repaired.faces), (Faces{{0, 1, 2}, {5, 6, 3}, {7, 8, 4}}));
    EXPECT_EQ(repaired.vertices, (std::vector<Index>{0, 1, 2, 3, 4, 1, 0, 0, 1}));
}

TEST(Repair, GivesEachFanAVertex) {
    const FaceList faces = list({{0, 1, 2}, {0, 3, 4}, {0, 4, 5}, {0, 6, 7}});
    const MeshProblem problem = only_problem(faces, 8);
    EXPECT_EQ(problem.kind, Kind::SeveralFans);
    EXPECT_EQ(problem.element, 0U);
    EXPECT_EQ(problem.message, "non_manifold_vertex: its faces form 3 fans");
    const Repaired repaired = sound_repair(faces, 8);
    EXPECT_EQ(vectors(repaired.faces), (Faces{{0, 1, 2}, {8, 3, 4}, {8, 4, 5}, {9, 6, 7}}));
    EXPECT_EQ(repaired.counts, (RepairCounts{.vertices_added = 2}));
}

TEST(Repair, ListsSomeAndCountsAll) {
    const MeshDiagnosis diagnosis = diagnose(list({{0, 1, 2}}), 1003, 7);
    EXPECT_EQ(diagnosis.problems.size(), 7U);
    EXPECT_EQ(diagnosis.problems[6].element, 9U);
    EXPECT_EQ(diagnosis.count(Kind::UnusedVertex), 1000U);
}

TEST(Repair, NothingIsLeftOfNothing) {
    EXPECT_TRUE(diagnose({}, 0).healthy());
    EXPECT_EQ(repair({}, 0).faces.size(), 0U);
    EXPECT_EQ(repair(list({{}, {1}, {0, 1}, {2, 2, 2}}), 3).counts,
              (RepairCounts{.faces_dropped = 4, .vertices_dropped = 3}));
}

/// Few vertices, so that everything happens.
FaceList random_soup() {
    FaceList faces;
    const auto count = *rc::gen::inRange(1, 40);
    const auto vertices = *rc::gen::inRange<Index>(3, 14);
    for (int k = 0; k < count; ++k) {
        const auto sides = *rc::gen::weightedElement<std::size_t>({{6, 3}, {3, 4}, {1, 6}});
        faces.add(
            *rc::gen::container<std::vector<Index>>(sides, rc::gen::inRange<Index>(0, vertices)));
    }
    return faces;
}

RC_GTEST_PROP(RepairProperty, MendsAnySoup, ()) {
    const FaceList faces = random_soup();
    const Repaired repaired = repair(faces, 15);
    expect_sound(faces, repaired);
    RC_ASSERT(!::testing::Test::HasFailure());
}

/// Faces that are simple and no duplicates all stay, with all corners.
RC_GTEST_PROP(RepairProperty, LosesNoFaceThatIsFine, ()) {
    const FaceList faces = random_soup();
    const MeshDiagnosis diagnosis = diagnose(faces, 15, 1000);
    std::set<Index> flawed;
    for (const MeshProblem& problem : diagnosis.problems)
        if (problem.kind <= Kind::DuplicateFace) flawed.insert(problem.element);
    const Repaired repaired = repair(faces, 15);
    std::set<Index> kept;
    for (std::size_t f = 0; f < repaired.faces.size(); ++f)
        if (repaired.faces[f].size() == faces[repaired.sources[f]].size())
            kept.insert(repaired.sources[f]);
    for (Index f = 0; f < faces.size(); ++f) RC_ASSERT(flawed.count(f) || kept.count(f));
}

/// A manifold of which some faces are turned comes back, but for a common turn of its components.
RC_GTEST_PROP(RepairProperty, OrientsManifolds, ()) {
    const auto kind = *rc::gen::inRange(0, 3);
    const test::Shape shape = kind == 0   ? test::double_torus()
                              : kind == 1 ? test::icosahedron()
                                          : test::grid(5, 3, false);
    FaceList faces = shape.faces;
    Index turned = 0;
    for (std::size_t f = 0; f < faces.size(); ++f)
        if (*rc::gen::inRange(0, 3) == 0) {
            std::reverse(faces.corners.begin() + faces.offsets[f],
                         faces.corners.begin() + faces.offsets[f + 1]);
            ++turned;
        }
    const Repaired repaired = repair(faces, shape.size());
    expect_sound(faces, repaired);
    RC_ASSERT(repaired.vertex_count == shape.size());
    RC_ASSERT(repaired.counts.edges_cut == 0U);
    RC_ASSERT(repaired.counts.faces_turned == std::min<std::size_t>(turned, faces.size() - turned));
}

TEST(Repair, RealModels) {
    for (const std::string name :
         {"moebius.obj", "bunny00.off", "fandisk.off", "elephant-with-holes.off", "blade.off",
          "camel.off", "man.off", "triple_vierbein.obj", "cross_quad.off", "mushroom.off"}) {
        const PolygonMesh mesh = test::real_mesh(name);
        if (mesh.vertices.empty()) GTEST_SKIP() << "there is no " << name;
        SCOPED_TRACE(name);
        const FaceList faces = faces_of(mesh);
        const auto vertices = static_cast<Index>(mesh.vertices.size());
        const MeshDiagnosis diagnosis = diagnose(faces, vertices);
        const Repaired repaired = sound_repair(faces, vertices);
        EXPECT_EQ(diagnosis.healthy(), repaired.counts.nothing());
        EXPECT_EQ(build(faces, vertices).ok(), diagnosis.healthy());
        if (name == "moebius.obj") {
            EXPECT_GT(repaired.counts.edges_cut, 0U);
            EXPECT_EQ(repaired.counts.faces_turned, 0U);
        }
    }
}

TEST(Repair, AttributesLabelsAndCreasesFollow) {
    PolygonMesh mesh;
    for (int v = 0; v < 8; ++v) mesh.vertices.push_back({double(v), 0, 0});
    for (const std::vector<std::int32_t>& face :
         {std::vector{0, 1, 2}, {0, 0, 1}, {0, 3, 4}, {3, 4, 6}})
        mesh.add_polygon(face);
    mesh.attributes.push_back({"weight", 1, SampleType::Float64, {10, 11, 12, 13, 14, 15, 16, 17}});
    mesh.attributes.push_back({"uv",
                               2,
                               SampleType::Float64,
                               {0, 1, 2, 3, 4, 5},
                               {0, 1, 2, -1, -1, -1, 2, 1, 0, 0, 1, 2}});
    mesh.labels.push_back({"g", {"front", "back"}, {0, -1, 1, 1}});
    mesh.creases = {{2, 0, 3}, {4, 3, HUGE_VAL}, {5, 6, 1}};
    mesh.sharp_vertices = {{0, 2}, {5, 1}};
    ASSERT_TRUE(check(mesh).ok());

    const RepairedMesh repaired = repair(mesh);
    const PolygonMesh& result = repaired.mesh;
    const Status status = check(result);
    ASSERT_TRUE(status.ok()) << status.error().text();
    EXPECT_EQ(
        repaired.counts,
        (RepairCounts{
            .faces_dropped = 1, .faces_turned = 1, .vertices_added = 1, .vertices_dropped = 2}));
    // Vertices 5 and 7 are gone, vertex 0 is 0 and 6, the last face is turned.
    EXPECT_EQ(result.corners, (std::vector<std::int32_t>{0, 1, 2, 6, 3, 4, 3, 5, 4}));
    EXPECT_EQ(result.attribute("weight")->values,
              (std::vector<double>{10, 11, 12, 13, 14, 16, 10}));
    EXPECT_EQ(result.attribute("uv")->corners,
              (std::vector<std::int32_t>{0, 1, 2, 2, 1, 0, 0, 2, 1}));
    EXPECT_EQ(result.labels[0].of_face, (std::vector<std::int32_t>{0, 1, 1}));
    EXPECT_EQ(result.creases, (std::vector<CreaseEdge>{{2, 0, 3}, {4, 3, HUGE_VAL}}));
    EXPECT_EQ(result.sharp_vertices, (std::vector<SharpVertex>{{0, 2}, {6, 2}}));
    EXPECT_EQ(repair(result).mesh, result);
}

}  // namespace
}  // namespace relief::mesh
