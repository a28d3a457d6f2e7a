#include <nlohmann/json.hpp>

#include "mesh_support.h"

namespace relief::edit {
namespace {

using Json = nlohmann::json;
using Kind = codec::Goal::Kind;

constexpr codec::Goal kLossless{Kind::Lossless, 0};
constexpr codec::Goal kClose{Kind::MaxError, 1e-3};

/// What is shown may be off by the tolerance of each step between the moved level and the one that
/// is shown, at most three here, and of what was left out before. Then it is rounded to floats of
/// less than half the box: 2^-26 of the box in each coordinate.
double allowed(const Session& session) {
    const double tolerance = 0x1p-27 * size_of(session);
    return (4 + 2 * std::sqrt(3.0)) * tolerance;
}

void expect_saved(const Session& session, const char* what) {
    EXPECT_LT(largest_difference(session, surface(session), decoded(session)), allowed(session))
        << what;
}

Move move_of(int level, std::vector<std::uint64_t> points, Vec3<double> delta) {
    return {.level = level, .points = std::move(points), .delta = delta};
}

/// A vertex in the middle of a level.
std::uint64_t middle(const Session& session, int level) {
    return session.description().levels[static_cast<std::size_t>(level)].control_points / 2;
}

class EveryMesh : public testing::TestWithParam<std::size_t> {
  protected:
    MeshCase mesh = wide_meshes()[GetParam()];
};

TEST_P(EveryMesh, ShowsWhatTheSavedFileDecodesTo) {
    for (const codec::Goal goal : {kLossless, kClose}) {
        Session session = opened(encoded(mesh, goal));
        EXPECT_EQ(session.description().kind, edit::Kind::Mesh);
        expect_saved(session, "as it is");
        const int coarsest = static_cast<int>(session.description().levels.size()) - 1;
        ASSERT_GE(coarsest, 2);
        for (const int level : {coarsest, 1, 0, coarsest, 1}) {
            const std::uint64_t point = middle(session, level) + 3;
            ASSERT_TRUE(session.apply(move_of(level, {point, point + 1}, {0.1, -0.2, 0.4})).ok());
            expect_saved(session, level == 0 ? "finest" : level == 1 ? "finer" : "coarsest");
        }
        ASSERT_TRUE(session
                        .apply({.level = coarsest,
                                .points = {middle(session, coarsest)},
                                .delta = {0, 0, -0.5},
                                .falloff = {.radius = 3}})
                        .ok());
        expect_saved(session, "falloff");
        for (int level = 1; level <= coarsest; ++level) {
            ASSERT_TRUE(session.set_view({.level = level}).ok());
            EXPECT_LT(largest_difference(session, surface(session), decoded(session, level)),
                      allowed(session));
        }
        // Its own moves are part of a file.
        const Session again = opened(*session.file());
        expect_saved(again, "opened again");
    }
}

/// Puts a patch into what is shown.
void patch(SurfaceGeometry& shown, const SurfacePatch& part) {
    ASSERT_EQ(part.level, shown.level);
    for (std::size_t k = 0; k < part.at.size(); ++k) {
        shown.position[part.at[k]] = part.position[k];
        shown.normal[part.at[k]] = part.normal[k];
        if (!shown.error.empty()) shown.error[part.at[k]] = part.error[k];
        if (!shown.curvature.empty()) shown.curvature[part.at[k]] = part.curvature[k];
    }
}

void expect_same(const SurfaceGeometry& a, const SurfaceGeometry& b, const char* what) {
    EXPECT_TRUE(a.position == b.position) << what;
    EXPECT_TRUE(a.normal == b.normal) << what;
    EXPECT_TRUE(a.error == b.error) << what;
    EXPECT_TRUE(a.curvature == b.curvature) << what;
}

TEST_P(EveryMesh, PatchesKeepTheSurfaceCurrentAndUndoGivesBackEveryBit) {
    Session session = opened(encoded(mesh, kClose));
    const int coarsest = static_cast<int>(session.description().levels.size()) - 1;
    for (const int level : {0, 1}) {
        ASSERT_TRUE(
            session.set_view({.level = level, .extras = {.error = true, .curvature = true}}).ok());
        SurfaceGeometry shown = surface(session);
        const SurfaceGeometry first = shown;
        const auto step = [&](const Result<Change>& change, const char* what) {
            ASSERT_TRUE(change.ok()) << change.error().text();
            EXPECT_GT(change->touched, 0U) << what;
            patch(shown, change->surface);
            expect_same(shown, surface(session), what);
        };
        const std::uint64_t point = middle(session, coarsest);
        step(session.apply(move_of(coarsest, {point}, {0, 0, 0.5})), "move");
        const SurfaceGeometry moved = shown;
        for (const double z : {0.001, 0.3, 0.31, 0.2})
            step(session.drag(move_of(coarsest, {point, point + 1}, {0, 0.1, z})), "drag");
        step(session.release(), "release");
        expect_same(shown, moved, "released");
        step(session.apply(move_of(1, {middle(session, 1)}, {0.05, 0, 0})), "finer");
        const SurfaceGeometry both = shown;
        step(session.undo(), "undo");
        expect_same(shown, moved, "undone");
        step(session.redo(), "redo");
        expect_same(shown, both, "redone");
        step(session.undo(2), "undo all");
        expect_same(shown, first, "nothing done");
    }
}

/// A drag is what the move is, but for what is left out: at most the tolerance of each step, and
/// the last digit of a float.
TEST_P(EveryMesh, DragsShowWhatTheMoveDoes) {
    Session session = opened(encoded(mesh, kClose));
    const int coarsest = static_cast<int>(session.description().levels.size()) - 1;
    const std::uint64_t point = middle(session, coarsest) + 2;
    for (const double z : {0.01, -0.5, 0.7, 0.4})
        ASSERT_TRUE(session.drag(move_of(coarsest, {point}, {0, 0, z})).ok());
    const SurfaceGeometry dragged = surface(session);
    ASSERT_TRUE(session.apply(move_of(coarsest, {point}, {0, 0, 0.4})).ok());
    const SurfaceGeometry moved = surface(session);
    double most = 0;
    for (std::size_t v = 0; v < moved.position.size(); ++v)
        for (std::size_t k = 0; k < 3; ++k)
            most = std::max<double>(most, std::abs(moved.position[v][k] - dragged.position[v][k]));
    EXPECT_LT(most, allowed(session));
}

INSTANTIATE_TEST_SUITE_P(Meshes, EveryMesh, testing::Range<std::size_t>(0, 7),
                         [](const auto& test) {
                             return std::string(wide_meshes()[test.param].name);
                         });

TEST(MeshSession, AnEditFarAwayTouchesNothingHere) {
    const PolygonMesh mesh = subdivided(test::grid(64, 64, true), MeshScheme::Loop, 1, 0.01);
    Session session = opened(encoded(mesh, {.scheme = MeshScheme::Loop}));
    const SurfaceGeometry before = surface(session);
    const auto change = session.apply(move_of(1, {0}, {0, 0, 0.3}));
    ASSERT_TRUE(change.ok());
    const SurfaceGeometry after = surface(session);
    std::size_t moved = 0;
    for (std::size_t v = 0; v < before.position.size(); ++v) {
        const Point& p = before.position[v];
        const Point& q = before.position[0];
        const double away = std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
        const bool same = after.position[v] == before.position[v];
        moved += same ? 0 : 1;
        EXPECT_TRUE(same || away < 30) << away;
    }
    EXPECT_GT(moved, 5U);  // the corner, and what a Loop function at it reaches
    EXPECT_GE(change->touched, moved);
    EXPECT_LT(change->touched, before.position.size() / 4);
}

/// A coarse patch, turned: the details far inside it turn with it.
TEST(MeshSession, TurnedPatchesTakeTheirDetailsAlong) {
    const PolygonMesh mesh = subdivided(test::grid(28, 28, true), MeshScheme::Loop, 2, 0.01);
    Session session = opened(encoded(mesh, {.scheme = MeshScheme::Loop}));
    const PolygonMesh base = decoded(session, 2);
    Json script = Json::array();
    // A quarter turn about (14, 14) of all within 8, in moves of their own.
    for (std::size_t v = 0; v < base.vertices.size(); ++v) {
        const double x = base.vertices[v][0] - 14;
        const double y = base.vertices[v][1] - 14;
        if (std::hypot(x, y) > 8) continue;
        script.push_back(
            {{"do", "move"}, {"level", 2}, {"points", {v}}, {"delta", {-y - x, x - y, 0}}});
    }
    Session turned = opened(encoded(mesh, {.scheme = MeshScheme::Loop}));
    const Status done = turned.replay(Json::parse(script.dump()));
    ASSERT_TRUE(done.ok()) << done.error().text();
    const SurfaceGeometry before = surface(session);
    const SurfaceGeometry after = surface(turned);
    const Vec3<double>& o = turned.description().origin;
    double most = 0;
    for (std::size_t v = 0; v < before.position.size(); ++v) {
        const Point& p = before.position[v];
        const double x = p[0] + o.x - 14;
        const double y = p[1] + o.y - 14;
        if (std::hypot(x, y) > 2) continue;
        const Vec3<double> expected{14 - y - o.x, 14 + x - o.y, p[2]};
        const Point& q = after.position[v];
        most = std::max(most, length(Vec3<double>{q[0], q[1], q[2]} - expected));
    }
    // Details are of 0.01. What the surface around, which stays, does to the lift falls off by a
    // half a ring, and is 6 rings away.
    EXPECT_LT(most, 1e-3);
}

TEST(MeshSession, ScriptsReplayToTheSameBytes) {
    const MeshCase mesh = wide_meshes()[3];
    const Bytes file = encoded(mesh, kLossless);
    Session session = opened(file);
    for (const char* command :
         {R"({"do": "move", "level": 2, "points": [30, 31], "delta": [0, 0.1, 0.4]})",
          R"({"do": "drag", "of": "move", "level": 1, "points": [3], "delta": 0.9})",
          R"({"do": "drag", "of": "move", "level": 1, "points": [3], "delta": 0.2})",
          R"({"do": "move", "level": 1, "points": [200], "delta": [0, 0, 0.3],
              "falloff": {"radius": 2.5, "profile": "linear"}})",
          R"({"do": "move", "level": 0, "points": [7], "delta": 1e-3})", R"({"do": "undo"})",
          R"({"do": "move", "level": 2, "points": [7], "delta": 0.1,
              "falloff": {"radius": 3, "profile": "sharp"}})",
          R"({"do": "undo", "count": 2})", R"({"do": "redo", "count": 1})"})
        ASSERT_TRUE(session.run(Json::parse(command)).ok()) << command;
    EXPECT_EQ(session.history().done, 2U);
    EXPECT_EQ(session.history().entries[0].text, "move 2 points of level 2");

    Session again = opened(file);
    ASSERT_TRUE(again.replay(Json::parse(session.script().dump())).ok());
    EXPECT_EQ(*again.file(), *session.file());
    expect_same(surface(again), surface(session), "replayed");
}

/// A vertex with falloff along edges that are 1 or sqrt(2) long.
TEST(MeshSession, FalloffFollowsEdgesInSpace) {
    test::Shape flat = test::grid(12, 12, false);
    for (auto& p : flat.points) p[2] = 0;
    const PolygonMesh mesh = subdivided(flat, MeshScheme::CatmullClark, 1, 0);
    Session session = opened(encoded(mesh, {.goal = {Kind::MaxError, 1e-7}, .levels = 1}));
    const NetGeometry before = *session.net(1, {});
    const std::uint64_t point = 13 * 6 + 6;
    ASSERT_TRUE(session
                    .apply({.level = 1,
                            .points = {point},
                            .delta = {0, 0, 1},
                            .falloff = {.radius = 3, .profile = Falloff::Profile::Linear}})
                    .ok());
    const NetGeometry after = *session.net(1, {});
    const Point& middle = before.position[point];
    for (std::size_t v = 0; v < before.position.size(); ++v) {
        const Point& p = before.position[v];
        const double d = std::abs(p[0] - middle[0]) + std::abs(p[1] - middle[1]);
        EXPECT_NEAR(after.position[v][2] - p[2], std::max(0.0, 1 - d / 3), 1e-6);  // floats
    }
}

/// Where vertices of the file are in an order of its own, commands and surfaces have its numbers.
TEST(MeshSession, NumbersAreTheFilesOwn) {
    const PolygonMesh plain = subdivided(test::grid(6, 5, true, true), MeshScheme::Loop, 2, 0.01);
    test::Shape shape;
    for (const auto& v : plain.vertices) shape.points.push_back(v);
    for (std::int64_t f = 0; f < plain.polygon_count(); ++f)
        shape.faces.add(std::vector<Index>(plain.polygon(f).begin(), plain.polygon(f).end()));
    const test::Shape mixed = test::shuffled(shape, 3);
    PolygonMesh mesh;
    mesh.vertices = mixed.points;
    mesh.offsets = mixed.faces.offsets;
    mesh.corners.assign(mixed.faces.corners.begin(), mixed.faces.corners.end());
    MeshAttribute uv{"uv", 2, SampleType::Float64, {}, {}};
    for (const auto& p : mesh.vertices) uv.values.insert(uv.values.end(), {p[0], p[1]});
    mesh.attributes = {uv};

    Session session = opened(encoded(mesh, {.scheme = MeshScheme::Loop}));
    ASSERT_GE(session.description().levels.size(), 3U);
    const SurfaceGeometry before = surface(session);
    EXPECT_LT(largest_difference(session, before, mesh), allowed(session));
    ASSERT_EQ(before.uv.size(), mesh.vertices.size());
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
        EXPECT_EQ(before.uv[v][1], static_cast<float>(mesh.vertices[v][1]));
    ASSERT_TRUE(session.apply(move_of(0, {40}, {0.5, 0, 0})).ok());
    PolygonMesh expected = mesh;
    expected.vertices[40][0] += 0.5;
    EXPECT_LT(largest_difference(session, surface(session), expected), allowed(session));
    // Faces of the drawing are those of the mesh.
    std::set<std::array<std::int32_t, 3>> faces;
    const auto add = [&](auto a, auto b, auto c) {
        std::array<std::int32_t, 3> f{static_cast<std::int32_t>(a), static_cast<std::int32_t>(b),
                                      static_cast<std::int32_t>(c)};
        std::rotate(f.begin(), std::min_element(f.begin(), f.end()), f.end());
        return faces.insert(f).second;
    };
    for (std::size_t k = 0; k < mesh.corners.size(); k += 3)
        EXPECT_TRUE(add(mesh.corners[k], mesh.corners[k + 1], mesh.corners[k + 2]));
    for (std::size_t k = 0; k < before.index.size(); k += 3)
        EXPECT_FALSE(add(before.index[k], before.index[k + 1], before.index[k + 2]));
    EXPECT_EQ(before.line.size(), 2 * mesh.corners.size() / 2);
    // At coarser levels vertices have the places of those that they became.
    ASSERT_TRUE(session.set_view({.level = 1}).ok());
    const SurfaceGeometry coarse = surface(session);
    for (const auto& p : coarse.uv)
        EXPECT_TRUE(std::any_of(mesh.vertices.begin(), mesh.vertices.end(), [&](const auto& v) {
            return static_cast<float>(v[0]) == p[0] && static_cast<float>(v[1]) == p[1];
        }));
}

/// Of a sphere: outwards, and the inverse of the radius. A third of the area is not what the
/// formula wants at the twelve vertices of five edges: there it is off by a seventh.
TEST(MeshSession, NormalsAndCurvatureAreThoseOfTheSphere) {
    PolygonMesh mesh = subdivided(test::icosahedron(), MeshScheme::Loop, 4, 0);
    for (auto& v : mesh.vertices) {
        const double size = std::hypot(v[0], v[1], v[2]) / 2;
        for (double& x : v) x /= size;
    }
    Session session = opened(encoded(mesh, {}));
    ASSERT_TRUE(session.set_view({.extras = {.error = true, .curvature = true}}).ok());
    ASSERT_TRUE(session.apply(move_of(0, {100}, {0, 0, 0})).ok());
    const SurfaceGeometry s = surface(session);
    double mean = 0;
    for (std::size_t v = 0; v < s.position.size(); ++v) {
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_NEAR(s.normal[v][k] / 32767.0, s.position[v][k] / 2, 0.01);
        EXPECT_NEAR(s.curvature[v], -0.5, 0.075);
        EXPECT_EQ(s.error[v], 0);
        mean += s.curvature[v] / static_cast<double>(s.position.size());
    }
    EXPECT_NEAR(mean, -0.5, 0.002);
}

TEST(MeshSession, ErrorsAndMeasurementsAreAgainstTheOriginal) {
    test::Shape flat = test::grid(8, 8, true);
    for (auto& p : flat.points) p[2] = 0;
    const PolygonMesh mesh = subdivided(flat, MeshScheme::Loop, 2, 0);
    Session session = opened(encoded(mesh, {}));
    ASSERT_TRUE(session.set_view({.extras = {.error = true}}).ok());
    ASSERT_TRUE(session.apply(move_of(0, {40}, {0, 0, -0.25})).ok());
    const SurfaceGeometry s = surface(session);
    for (std::size_t v = 0; v < s.error.size(); ++v) EXPECT_EQ(s.error[v], v == 40 ? -0.25F : 0.0F);
    const Measurement m = *session.measure();
    EXPECT_DOUBLE_EQ(m.max_error, 0.25);
    EXPECT_DOUBLE_EQ(m.rms_error, 0.25 / std::sqrt(static_cast<double>(mesh.vertices.size())));
    EXPECT_EQ(static_cast<float>(m.place.x), s.position[40][0]);
    ASSERT_TRUE(session.set_view({.show = View::Show::Original}).ok());
    EXPECT_LT(largest_difference(session, surface(session), mesh), allowed(session));
    EXPECT_EQ(session.measure()->max_error, 0);
    // What is not shown is not sent.
    const auto change = session.apply(move_of(0, {41}, {0, 0, 1}));
    ASSERT_TRUE(change.ok());
    EXPECT_EQ(change->touched, 1U);
    EXPECT_TRUE(change->surface.at.empty());
}

TEST(MeshSession, CompressionIsShownWithItsBound) {
    const MeshCase mesh = wide_meshes()[0];
    Session session = opened(encoded(mesh, kLossless));
    ASSERT_TRUE(session.apply(move_of(2, {100}, {0, 0, 0.4})).ok());
    const auto report = session.compress(0.01, {});
    ASSERT_TRUE(report.ok()) << report.error().text();
    EXPECT_LE(report->max_error, 0.01);
    EXPECT_LT(report->bytes, session.description().bytes);
    const PolygonMesh edited = decoded(session);
    ASSERT_TRUE(session.set_view({.show = View::Show::Compressed}).ok());
    const double most = largest_difference(session, surface(session), edited);
    EXPECT_GT(most, 0.0);
    EXPECT_LE(most, 0.01 + allowed(session));
    EXPECT_GT(session.measure()->max_error, 0.1);
    ASSERT_TRUE(session.set_view({.level = 1, .show = View::Show::Compressed}).ok());
    EXPECT_EQ(surface(session).position.size(), session.description().levels[1].control_points);
}

TEST(MeshSession, NetFollowsMovesOfCoarserLevels) {
    const MeshCase mesh = wide_meshes()[3];
    Session session = opened(encoded(mesh, kClose));
    const auto net = [&] { return *session.net(1, {}); };
    const NetGeometry first = net();
    EXPECT_EQ(first.point.size(), session.description().levels[1].control_points);
    ASSERT_TRUE(session.apply(move_of(1, {100, 200}, {0, 0, 0.2})).ok());
    for (std::size_t v = 0; v < first.position.size(); ++v)
        EXPECT_NEAR(net().position[v][2] - first.position[v][2], v == 100 || v == 200 ? 0.2 : 0.0,
                    1e-5);  // floats below 32
    NetGeometry before = net();
    ASSERT_TRUE(session.apply(move_of(2, {100}, {0, 0, 0.2})).ok());
    EXPECT_NE(net().position, before.position);
    before = net();
    ASSERT_TRUE(session.apply(move_of(0, {100}, {0, 0, 0.2})).ok());
    EXPECT_EQ(net().position, before.position);
    ASSERT_TRUE(session.undo(3).ok());
    EXPECT_EQ(net().position, first.position);
}

TEST(MeshSession, RefusesWhatItCanNotDo) {
    const Bytes file = encoded(subdivided(test::icosahedron(), MeshScheme::Loop, 2, 0.01), {});
    Session session = opened(file);
    const auto refused = [&](const char* command, const char* reason) {
        const auto change = session.run(Json::parse(command));
        ASSERT_FALSE(change.ok()) << command;
        EXPECT_NE(change.error().message.find(reason), std::string::npos) << change.error().message;
    };
    refused(R"({"do": "move", "level": 2, "points": [999999], "delta": 1})", "999999");
    refused(R"({"do": "move", "level": 40, "points": [1], "delta": 1})", "no level 40");
    refused(R"({"do": "move", "level": 1, "points": [1, 1], "delta": 1})", "twice");
    refused(R"({"do": "move", "level": 1, "points": [1], "delta": [1e151, 0, 0]})", "1e150");
    refused(R"({"do": "drag", "of": "move", "level": 1, "points": [12345], "delta": 1})", "12345");
    refused(R"({"do": "tilt", "level": 1, "points": [1], "slope": [1, 0]})", "no slope");
    refused(R"({"do": "goto", "done": 4})", "0 commands");
    EXPECT_TRUE(session.history().entries.empty());
    EXPECT_EQ(*session.file(), file);
    EXPECT_FALSE(session.tile({0, 0, 0}).ok());
    EXPECT_FALSE(session.net(0, LatticeBox{0, 0, 1, 1}).ok());
    EXPECT_FALSE(session.at({0, 0})->has_value());
    // The largest move is far beyond what is of use, and leaves nothing behind.
    const SurfaceGeometry before = surface(session);
    ASSERT_TRUE(session.apply(move_of(2, {3}, {1e150, 0, 0})).ok());
    ASSERT_TRUE(session.undo().ok());
    expect_same(before, surface(session), "undone");
}

}  // namespace
}  // namespace relief::edit
