#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "edit/plane_testing.h"
#include "mesh/triangle_meshes.h"
#include "relief/codec/ps_codec.h"
#include "relief/multires/ps_surface.h"

namespace relief::edit {
namespace {

using mesh::Index;
using mesh::Triangulation;
using namespace test;
namespace ps = multires::ps;

spline::TangentPlane height(Vec2 p) {
    return {3 * std::sin(0.7 * p.x) * std::cos(0.5 * p.y),
            {2.1 * std::cos(0.7 * p.x) * std::cos(0.5 * p.y),
             -1.5 * std::sin(0.7 * p.x) * std::sin(0.5 * p.y)}};
}

/// A shaken grid far from the origin, without some of its triangles.
Triangulation grid(Index cols, Index rows, const std::vector<Index>& holes = {}) {
    relief::test::TriangleMesh mesh =
        relief::test::triangle_grid(cols, rows, 0.15, {1000, 5000}, 3);
    for (auto hole = holes.rbegin(); hole != holes.rend(); ++hole)
        mesh.triangles.erase(mesh.triangles.begin() + *hole);
    return *mesh::build(mesh.vertices, mesh.triangles);
}

Bytes encoded(const codec::PsModel& model, codec::Goal goal = {codec::Goal::Kind::Lossless, 0}) {
    auto result = codec::encode_ps(model, {.goal = goal});
    EXPECT_TRUE(result.ok()) << result.error().text();
    return std::move(result->bytes);
}

/// `height` on a refined base; with three components the surface (x, y, height) turned a little.
codec::PsModel splines(const Triangulation& base, int levels, int components = 1) {
    const auto hierarchy = *ps::Hierarchy::create(*ps::make_space(base), levels);
    const ps::Space& space = hierarchy.space(levels);
    codec::PsSplines surface{levels, std::vector<ps::Coefficients>(components)};
    for (Index v = 0; v < space.mesh.vertex_count(); ++v) {
        const Vec2 p = space.mesh.origin + space.mesh.vertex(v);
        const spline::TangentPlane z = height(p);
        const std::array<spline::TangentPlane, 3> planes = {
            components == 1 ? z
                            : spline::TangentPlane{p.x + 0.2 * z.value,
                                                   {1 + 0.2 * z.gradient.x, 0.2 * z.gradient.y}},
            spline::TangentPlane{p.y, {0, 1}}, z};
        for (std::size_t c = 0; c < surface.components.size(); ++c)
            surface.components[c].push_back(ps::heights(space.control[v], planes[c]));
    }
    return {base, std::move(surface), {}};
}

codec::PsModel values(const Triangulation& base) {
    std::vector<double> z;
    for (Index v = 0; v < base.vertex_count(); ++v)
        z.push_back(height(base.origin + base.vertex(v)).value);
    return {base, codec::PsValues{{z}}, {}};
}

/// The largest difference between what the session says and what its file decodes to, at the
/// points of the drawn surface.
double off_the_file(const Session& session, const SurfaceGeometry& drawn) {
    const auto file = codec::PsFile::open(*session.file());
    const auto decoded = *file->surface(session.view().level);
    const auto evaluated = *ps::Surface::create(decoded.space, decoded.components);
    const mesh::TriangleLocator locator(decoded.space.mesh);
    const Vec3<double> origin = session.description().origin;
    double most = 0;
    for (std::size_t k = 0; k < drawn.position.size(); k += 61) {
        const Vec2 page{drawn.position[k][0], drawn.position[k][1]};
        const std::array<Vec2, 1> point = {Vec2{origin.x, origin.y} + page};
        const auto probe = *session.at(page);
        if (!probe) continue;  // floats of the border lie beside it
        std::array<spline::PlaneJet, 1> jet;
        EXPECT_TRUE(evaluate(evaluated, locator, point, jet, ps::Outside::Nearest).ok());
        EXPECT_EQ(probe->place, point[0]);
        most = std::max({most, std::abs(probe->value - jet[0].value),
                         std::abs(probe->gradient.x - jet[0].gradient.x),
                         std::abs(probe->gradient.y - jet[0].gradient.y)});
    }
    return most;
}

// Values are below 12 and gradients below 60; roundings of refinements are some hundred times 2^-53
// of them.
constexpr double kTolerance = 1e-12 * 60;

/// The same of surfaces in space, at the vertices: their coefficients.
double corners_off_the_file(const Session& session, int level) {
    const auto decoded = *codec::PsFile::open(*session.file())->surface(level);
    const Vec3<double> origin = session.description().origin;
    const NetGeometry points = net(session, level);
    double most = 0;
    for (std::size_t v = 0; v < points.corner.size(); ++v)
        for (std::size_t j = 0; j < 3; ++j) {
            const Point& corner = points.corner[v][j];
            const auto at = [&](std::size_t c) { return decoded.components[c][v][j]; };
            most = std::max({most, std::abs(corner[0] + origin.x - at(0)),
                             std::abs(corner[1] + origin.y - at(1)),
                             std::abs(corner[2] + origin.z - at(2))});
        }
    return most;
}

TEST(TriangleSession, DrawsTheSplineOfTheFile) {
    const Triangulation base = grid(4, 3);
    const Session session = opened(encoded(splines(base, 1)));
    const Description& d = session.description();
    EXPECT_EQ(d.kind, Kind::Triangles);
    EXPECT_EQ(d.scheme, "powell-sabin");
    EXPECT_FALSE(d.parametric);
    ASSERT_EQ(d.levels.size(), 2U);
    EXPECT_EQ(d.levels[1].faces, 24U);
    EXPECT_EQ(d.levels[0].faces, 9 * 24U);
    EXPECT_EQ(d.levels[1].control_points, 20U);
    const SurfaceGeometry drawn = surface(session);
    expect_sound(drawn);
    EXPECT_EQ(drawn.index.size(), 3U * 9 * 24 * 32 * 32);
    // Edges of a disk with 9 x 24 triangles and 3 x 14 edges around.
    EXPECT_EQ(drawn.line.size(), 2U * 32 * (3 * 9 * 24 + 3 * 14) / 2);
    expect_as_told(session, drawn);
}

TEST(TriangleSession, PatchesKeepTheSurfaceCurrent) {
    for (const auto& [extras, level] : {std::pair(false, 0), {true, 0}, {true, 1}}) {
        Session session = opened(encoded(splines(grid(4, 4, {9}), 2)));
        ASSERT_TRUE(
            session.set_view({.level = level, .extras = {.error = extras, .curvature = extras}})
                .ok());
        Page page(session);
        const SurfaceGeometry before = page.shown;
        run_history(session, 200, 13, [&](const Change& change) {
            page.take(change.surface);
            page.expect_current(session);
            EXPECT_LT(off_the_file(session, page.shown), kTolerance);
        });
        EXPECT_EQ(page.differing(before), 0U);
        EXPECT_TRUE(page.shown.error == before.error);
        EXPECT_TRUE(page.shown.curvature == before.curvature);
    }
}

TEST(TriangleSession, TiltsChangeTheGradientAlone) {
    Session session = opened(encoded(splines(grid(5, 5), 1)));
    const NetGeometry before = net(session, 1);
    const Vec2 page{before.position[14][0], before.position[14][1]};
    const Probe flat = **session.at(page);
    const auto change = session.apply({.level = 1, .points = {14}, .slope = {0.5, -2}});
    ASSERT_TRUE(change.ok()) << change.error().text();
    const Probe tilted = **session.at(page);
    EXPECT_NEAR(tilted.value, flat.value, 1e-6);  // floats of the place
    EXPECT_NEAR(tilted.gradient.x - flat.gradient.x, 0.5, 1e-6);
    EXPECT_NEAR(tilted.gradient.y - flat.gradient.y, -2, 1e-6);
    EXPECT_LT(off_the_file(session, surface(session)), kTolerance);
    const auto moves = codec::PsFile::open(*session.file())->moves();
    EXPECT_EQ(moves, (std::vector<codec::PsMove>{{1, 14, 0, 0, {0.5, -2}}}));
    EXPECT_EQ(session.history().entries[0].text, "tilt 1 point of level 1");
}

TEST(TriangleSession, PatchesAreAsLargeAsTheMove) {
    const Triangulation base = grid(40, 40);
    Session session = opened(encoded(values(base)));
    Page page(session);
    const SurfaceGeometry before = page.shown;
    const NetGeometry points = net(session, 0);
    const Index middle = 20 * 41 + 20;
    const auto change = session.apply({.level = 0, .points = {middle}, .delta = {0, 0, 1}});
    ASSERT_TRUE(change.ok());
    page.take(change->surface);
    page.expect_current(session);
    // The triangles at the vertex, whose outer border stays: 9 cuts, 28 points inside each
    // and 8 on each edge.
    const std::size_t star = mesh::vertex_triangles(base).of(middle).size();
    EXPECT_EQ(change->touched, 1U);
    EXPECT_EQ(change->surface.at.size(), 1 + star * (8 * 7 / 2 + 8));
    EXPECT_GT(page.differing(before), change->surface.at.size() * 9 / 10);
    // Of the net one control triangle.
    const NetGeometry moved = net(session, 0);
    for (std::size_t k = 0; k < points.corner.size(); ++k) {
        EXPECT_EQ(moved.position[k] == points.position[k], k != middle) << k;
        EXPECT_EQ(moved.corner[k] == points.corner[k], k != middle) << k;
    }
}

TEST(TriangleSession, LevelsLeaveOutWhatIsFiner) {
    Session session = opened(encoded(splines(grid(3, 3), 2)));
    ASSERT_TRUE(session.set_view({.level = 2}).ok());
    const SurfaceGeometry before = surface(session);
    const auto fine = session.apply({.level = 1, .points = {30}, .delta = {0, 0, 5}});
    ASSERT_TRUE(fine.ok());
    EXPECT_GT(fine->touched, 0U);
    EXPECT_TRUE(fine->surface.at.empty());
    EXPECT_TRUE(surface(session).position == before.position);
    ASSERT_TRUE(session.apply({.level = 2, .points = {5}, .delta = {0, 0, 5}}).ok());
    EXPECT_NEAR(surface(session).position[5][2] - before.position[5][2], 5, 2e-6);
    for (const int level : {0, 1, 2}) {
        ASSERT_TRUE(session.set_view({.level = level}).ok());
        EXPECT_LT(off_the_file(session, surface(session)), kTolerance) << level;
    }
}

TEST(TriangleSession, NetsHaveControlTriangles) {
    const Triangulation base = grid(3, 3);
    const codec::PsModel model = splines(base, 0);
    Session session = opened(encoded(model));
    const Vec3<double> origin = session.description().origin;
    const ps::Space space = *ps::make_space(base);
    const NetGeometry points = net(session, 0);
    ASSERT_EQ(points.corner.size(), base.vertex_count());
    EXPECT_EQ(points.line.size(), 2 * base.edges.size());
    const auto& heights = std::get<codec::PsSplines>(model.surface).components[0];
    for (Index v = 0; v < base.vertex_count(); ++v)
        for (std::size_t j = 0; j < 3; ++j) {
            const Vec2 place = base.vertex(v) + space.control[v][j];
            EXPECT_NEAR(points.corner[v][j][0], place.x, 1e-6);
            EXPECT_NEAR(points.corner[v][j][1], place.y, 1e-6);
            EXPECT_NEAR(points.corner[v][j][2] + origin.z, heights[v][j], 2e-6);
        }
}

TEST(TriangleSession, FalloffMovesNeighboursByTheirDistance) {
    const Triangulation base = grid(10, 10);
    Session session = opened(encoded(values(base)));
    const Index middle = 5 * 11 + 5;
    ASSERT_TRUE(session
                    .apply({.level = 0,
                            .points = {middle},
                            .delta = {0, 0, 8},
                            .falloff = {.radius = 3, .profile = Falloff::Profile::Linear}})
                    .ok());
    std::vector<double> moved(base.vertex_count());
    const auto file = codec::PsFile::open(*session.file());
    for (const auto& move : file->moves()) moved[move.vertex] += move.rise;
    for (Index v = 0; v < base.vertex_count(); ++v) {
        const double d = length(base.vertex(v) - base.vertex(middle));
        EXPECT_DOUBLE_EQ(moved[v], 8 * std::max(0.0, 1 - d / 3));
    }
    EXPECT_LT(off_the_file(session, surface(session)), kTolerance);
}

TEST(TriangleSession, SurfacesInSpaceMoveInSpace) {
    const Triangulation base = grid(4, 4);
    Session session = opened(encoded(splines(base, 1, 3)));
    EXPECT_TRUE(session.description().parametric);
    EXPECT_FALSE(session.at({0, 0})->has_value());
    ASSERT_TRUE(session.set_view({.extras = {.error = true, .curvature = true}}).ok());
    Page page(session);
    const SurfaceGeometry before = page.shown;
    // Its normals are those of a function over another plane: x' = x + 0.2 z.
    for (Index v = 0; v < base.vertex_count(); ++v) {
        const Vec2 slope = height(base.origin + base.vertex(v)).gradient;
        const double along = 1 + 0.2 * slope.x;
        const double dx = slope.x / along, dy = slope.y - 0.2 * slope.y * slope.x / along;
        const double size = std::sqrt(1 + dx * dx + dy * dy);
        EXPECT_NEAR(before.normal[v][0] / 32767.0, -dx / size, 4e-5);
        EXPECT_NEAR(before.normal[v][1] / 32767.0, -dy / size, 4e-5);
    }
    const auto change = session.apply({.level = 1, .points = {12}, .delta = {1, 2, 3}});
    ASSERT_TRUE(change.ok()) << change.error().text();
    page.take(change->surface);
    page.expect_current(session);
    for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(page.shown.position[12][c] - before.position[12][c], 1.0 + double(c), 2e-6);
    EXPECT_FLOAT_EQ(std::abs(page.shown.error[12]), std::sqrt(14.0F));
    // Numbers are below 6000, floats of the page below 8.
    EXPECT_LT(corners_off_the_file(session, 0), 2e-6);
    EXPECT_NEAR(session.measure()->max_error, std::sqrt(14.0), 1e-9);
    const auto moves = codec::PsFile::open(*session.file())->moves();
    EXPECT_EQ(moves, (std::vector<codec::PsMove>{
                         {1, 12, 0, 1, {}}, {1, 12, 1, 2, {}}, {1, 12, 2, 3, {}}}));
    expect_refused(session, R"({"do": "tilt", "level": 0, "points": [1], "slope": [1, 0]})",
                   "no slope");
    ASSERT_TRUE(session.undo().ok());
    EXPECT_TRUE(surface(session).position == before.position);
}

TEST(TriangleSession, DistancesInSpaceAreThoseAlongEdges) {
    const Triangulation base = grid(6, 1);
    Session session = opened(encoded(splines(base, 0, 3)));
    const NetGeometry points = net(session, 0);
    const auto far = [&](std::uint32_t a, std::uint32_t b) {
        const Point& p = points.position[a];
        const Point& q = points.position[b];
        return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
    };
    const double radius = far(0, 1) + far(1, 2) + 0.01;
    ASSERT_TRUE(session
                    .apply({.level = 0,
                            .points = {0},
                            .delta = {0, 0, 1},
                            .falloff = {.radius = radius, .profile = Falloff::Profile::Linear}})
                    .ok());
    const auto file = codec::PsFile::open(*session.file());
    for (const auto& move : file->moves()) {
        if (move.component != 2 || move.vertex > 2) continue;
        const double d = move.vertex == 0 ? 0 : far(0, 1) + (move.vertex == 2 ? far(1, 2) : 0);
        EXPECT_NEAR(move.rise, 1 - d / radius, 1e-6);  // floats
    }
}

TEST(TriangleSession, ErrorsAreAgainstTheOriginalOfTheFinestLevel) {
    Session session = opened(encoded(splines(grid(3, 3), 1)));
    expect_errors_of_coarse_level(session, 1);
    ASSERT_TRUE(session.apply({.level = 0, .points = {5}, .delta = {0, 0, -4}}).ok());
    const SurfaceGeometry drawn = surface(session);
    EXPECT_FLOAT_EQ(drawn.error[5], -4);
    EXPECT_EQ(drawn.error[0], 0);
    EXPECT_NEAR(session.measure()->max_error, 4, kTolerance);
    EXPECT_NEAR(session.measure()->place.x, drawn.position[5][0], 1e-6);
}

TEST(TriangleSession, ScriptsReplayToTheSameBytesOnEditedFiles) {
    const Bytes file = *codec::add_ps_moves(encoded(splines(grid(3, 3), 2)),
                                            {{0, 9, 0, 0.5, {}}, {2, 3, 0, -1, {1, 2}}});
    Session session = opened(file);
    Session again = opened(file);
    expect_replayed(
        session, again,
        {R"({"do": "move", "level": 2, "points": [4, 5], "delta": 4})",
         R"({"do": "drag", "of": "tilt", "level": 1, "points": [3], "slope": [1, 9]})",
         R"({"do": "tilt", "level": 1, "points": [20], "slope": [0.25, 0.3],
             "falloff": {"radius": 0.7, "profile": "sharp"}})",
         R"({"do": "move", "level": 0, "points": [7], "delta": 1e-3})", R"({"do": "undo"})"});
    EXPECT_LT(off_the_file(session, surface(session)), kTolerance);
    const auto moves = codec::PsFile::open(*again.file())->moves();
    ASSERT_GT(moves.size(), 4U);
    EXPECT_EQ(moves[2], (codec::PsMove{2, 4, 0, 4, {}}));
}

TEST(TriangleSession, OfTwoComponentsTheFirstIsEdited) {
    codec::PsModel model = splines(grid(3, 3), 1);
    auto& both = std::get<codec::PsSplines>(model.surface).components;
    both.push_back(both[0]);
    Session session = opened(encoded(model));
    EXPECT_EQ(session.description().components, 2);
    ASSERT_TRUE(session.apply({.level = 1, .points = {5}, .delta = {0, 0, 2}}).ok());
    const auto decoded = *codec::PsFile::open(*session.file())->surface(0);
    EXPECT_NE(decoded.components[0], both[0]);
    EXPECT_EQ(decoded.components[1], both[1]);
    const auto report = session.compress(0.1, {});
    ASSERT_TRUE(report.ok()) << report.error().text();
    ASSERT_TRUE(session.set_view({.show = View::Show::Compressed}).ok());
    EXPECT_LE(session.measure()->max_error, 2.2);
}

TEST(TriangleSession, CompressionIsShownWithItsBound) {
    Session session = opened(encoded(splines(grid(5, 5), 2)));
    ASSERT_TRUE(session.apply({.level = 2, .points = {14}, .delta = {0, 0, 3}}).ok());
    expect_compressed(session, surface(session).position.size(), 0.01);
}

TEST(TriangleSession, RefusesWhatItCanNotDo) {
    const Bytes file = encoded(values(grid(4, 4)));
    Session session = opened(file);
    expect_refused(session, R"({"do": "move", "level": 1, "points": [1], "delta": 1})",
                   "no level 1");
    expect_refused(session, R"({"do": "move", "level": 0, "points": [25], "delta": 1})", "25");
    expect_refused(session, R"({"do": "move", "level": 0, "points": [1], "delta": [1, 0, 0]})",
                   "up and down");
    expect_refused(session, R"({"do": "tilt", "level": 0, "points": [1], "slope": [0, 1e101]})",
                   "1e100");
    EXPECT_EQ(*session.file(), file);
    EXPECT_FALSE(session.tile({0, 0, 0}).ok());
    EXPECT_FALSE(session.net(0, LatticeBox{0, 0, 2, 2}).ok());
    EXPECT_FALSE(session.at({-50, 0})->has_value());
}

}  // namespace
}  // namespace relief::edit
