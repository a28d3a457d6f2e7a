#include "relief/mesh/quadrangulation.h"

#include <limits>

#include "mesh/meshes.h"

namespace relief::mesh {
namespace {

using test::built;
using test::grid_mesh;
using test::QuadMesh;

template <class Array>
nlohmann::json rows_of(const std::vector<Array>& rows) {
    nlohmann::json list = nlohmann::json::array();
    for (const Array& row : rows) {
        nlohmann::json entry = nlohmann::json::array();
        for (const auto value : row) entry.push_back(static_cast<int>(value));
        list.push_back(entry);
    }
    return list;
}

QuadMesh golden_mesh(const nlohmann::json& data) {
    QuadMesh mesh;
    for (const auto& v : data["vertices"]) mesh.vertices.push_back({v[0], v[1]});
    for (const auto& q : data["quads"]) mesh.quads.push_back({q[0], q[1], q[2], q[3]});
    return mesh;
}

/// The name of the error and the element.
std::pair<std::string, std::string> refused(const QuadMesh& mesh,
                                            const BuildOptions& options = {}) {
    const auto result = build(mesh.vertices, mesh.quads, options);
    if (result.ok()) return {"", ""};
    EXPECT_EQ(result.error().code, ErrorCode::BadInput);
    return {result.error().message.substr(0, result.error().message.find(':')),
            result.error().where};
}
using Refusal = std::pair<std::string, std::string>;

TEST(Quadrangulation, GoldenNumbering) {
    const nlohmann::json file = test::reference("fvs_mesh.json");
    const nlohmann::json& data = file["hierarchy"][0];
    const Quadrangulation base = built(golden_mesh(data));
    EXPECT_EQ(rows_of(base.edges), data["edges"]);
    EXPECT_EQ(rows_of(base.quad_edges), data["quad_edges"]);
    EXPECT_EQ(rows_of(base.quad_signs), data["quad_signs"]);
    const Quadrangulation fine = *refine(base);
    const nlohmann::json& level = data["level1"];
    EXPECT_EQ(rows_of(fine.edges), level["edges"]);
    EXPECT_EQ(rows_of(fine.quads), level["quads"]);
    ASSERT_EQ(fine.vertex_count(), level["vertices"].size());
    for (Index v = 0; v < fine.vertex_count(); ++v) {
        // One rounding each: the origin, its addition and the division of the diagonals.
        EXPECT_NEAR(fine.x[v] + fine.origin.x, level["vertices"][v][0].get<double>(), 1e-15);
        EXPECT_NEAR(fine.y[v] + fine.origin.y, level["vertices"][v][1].get<double>(), 1e-15);
    }
    for (int m = 0; m < 3; ++m) {
        const LevelCounts n = *level_counts(base, m);
        EXPECT_EQ(nlohmann::json({n.quads, n.edges, n.vertices}), data["counts"][m]);
    }
}

TEST(Quadrangulation, CountsOfTable1) {
    const Quadrangulation base = built(grid_mesh(1, 1));
    const nlohmann::json table = test::reference("fvs_mesh.json")["table1"];
    ASSERT_EQ(table.size(), 9u);
    for (int m = 0; m <= 8; ++m) {
        const LevelCounts n = *level_counts(base, m);
        EXPECT_EQ(n.quads, table[m]["Q"].get<std::uint64_t>());
        EXPECT_EQ(n.edges, table[m]["E"].get<std::uint64_t>());
        EXPECT_EQ(n.vertices, table[m]["V"].get<std::uint64_t>());
    }
}

/// What `build` guarantees, and that sides, edges and signs tell the same.
void expect_consistent(const Quadrangulation& mesh) {
    for (Index q = 0; q < mesh.quad_count(); ++q)
        for (int i = 0; i < 4; ++i) {
            const Index a = mesh.quads[q][i];
            const Index b = mesh.quads[q][(i + 1) % 4];
            const auto& edge = mesh.edges[mesh.quad_edges[q][i]];
            const bool forward = mesh.quad_signs[q][i] > 0;
            EXPECT_EQ(edge, (forward ? std::array{a, b} : std::array{b, a}));
            const Vec2 in = mesh.vertex(a) - mesh.vertex(mesh.quads[q][(i + 3) % 4]);
            EXPECT_GT(cross(in, mesh.vertex(b) - mesh.vertex(a)), 0) << "quad " << q;
        }
    const auto sides = edge_quads(mesh);
    for (Index e = 0; e < mesh.edge_count(); ++e) {
        if (sides[e][1] == kNoQuad) continue;
        int sum = 0;
        for (const Index q : sides[e])
            for (int i = 0; i < 4; ++i)
                if (mesh.quad_edges[q][i] == e) sum += mesh.quad_signs[q][i];
        EXPECT_EQ(sum, 0) << "edge " << e;
    }
}

double area(const Quadrangulation& mesh) {
    double sum = 0;
    for (Index q = 0; q < mesh.quad_count(); ++q) sum += 0.5 * doubled_area(mesh.corners(q));
    return sum;
}

TEST(Quadrangulation, RefinementIsConvexAndKeepsTheDomain) {
    for (const Quadrangulation& base : test::mesh_family()) {
        expect_consistent(base);
        Quadrangulation mesh = base;
        for (int m = 1; m <= 3; ++m) {
            mesh = *refine(mesh);
            expect_consistent(mesh);
            EXPECT_NEAR(area(mesh), area(base), 1e-12 * area(base));  // rounding of the sum
            const LevelCounts n = *level_counts(base, m);
            EXPECT_EQ(n.vertices, mesh.vertex_count());
            EXPECT_EQ(n.edges, mesh.edge_count());
            EXPECT_EQ(n.quads, mesh.quad_count());
        }
    }
}

/// Lemma of section 3: the diagonals of child i meet in (v_i + c) / 2.
TEST(Quadrangulation, DiagonalsOfChildrenMeetOnTheParentsDiagonal) {
    for (const Quadrangulation& base : test::mesh_family()) {
        const Quadrangulation fine = *refine(base);
        for (Index q = 0; q < base.quad_count(); ++q) {
            const QuadCorners v = base.corners(q);
            const Vec2 c = diagonals(v).centre;
            for (Index i = 0; i < 4; ++i) {
                const Vec2 child = diagonals(fine.corners(4 * q + i)).centre;
                EXPECT_NEAR(length(child - midpoint(v[i], c)), 0, 1e-15);
            }
        }
    }
}

TEST(Quadrangulation, SmallestAngleStaysAfterTheFirstLevel) {
    for (std::uint64_t seed = 1; seed < 20; ++seed) {
        Quadrangulation mesh = built(test::random_quad(seed));
        double angles[4] = {};
        for (double& angle : angles) {
            angle = 180;
            for (Index q = 0; q < mesh.quad_count(); ++q)
                angle = std::min(angle, smallest_angle(mesh.corners(q)));
            mesh = *refine(mesh);
        }
        EXPECT_NEAR(angles[2], angles[1], 1e-9);
        EXPECT_NEAR(angles[3], angles[1], 1e-9);
        EXPECT_GT(angles[1], 0.3 * angles[0]);
    }
    EXPECT_NEAR(smallest_angle({Vec2{0, 0}, {1, 0}, {1, 1}, {0, 1}}), 45, 1e-12);
}

TEST(Quadrangulation, NamedErrors) {
    const QuadMesh good = grid_mesh(2, 1);
    EXPECT_EQ(refused(good), Refusal("", ""));
    QuadMesh bad = good;
    bad.vertices[3].y = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(refused(bad), Refusal("non_finite_vertex", "vertex 3"));
    bad.vertices[3].y = 1e200;
    EXPECT_EQ(refused(bad), Refusal("non_finite_vertex", "vertex 3"));
    bad = good;
    bad.quads[1][2] = 6;
    EXPECT_EQ(refused(bad), Refusal("index_out_of_range", "quad 1"));
    bad.quads[1][2] = bad.quads[1][0];
    EXPECT_EQ(refused(bad), Refusal("repeated_vertex", "quad 1"));
    bad = good;
    std::swap(bad.quads[1][1], bad.quads[1][3]);
    EXPECT_EQ(refused(bad), Refusal("clockwise", "quad 1"));
    EXPECT_EQ(refused(bad, {.reorient = true}), Refusal("", ""));
    bad = good;
    bad.vertices[4] = {0.4, 0.4};
    EXPECT_EQ(refused(bad), Refusal("not_strictly_convex", "quad 0"));
    bad.vertices[4] = {0.5, 0.5};
    EXPECT_EQ(refused(bad), Refusal("not_strictly_convex", "quad 0"));  // a corner of 180 degrees
    bad = good;
    bad.quads.push_back(bad.quads[0]);
    EXPECT_EQ(refused(bad), Refusal("edge_used_twice_in_same_direction", "quad 2"));
    bad = good;
    bad.vertices.push_back({7, 7});
    EXPECT_EQ(refused(bad), Refusal("unused_vertex", "vertex 6"));
    EXPECT_EQ(refused({}), Refusal("empty_mesh", ""));
}

TEST(Quadrangulation, FoldIsRefused) {
    // The third quad lies on the same side of the edge 1 -> 2 as the first.
    const QuadMesh fold = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.2, 0.2}, {0.2, 0.8}},
                           {{0, 1, 2, 3}, {1, 2, 5, 4}}};
    EXPECT_EQ(refused(fold), Refusal("edge_used_twice_in_same_direction", "quad 1"));
}

TEST(Quadrangulation, TJunctions) {
    // Two small quads beside the right side of a large one.
    const QuadMesh mesh = {{{0, 0}, {2, 0}, {2, 2}, {0, 2}, {3, 0}, {3, 1}, {2, 1}, {3, 2}},
                           {{0, 1, 2, 3}, {1, 4, 5, 6}, {6, 5, 7, 2}}};
    EXPECT_EQ(refused(mesh), Refusal("t_junction", "vertex 6"));
    QuadMesh apart = mesh;
    apart.vertices[6].x = 2.001;
    EXPECT_EQ(refused(apart), Refusal("", ""));
    EXPECT_EQ(refused(test::grid_mesh(30, 30, 1, 0.19)), Refusal("", ""));
}

TEST(Quadrangulation, Overlaps) {
    QuadMesh mesh = grid_mesh(10, 10, 1, 0.19);
    const Index first = static_cast<Index>(mesh.vertices.size());
    const auto add_square = [&](double x, double y, double size) {
        QuadMesh more = mesh;
        for (const Vec2 p : {Vec2{0, 0}, {1, 0}, {1, 1}, {0, 1}})
            more.vertices.push_back({x + size * p.x, y + size * p.y});
        more.quads.push_back({first, first + 1, first + 2, first + 3});
        return more;
    };
    const BuildOptions check{.check_overlap = true};
    EXPECT_EQ(refused(mesh, check), Refusal("", ""));
    EXPECT_EQ(refused(add_square(4.4, 3.4, 0.2), check), Refusal("overlap", "quad 34"));
    EXPECT_EQ(refused(add_square(-1, -1, 20), check), Refusal("overlap", "quad 0"));
    EXPECT_EQ(refused(add_square(9.9, 9.9, 3), check), Refusal("overlap", "quad 99"));
    EXPECT_EQ(refused(add_square(10, 10, 3), check), Refusal("", ""));  // touches in a point
    EXPECT_EQ(refused(add_square(4.4, 3.4, 0.2)), Refusal("", ""));     // not asked for
}

TEST(Quadrangulation, Polygons) {
    const QuadMesh mesh = grid_mesh(2, 1);
    const std::vector<Index> corners = {0, 1, 4, 3, 1, 2, 5, 4};
    const Quadrangulation from =
        *build_from_polygons(mesh.vertices, std::vector<Index>{4, 4}, corners);
    EXPECT_EQ(from.quads, mesh.quads);
    const auto triangle = build_from_polygons(mesh.vertices, std::vector<Index>{4, 3}, corners);
    ASSERT_FALSE(triangle.ok());
    EXPECT_EQ(triangle.error().message.rfind("not_a_quad", 0), 0u);
    EXPECT_EQ(triangle.error().where, "polygon 1");
    const auto short_list =
        build_from_polygons(mesh.vertices, std::vector<Index>{4, 4, 4}, corners);
    ASSERT_FALSE(short_list.ok());
    EXPECT_EQ(short_list.error().message.rfind("size_mismatch", 0), 0u);
}

TEST(Quadrangulation, LevelsOutOfRange) {
    const Quadrangulation base = built(grid_mesh(1, 1));
    EXPECT_TRUE(level_counts(base, 14).ok());
    for (const int level : {-1, 15, 16, 1000000000}) {
        const auto counts = level_counts(base, level);
        ASSERT_FALSE(counts.ok()) << level;
        EXPECT_EQ(counts.error().message.rfind("level_out_of_range", 0), 0u);
    }
}

TEST(Quadrangulation, WarnsOfSmallAngles) {
    QuadMesh thin = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {3, 0.005}, {3, 0.01}}, {{0, 1, 2, 3}}};
    thin.quads.push_back({1, 4, 5, 2});
    thin.vertices[4] = {80, 0.9};
    thin.vertices[5] = {80, 1};
    const auto found = warnings(built(thin));
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].quad, 1u);
    EXPECT_LT(found[0].degrees, 1);
    EXPECT_TRUE(warnings(built(grid_mesh(3, 3, 1, 0.19))).empty());
}

}  // namespace
}  // namespace relief::mesh
