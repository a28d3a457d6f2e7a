#include "relief/mesh/triangulation.h"

#include <algorithm>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "mesh/triangle_meshes.h"

namespace relief::mesh {
namespace {

using test::TriangleMesh;

TriangleMesh golden_mesh(const nlohmann::json& data) {
    TriangleMesh mesh;
    for (const auto& v : data["vertices"]) mesh.vertices.push_back({v[0], v[1]});
    for (const auto& t : data["triangles"]) mesh.triangles.push_back({t[0], t[1], t[2]});
    return mesh;
}

/// The name of the error and the element.
using Refusal = std::pair<std::string, std::string>;
Refusal refused(const TriangleMesh& mesh, const TriangulationOptions& options = {}) {
    const auto result = build(mesh.vertices, mesh.triangles, options);
    if (result.ok()) return {"", ""};
    EXPECT_EQ(result.error().code, ErrorCode::BadInput);
    return {result.error().message.substr(0, result.error().message.find(':')),
            result.error().where};
}

TEST(Triangulation, GoldenNumberingOfEdges) {
    const nlohmann::json file = test::reference("triangulation.json");
    int meshes = 0;
    for (const nlohmann::json& data : file["cases"]) {
        for (const nlohmann::json& level : {data, data.value("triadic", data)}) {
            const Triangulation mesh = test::built(golden_mesh(level));
            EXPECT_EQ(nlohmann::json(mesh.edges), level["edges"]) << data["name"];
            EXPECT_EQ(nlohmann::json(mesh.triangles), level["triangles"]) << data["name"];
            ++meshes;
        }
    }
    EXPECT_EQ(meshes, 6);
}

/// What `build` guarantees, and that all arrays tell the same.
void expect_consistent(const Triangulation& mesh) {
    std::set<std::array<Index, 2>> edges;
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
        const auto [a, b, c] = mesh.corners(t);
        EXPECT_GT(orient(a, b, c), 0);
        for (Index k = 0; k < 3; ++k) {
            const Index from = mesh.triangles[t][k];
            const Index to = mesh.triangles[t][(k + 1) % 3];
            const Index e = mesh.triangle_edges[t][k];
            EXPECT_EQ(mesh.edges[e], (std::array{std::min(from, to), std::max(from, to)}));
            EXPECT_EQ(mesh.runs_forward(t, k), from == mesh.edges[e][0]);
            EXPECT_EQ(mesh.edge_triangles[e][from < to ? 0 : 1], t);
            const Index other = mesh.neighbour(t, k);
            EXPECT_EQ(mesh.on_boundary(e), other == kNone);
            if (other != kNone) {
                EXPECT_EQ(std::count(mesh.triangle_edges[other].begin(),
                                     mesh.triangle_edges[other].end(), e),
                          1);
            }
            edges.insert(mesh.edges[e]);
        }
    }
    // A set iterates in lexicographic order, which is the contract.
    EXPECT_EQ(std::vector(edges.begin(), edges.end()), mesh.edges);
    for (Index e = 0; e < mesh.edge_count(); ++e)
        EXPECT_EQ(mesh.edge_vector(e),
                  mesh.vertex(mesh.edges[e][1]) - mesh.vertex(mesh.edges[e][0]));
}

TEST(Triangulation, ArraysAgree) {
    for (const Triangulation& mesh : test::triangulation_family()) expect_consistent(mesh);
}

TEST(Triangulation, ConnectGivesWhatBuildGives) {
    for (const Triangulation& mesh : test::triangulation_family()) {
        const Triangulation again = connect(mesh.origin, mesh.x, mesh.y, mesh.triangles);
        EXPECT_EQ(again.origin, mesh.origin);
        EXPECT_EQ(again.x, mesh.x);
        EXPECT_EQ(again.triangles, mesh.triangles);
        EXPECT_EQ(again.edges, mesh.edges);
        EXPECT_EQ(again.edge_triangles, mesh.edge_triangles);
        EXPECT_EQ(again.triangle_edges, mesh.triangle_edges);
    }
}

TEST(Triangulation, CoordinatesAreRelativeToTheCentreOfTheBoundingBox) {
    const Triangulation mesh = test::built(test::triangle_grid(3, 3, 0.1, {2e6, -1e6}));
    EXPECT_EQ(mesh.origin, (Vec2{2e6 + 1.5, -1e6 + 1.5}));
    EXPECT_EQ(mesh.vertex(0), (Vec2{-1.5, -1.5}));
    EXPECT_EQ(mesh.vertex(15), (Vec2{1.5, 1.5}));
}

TEST(Triangulation, StarsListWhatIsAtEachVertex) {
    for (const Triangulation& mesh : test::triangulation_family()) {
        std::map<Index, std::set<Index>> triangles;
        std::map<Index, std::set<Index>> neighbours;
        for (Index t = 0; t < mesh.triangle_count(); ++t)
            for (const Index v : mesh.triangles[t]) {
                triangles[v].insert(t);
                for (const Index w : mesh.triangles[t])
                    if (w != v) neighbours[v].insert(w);
            }
        const VertexStars stars = vertex_triangles(mesh);
        const VertexStars rings = vertex_neighbours(mesh);
        for (Index v = 0; v < mesh.vertex_count(); ++v) {
            const auto star = stars.of(v);
            const auto ring = rings.of(v);
            EXPECT_EQ(std::vector(star.begin(), star.end()),
                      std::vector(triangles[v].begin(), triangles[v].end()));
            EXPECT_EQ(std::vector(ring.begin(), ring.end()),
                      std::vector(neighbours[v].begin(), neighbours[v].end()));
        }
    }
}

TEST(Triangulation, ClockwiseTrianglesAreTurnedOrRefused) {
    const TriangleMesh mesh{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {{0, 1, 2}, {0, 3, 2}}};
    EXPECT_EQ(test::built(mesh).triangles,
              (std::vector<std::array<Index, 3>>{{0, 1, 2}, {0, 2, 3}}));
    EXPECT_EQ(refused(mesh, {.strict_orientation = true}), (Refusal{"clockwise", "triangle 1"}));
}

TEST(Triangulation, NamesWhatIsWrongWithNumbers) {
    const TriangleMesh good = test::triangle_grid(2, 2);
    const double infinity = std::numeric_limits<double>::infinity();
    for (const double wrong : {std::nan(""), infinity, -infinity, 1.1e150}) {
        TriangleMesh mesh = good;
        mesh.vertices[5].y = wrong;
        EXPECT_EQ(refused(mesh), (Refusal{"non_finite_input", "vertex 5"}));
    }
    EXPECT_EQ(refused({good.vertices, {}}), (Refusal{"empty_mesh", ""}));
    EXPECT_EQ(refused({{}, {}}), (Refusal{"empty_mesh", ""}));
    TriangleMesh mesh = good;
    mesh.triangles[3][1] = 9;
    EXPECT_EQ(refused(mesh), (Refusal{"index_out_of_range", "triangle 3"}));
    mesh = good;
    mesh.triangles[4][2] = mesh.triangles[4][0];
    EXPECT_EQ(refused(mesh), (Refusal{"repeated_index", "triangle 4"}));
    mesh = good;
    mesh.vertices.insert(mesh.vertices.end(), 2, Vec2{9, 9});
    EXPECT_EQ(refused(mesh), (Refusal{"isolated_vertex", "vertex 9"}));
    mesh = good;
    mesh.vertices[0] = {-1, 2};
    mesh.vertices[1] = {0, 1.5};  // on the way to vertex 4
    EXPECT_EQ(refused(mesh), (Refusal{"degenerate_triangle", "triangle 0"}));
}

/// Twice the area of the unit triangle with height h is h.
TEST(Triangulation, ThinTrianglesAreRefusedFromTheStatedThreshold) {
    const auto thin = [](double height) {
        return TriangleMesh{{{0, 0}, {1, 0}, {0.5, height}}, {{0, 1, 2}}};
    };
    EXPECT_EQ(refused(thin(1.01e-12)), Refusal());
    EXPECT_EQ(refused(thin(0.99e-12)), (Refusal{"degenerate_triangle", "triangle 0"}));
}

TEST(Triangulation, NamesWhatIsWrongWithEdges) {
    const TriangleMesh third{{{0, 0}, {1, 0}, {0.5, 1}, {0.5, -1}, {0.5, 2}},
                             {{0, 1, 2}, {0, 3, 1}, {0, 1, 4}}};
    EXPECT_EQ(refused(third), (Refusal{"non_manifold_edge", "triangle 2"}));
    const TriangleMesh same_side{{{0, 0}, {1, 0}, {0.5, 1}, {0.5, 2}}, {{0, 1, 2}, {0, 1, 3}}};
    EXPECT_EQ(refused(same_side), (Refusal{"inconsistent_orientation", "triangle 1"}));
    const TriangleMesh twice{{{0, 0}, {1, 0}, {0.5, 1}}, {{0, 1, 2}, {2, 0, 1}}};
    EXPECT_EQ(refused(twice), (Refusal{"inconsistent_orientation", "triangle 1"}));
}

/// `turns` times round the first vertex in steps of less than 180 degrees.
TriangleMesh spiral(Index triangles, double turns, bool closed) {
    TriangleMesh mesh{{{0, 0}}, {}};
    const Index outer = closed ? triangles : triangles + 1;
    for (Index k = 0; k < outer; ++k) {
        const double angle = 2 * 3.14159265358979323846 * turns * k / triangles + 0.3;
        mesh.vertices.push_back({(1 + 0.1 * k) * std::cos(angle), (1 + 0.1 * k) * std::sin(angle)});
    }
    for (Index k = 0; k < triangles; ++k) mesh.triangles.push_back({0, 1 + k, 1 + (k + 1) % outer});
    return mesh;
}

TEST(Triangulation, FoldsAreFound) {
    EXPECT_EQ(refused(spiral(7, 1, true)), Refusal());
    EXPECT_EQ(refused(spiral(7, 2, true)), (Refusal{"folded_mesh", "vertex 0"}));
    EXPECT_EQ(refused(spiral(7, 0.99, false)), Refusal());
    EXPECT_EQ(refused(spiral(7, 1.01, false)), (Refusal{"folded_mesh", "vertex 0"}));
    // Two fans at a vertex, the second inside the first.
    TriangleMesh fans = spiral(3, 0.7, false);
    fans.vertices.insert(fans.vertices.end(), {{0.3, 0.3}, {0.2, 0.4}});
    fans.triangles.push_back({0, 5, 6});
    EXPECT_EQ(refused(fans), (Refusal{"folded_mesh", "vertex 0"}));
    // A slit that is closed is no fold.
    TriangleMesh slit = spiral(8, 1, false);
    slit.vertices[9] = slit.vertices[1];
    EXPECT_EQ(refused(slit), Refusal());
}

TEST(Triangulation, HangingVerticesAreFound) {
    // Beside edge 0-1 of one triangle lie two triangles that meet at vertex 3 in its middle.
    TriangleMesh mesh{{{0, 0}, {2, 0}, {1, 1}, {1, 0}, {0.5, -1}, {1.5, -1}},
                      {{0, 1, 2}, {0, 4, 3}, {3, 5, 1}, {4, 5, 3}}};
    EXPECT_EQ(refused(mesh), (Refusal{"hanging_vertex", "vertex 3"}));
    mesh.vertices[3].y = -1e-9;  // half the threshold, relative to the length of 2
    EXPECT_EQ(refused(mesh), (Refusal{"hanging_vertex", "vertex 3"}));
    mesh.vertices[3].y = -1e-8;
    EXPECT_EQ(refused(mesh), Refusal());
}

TEST(Triangulation, OverlapsThatShareNothingNeedTheFullCheck) {
    TriangleMesh mesh = test::triangle_grid(1, 1);
    mesh.vertices.insert(mesh.vertices.end(), {{0.5, 0.6}, {2, 0.4}, {2, 2}});
    mesh.triangles.push_back({4, 5, 6});
    EXPECT_EQ(refused(mesh), Refusal());
    EXPECT_EQ(refused(mesh, {.check_overlap = true}), (Refusal{"overlap", "triangle 0"}));
}

TEST(Triangulation, CompactKeepsUsedVerticesInTheirOrder) {
    const TriangleMesh mesh{{{9, 9}, {0, 0}, {8, 8}, {1, 0}, {0, 1}, {7, 7}}, {{4, 1, 3}}};
    const CompactTriangles compacted = *compact(mesh.vertices, mesh.triangles);
    EXPECT_EQ(compacted.vertices, (std::vector<Vec2>{{0, 0}, {1, 0}, {0, 1}}));
    EXPECT_EQ(compacted.triangles, (std::vector<std::array<Index, 3>>{{2, 0, 1}}));
    EXPECT_EQ(compacted.source, (std::vector<Index>{1, 3, 4}));
    const auto wrong = compact(mesh.vertices, std::vector<std::array<Index, 3>>{{4, 1, 6}});
    ASSERT_FALSE(wrong.ok());
    EXPECT_EQ(wrong.error().message.substr(0, 18), "index_out_of_range");
}

TEST(Triangulation, SmallAnglesAreReported) {
    const double height = std::tan(0.9 * 3.14159265358979323846 / 180);
    const Triangulation mesh =
        test::built({{{0, 0}, {1, 0}, {1, height}, {1, 1}}, {{0, 1, 2}, {0, 2, 3}}});
    const auto found = small_angles(mesh);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].triangle, 0u);
    EXPECT_NEAR(found[0].degrees, 0.9, 1e-12);  // roundings of atan2 and of degrees
    EXPECT_EQ(found[0].message.substr(0, 23), "small_angle: triangle 0");
}

/// The order of the triangles changes numbers of triangles only.
TEST(Triangulation, EdgesDoNotDependOnTheOrderOfTriangles) {
    TriangleMesh shuffled = test::triangle_grid(9, 7, 0.15);
    const Triangulation mesh = test::built(shuffled);
    std::mt19937 random(5);
    std::shuffle(shuffled.triangles.begin(), shuffled.triangles.end(), random);
    for (auto& t : shuffled.triangles) std::rotate(t.begin(), t.begin() + random() % 3, t.end());
    const Triangulation other = test::built(shuffled);
    EXPECT_EQ(other.edges, mesh.edges);
    expect_consistent(other);
}

}  // namespace
}  // namespace relief::mesh
