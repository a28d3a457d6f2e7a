#include "edit/plane_moves.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "edit/quad_moves.h"
#include "edit/triangle_moves.h"
#include "mesh/meshes.h"
#include "mesh/triangle_meshes.h"
#include "relief/codec/ps_codec.h"
#include "relief/core/parallel.h"

namespace relief::edit {
namespace {

using mesh::Index;
namespace fvs_mesh = multires::fvs_mesh;
namespace ps = multires::ps;

/// Meshes of three levels with a hole, from the finest, and moves on them.
struct Quads {
    fvs_mesh::Hierarchy hierarchy = *fvs_mesh::Hierarchy::create(
        relief::test::built(relief::test::without_quad(relief::test::grid_mesh(5, 4, 1, 0.15), 7)),
        2);
    std::vector<CellMesh> meshes;

    Quads() {
        for (int m = 2; m >= 0; --m) meshes.emplace_back(hierarchy.mesh(m));
    }
    [[nodiscard]] std::unique_ptr<QuadMoves> moves() const {
        return std::make_unique<QuadMoves>(
            hierarchy, std::vector<const CellMesh*>{&meshes[0], &meshes[1], &meshes[2]});
    }
    static void expect_same(const QuadMoves& a, const QuadMoves& b) {
        for (int level = 0; level < 3; ++level) EXPECT_EQ(a.added(level), b.added(level));
    }
};

struct Triangles {
    relief::test::TriangleMesh plane = relief::test::triangle_grid(4, 3, 0.15, {}, 3);
    ps::Hierarchy hierarchy =
        *ps::Hierarchy::create(*ps::make_space(*mesh::build(plane.vertices, plane.triangles)), 2);
    std::vector<CellMesh> meshes;

    Triangles() {
        for (int m = 2; m >= 0; --m) meshes.emplace_back(hierarchy.space(m).mesh);
    }
    [[nodiscard]] std::unique_ptr<TriangleMoves> moves(std::size_t components = 1) const {
        return std::make_unique<TriangleMoves>(
            hierarchy, std::vector<const CellMesh*>{&meshes[0], &meshes[1], &meshes[2]},
            components);
    }
    static void expect_same(const TriangleMoves& a, const TriangleMoves& b) {
        for (int level = 0; level < 3; ++level) EXPECT_EQ(a.added(level), b.added(level));
    }
};

std::vector<PointMove> random_group(const std::vector<CellMesh>& meshes, std::mt19937& engine) {
    std::vector<PointMove> group;
    for (std::size_t k = 0; k <= engine() % 3; ++k) {
        const int level = static_cast<int>(engine() % 3);
        const auto number = [&] { return static_cast<double>(engine() % 2000) / 1000 - 1; };
        group.push_back({level, engine() % meshes[static_cast<std::size_t>(level)].vertices.size(),
                         Vec3<double>{0, 0, number()}, Vec2{number(), number()}});
    }
    return group;
}

/// Whatever was added and taken back before, what moves add is what the groups in effect add to the
/// bit; and what is said to have changed is what did.
template <class Kind>
void expect_function_of_groups() {
    const Kind kind;
    std::mt19937 engine(17);
    const auto moves = kind.moves();
    std::vector<std::pair<std::vector<PointMove>, PlaneMoves::Undo>> groups;
    for (int step = 0; step < 60; ++step) {
        if (!groups.empty() && engine() % 5 < 2) {
            moves->restore(groups.back().second);
            groups.pop_back();
        } else {
            auto group = random_group(kind.meshes, engine);
            PlaneMoves::Undo undo = moves->add(group);
            groups.emplace_back(std::move(group), std::move(undo));
        }
        if (engine() % 3 != 0) continue;
        set_thread_count(step % 2 + 1);
        moves->settle();
        const auto fresh = kind.moves();
        for (const auto& [group, undo] : groups) (void)fresh->add(group);
        fresh->settle();
        Kind::expect_same(*moves, *fresh);
    }
    set_thread_count(0);
    (void)moves->take_changed();
    moves->settle();
    for (const auto& level : moves->take_changed()) EXPECT_TRUE(level.empty());
}

TEST(QuadMoves, AreAFunctionOfTheGroups) {
    expect_function_of_groups<Quads>();
}

TEST(TriangleMoves, AreAFunctionOfTheGroups) {
    expect_function_of_groups<Triangles>();
}

TEST(QuadMoves, AreTheSplinesThroughTheRises) {
    const Quads quads;
    const auto moves = quads.moves();
    (void)moves->add({{2, 9, {0, 0, 2}, {}}, {1, 40, {0, 0, -1}, {}}, {0, 100, {0, 0, 0.5}, {}}});
    moves->settle();
    std::vector<double> rise(quads.hierarchy.mesh(0).vertex_count());
    rise[9] = 2;
    for (int level = 2; level >= 0; --level) {
        const mesh::Quadrangulation& mesh = quads.hierarchy.mesh(2 - level);
        const fvs_mesh::NodalData expected = *fvs_mesh::interpolate_values(mesh, rise);
        const fvs_mesh::NodalData& added = moves->added(level);
        // Roundings of a few sums of numbers below 10.
        for (std::size_t v = 0; v < rise.size(); ++v) {
            EXPECT_NEAR(added.value[v], expected.value[v], 1e-13);
            EXPECT_NEAR(added.dx[v], expected.dx[v], 1e-12);
            EXPECT_NEAR(added.dy[v], expected.dy[v], 1e-12);
        }
        for (std::size_t e = 0; e < added.normal.size(); ++e)
            EXPECT_NEAR(added.normal[e], expected.normal[e], 1e-12);
        if (level == 0) break;
        rise = predict(mesh, expected).value;
        rise[level == 2 ? 40 : 100] += level == 2 ? -1 : 0.5;
    }
}

TEST(TriangleMoves, OfThreeComponentsAreRefinedAsFilesDo) {
    const Triangles triangles;
    const ps::Space& finest = triangles.hierarchy.space(2);
    codec::PsSplines flat{
        2, std::vector<ps::Coefficients>(3, ps::Coefficients(finest.mesh.vertex_count()))};
    const codec::PsModel model{triangles.hierarchy.space(0).mesh, flat, {}};
    const Bytes file = codec::encode_ps(model, {.goal = {codec::Goal::Kind::Lossless, 0}})->bytes;
    const std::vector<codec::PsMove> file_moves = {
        {2, 6, 0, 1, {}}, {2, 6, 1, 2, {}}, {2, 6, 2, 3, {}}, {0, 99, 2, -1, {}}};
    const auto edited = *codec::PsFile::open(*codec::add_ps_moves(file, file_moves));
    const auto moves = triangles.moves(3);
    (void)moves->add({{2, 6, {1, 2, 3}, {}}, {0, 99, {0, 0, -1}, {}}});
    moves->settle();
    for (int level = 0; level < 3; ++level) {
        const codec::PsSurface surface = *edited.surface(level);
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t v = 0; v < surface.components[c].size(); ++v)
                for (std::size_t j = 0; j < 3; ++j)  // roundings of sums of numbers below 4
                    EXPECT_NEAR(moves->added(level)[c][v][j], surface.components[c][v][j], 1e-13);
    }
}

TEST(CellMesh, SetsOfNumbersAreTheSameByBothWays) {
    std::mt19937 engine(3);
    std::vector<Index> numbers;
    for (int k = 0; k < 500; ++k) numbers.push_back(engine() % 1000);
    std::vector<Index> few = numbers;
    std::vector<Index> many = numbers;
    sort_unique(few, 1 << 20);  // sorted
    sort_unique(many, 1000);    // marked
    EXPECT_EQ(few, many);
    EXPECT_TRUE(std::is_sorted(few.begin(), few.end()));
    EXPECT_EQ(std::adjacent_find(few.begin(), few.end()), few.end());
    EXPECT_EQ(merged({1, 3, 5}, {2, 3, 9}), (std::vector<Index>{1, 2, 3, 5, 9}));
}

}  // namespace
}  // namespace relief::edit
