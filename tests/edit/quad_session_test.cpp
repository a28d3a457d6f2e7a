#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>

#include "edit/plane_testing.h"
#include "relief/codec/quad_codec.h"

namespace relief::edit {
namespace {

using mesh::Index;
using namespace test;
namespace fvs_mesh = multires::fvs_mesh;

double height(Vec2 p) {
    return 3 * std::sin(0.7 * p.x) * std::cos(0.5 * p.y) + 0.3 * p.x;
}

/// cols x rows quads with shaken corners, without some of them, refined; far from the origin.
codec::QuadMesh grid(Index cols, Index rows, int levels, const std::vector<Index>& holes = {}) {
    std::vector<Vec2> places;
    std::vector<std::array<Index, 4>> quads;
    for (Index r = 0; r <= rows; ++r)
        for (Index c = 0; c <= cols; ++c) {
            const bool inside = r > 0 && r < rows && c > 0 && c < cols;
            const double shift = inside ? 0.1 * ((r * 7 + c * 3) % 4) - 0.15 : 0;
            places.push_back({1000 + c + shift, 5000 + r - shift});
            const Index v = r * (cols + 1) + c;
            if (r < rows && c < cols) quads.push_back({v, v + 1, v + cols + 2, v + cols + 1});
        }
    for (auto hole = holes.rbegin(); hole != holes.rend(); ++hole)
        quads.erase(quads.begin() + *hole);
    auto plane = *mesh::build(places, quads);
    for (int m = 0; m < levels; ++m) plane = *mesh::refine(plane);
    codec::QuadMesh mesh{{}, plane.quads};
    for (Index v = 0; v < plane.vertex_count(); ++v) {
        const Vec2 p = plane.origin + plane.vertex(v);
        mesh.vertices.push_back({p.x, p.y, height(p)});
    }
    return mesh;
}

codec::QuadMesh shuffled(const codec::QuadMesh& mesh) {
    std::mt19937 engine(5);
    std::vector<Index> number(mesh.vertices.size());
    std::iota(number.begin(), number.end(), 0U);
    std::shuffle(number.begin(), number.end(), engine);
    codec::QuadMesh out = mesh;
    for (std::size_t v = 0; v < number.size(); ++v) out.vertices[number[v]] = mesh.vertices[v];
    for (auto& quad : out.quads)
        for (Index& v : quad) v = number[v];
    std::shuffle(out.quads.begin(), out.quads.end(), engine);
    return out;
}

Bytes encoded(const codec::QuadMesh& mesh, codec::Goal goal = {codec::Goal::Kind::Lossless, 0}) {
    auto result = codec::encode_quads(mesh, {.goal = goal});
    EXPECT_TRUE(result.ok()) << result.error().text();
    return std::move(result->bytes);
}

/// The largest difference between what the session says and what its file decodes to, at the
/// points of the drawn surface.
double off_the_file(const Session& session, const SurfaceGeometry& drawn) {
    const auto file = codec::QuadFile::open(*session.file());
    const int level = session.view().level;
    const auto decoded = *file->surface(level);
    const Vec3<double> origin = session.description().origin;
    std::vector<Vec2> pages;
    std::vector<Vec2> points;
    for (std::size_t k = 0; k < drawn.position.size(); k += 61) {
        pages.push_back({drawn.position[k][0], drawn.position[k][1]});
        points.push_back({origin.x + pages.back().x, origin.y + pages.back().y});
    }
    std::vector<spline::PlaneJet> jets(points.size());
    EXPECT_TRUE(evaluate(decoded.hierarchy, decoded.level(), decoded.data, points, jets,
                         fvs_mesh::Outside::Clamp)
                    .ok());
    double most = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const auto probe = *session.at(pages[k]);
        if (!probe) continue;  // floats of the border lie beside it
        EXPECT_EQ(probe->place, points[k]);
        most = std::max({most, std::abs(probe->value - jets[k].value),
                         std::abs(probe->gradient.x - jets[k].gradient.x),
                         std::abs(probe->gradient.y - jets[k].gradient.y)});
    }
    return most;
}

// Values are below 310, and roundings of sums and of the fits 2^-53 of them, some hundred times.
constexpr double kTolerance = 1e-12 * 310;

TEST(QuadSession, DrawsTheSplineOfTheFile) {
    const Session session = opened(encoded(grid(5, 4, 2)));
    const Description& d = session.description();
    EXPECT_EQ(d.kind, Kind::Quads);
    EXPECT_EQ(d.scheme, "fvs");
    EXPECT_EQ(d.components, 1);
    EXPECT_FALSE(d.parametric);
    ASSERT_EQ(d.levels.size(), 3U);
    EXPECT_EQ(d.levels[0].faces, 16 * 20U);
    EXPECT_EQ(d.levels[2].control_points, 30U);
    EXPECT_LT(d.levels[2].bytes, d.levels[0].bytes);
    EXPECT_EQ(d.bound, 0);
    const SurfaceGeometry drawn = surface(session);
    expect_sound(drawn);
    // 300 000 triangles on 320 quads: 21 cuts.
    EXPECT_EQ(drawn.index.size(), 3U * 2 * 320 * 21 * 21);
    // Sides 20 x 17 and 21 x 16 of the grid that 4 x 4 quads of each make.
    EXPECT_EQ(drawn.line.size(), 2U * 21 * (20 * 17 + 21 * 16));
    expect_as_told(session, drawn);
}

TEST(QuadSession, LargeMeshesAreDrawnAsTheyAre) {
    const codec::QuadMesh mesh = grid(390, 385, 0);
    const Session session = opened(encoded(mesh));
    const SurfaceGeometry drawn = surface(session);
    EXPECT_EQ(drawn.position.size(), mesh.vertices.size());
    EXPECT_EQ(drawn.index.size(), 6 * mesh.quads.size());
    const auto net = session.net(0, {});
    ASSERT_FALSE(net.ok());
    EXPECT_NE(net.error().message.find("coarser level"), std::string::npos);
}

TEST(QuadSession, PatchesKeepTheSurfaceCurrent) {
    for (const auto& [extras, level] : {std::pair(false, 0), {true, 0}, {true, 1}}) {
        Session session = opened(encoded(shuffled(grid(5, 4, 2, {7}))));
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

TEST(QuadSession, PatchesAreAsLargeAsTheMove) {
    Session session = opened(encoded(grid(40, 40, 0)));
    Page page(session);
    const SurfaceGeometry before = page.shown;
    const auto change = session.apply({.level = 0, .points = {20 * 41 + 20}, .delta = {0, 0, 1}});
    ASSERT_TRUE(change.ok());
    page.take(change->surface);
    page.expect_current(session);
    // Gradients change at the 3 x 3 vertices around, and with them the 4 x 4 quads of these, whose
    // border stays: 9 cuts, less the points that floats and 15 bits do not tell apart.
    EXPECT_EQ(change->touched, 9U);
    const std::size_t inside = (4 * 9 - 1) * (4 * 9 - 1);
    EXPECT_EQ(change->surface.at.size(), inside);
    EXPECT_GT(page.differing(before), inside * 9 / 10);
}

TEST(QuadSession, LevelsLeaveOutWhatIsFiner) {
    Session session = opened(encoded(grid(4, 4, 2)));
    ASSERT_TRUE(session.set_view({.level = 2}).ok());
    const SurfaceGeometry before = surface(session);
    const auto fine = session.apply({.level = 1, .points = {30}, .delta = {0, 0, 5}});
    ASSERT_TRUE(fine.ok());
    EXPECT_GT(fine->touched, 0U);
    EXPECT_TRUE(fine->surface.at.empty());
    EXPECT_TRUE(surface(session).position == before.position);
    ASSERT_TRUE(session.apply({.level = 2, .points = {12}, .delta = {0, 0, 5}}).ok());
    EXPECT_NEAR(surface(session).position[12][2] - before.position[12][2], 5, 2e-6);
    for (const int level : {0, 1, 2}) {
        ASSERT_TRUE(session.set_view({.level = level}).ok());
        EXPECT_LT(off_the_file(session, surface(session)), kTolerance) << level;
    }
}

TEST(QuadSession, PointsAreCalledAsTheFileCallsThem) {
    const codec::QuadMesh mesh = shuffled(grid(3, 3, 1));
    Session session = opened(encoded(mesh));
    const Vec3<double> origin = session.description().origin;
    const NetGeometry points = net(session, 0);
    ASSERT_EQ(points.position.size(), mesh.vertices.size());
    for (std::size_t k = 0; k < mesh.vertices.size(); ++k) {
        EXPECT_EQ(points.point[k], k);
        EXPECT_NEAR(points.position[k][0] + origin.x, mesh.vertices[k][0], 1e-6);
        EXPECT_NEAR(points.position[k][1] + origin.y, mesh.vertices[k][1], 1e-6);
        EXPECT_NEAR(points.position[k][2] + origin.z, mesh.vertices[k][2], 1e-6);
    }
    for (std::size_t k = 0; k < points.line.size(); k += 2) {
        const auto& a = mesh.vertices[points.line[k]];
        const auto& b = mesh.vertices[points.line[k + 1]];
        EXPECT_LT(std::hypot(a[0] - b[0], a[1] - b[1]), 0.8);  // halves of sides of 1 +- 0.3
    }
    EXPECT_TRUE(points.corner.empty());
    ASSERT_TRUE(session.apply({.level = 0, .points = {11}, .delta = {0, 0, 2}}).ok());
    const codec::QuadMesh after = *codec::QuadFile::open(*session.file())->decode(0);
    for (std::size_t k = 0; k < mesh.vertices.size(); ++k)
        EXPECT_NEAR(after.vertices[k][2] - mesh.vertices[k][2], k == 11 ? 2 : 0, kTolerance);
}

TEST(QuadSession, FalloffMovesNeighboursByTheirDistance) {
    const codec::QuadMesh mesh = grid(12, 12, 0);
    Session session = opened(encoded(mesh));
    const std::size_t middle = 6 * 13 + 6;
    ASSERT_TRUE(session
                    .apply({.level = 0,
                            .points = {middle},
                            .delta = {0, 0, 8},
                            .falloff = {.radius = 3, .profile = Falloff::Profile::Linear}})
                    .ok());
    const codec::QuadMesh after = *codec::QuadFile::open(*session.file())->decode(0);
    for (std::size_t k = 0; k < mesh.vertices.size(); ++k) {
        const auto& p = mesh.vertices[k];
        const double d =
            std::hypot(p[0] - mesh.vertices[middle][0], p[1] - mesh.vertices[middle][1]);
        EXPECT_NEAR(after.vertices[k][2] - p[2], 8 * std::max(0.0, 1 - d / 3), kTolerance);
    }
}

TEST(QuadSession, ErrorsAreAgainstTheOriginalOfTheFinestLevel) {
    Session session = opened(encoded(grid(4, 4, 1)));
    ASSERT_TRUE(session.set_view({.extras = {.error = true, .curvature = true}}).ok());
    ASSERT_TRUE(session.apply({.level = 0, .points = {12}, .delta = {0, 0, -4}}).ok());
    const SurfaceGeometry drawn = surface(session);
    EXPECT_FLOAT_EQ(drawn.error[12], -4);
    EXPECT_EQ(drawn.error[0], 0);
    EXPECT_EQ(drawn.curvature.size(), drawn.position.size());
    const auto measured = session.measure();
    ASSERT_TRUE(measured.ok());
    const auto most = *std::min_element(drawn.error.begin(), drawn.error.end());
    EXPECT_FLOAT_EQ(static_cast<float>(-measured->max_error), most);
    EXPECT_NEAR(measured->max_error, 4, 0.2);  // derivatives are estimated: it is beside the vertex
    EXPECT_NEAR(measured->place.x, drawn.position[12][0], 0.1);
    EXPECT_LT(measured->rms_error, 1.5);
    EXPECT_GT(measured->rms_error, 0.1);
    ASSERT_TRUE(session.undo().ok());
    expect_errors_of_coarse_level(session, 1);
}

TEST(QuadSession, PlanesHaveTheirNormalAndNoCurvature) {
    codec::QuadMesh mesh = grid(3, 3, 1);
    for (auto& v : mesh.vertices) v[2] = 0.5 * v[0] - 0.25 * v[1];
    Session session = opened(encoded(mesh));
    ASSERT_TRUE(session.set_view({.extras = {.curvature = true}}).ok());
    const SurfaceGeometry drawn = surface(session);
    const double size = std::sqrt(1 + 0.25 + 0.0625);
    for (std::size_t k = 0; k < drawn.position.size(); ++k) {
        ASSERT_NEAR(drawn.normal[k][0] / 32767.0, -0.5 / size, 2e-5);
        ASSERT_NEAR(drawn.normal[k][1] / 32767.0, 0.25 / size, 2e-5);
        ASSERT_NEAR(drawn.curvature[k], 0, 1e-9);  // second differences of 750 + 2^-43
    }
}

TEST(QuadSession, HolesAreNoPartOfTheSurface) {
    const Session session = opened(encoded(grid(4, 4, 1, {5})));
    const Vec3<double> origin = session.description().origin;
    EXPECT_FALSE(session.at({1001.5 - origin.x, 5001.5 - origin.y})->has_value());
    EXPECT_TRUE(session.at({1000.5 - origin.x, 5001.5 - origin.y})->has_value());
    EXPECT_FALSE(session.at({-50, 0})->has_value());
}

TEST(QuadSession, ScriptsReplayToTheSameBytesOnEditedFiles) {
    const Bytes file = *codec::add_quad_moves(encoded(grid(4, 3, 2)), {{0, 9, 0.5}, {2, 3, -1}});
    Session session = opened(file);
    EXPECT_FALSE(session.description().bound);
    Session again = opened(file);
    expect_replayed(
        session, again,
        {R"({"do": "move", "level": 2, "points": [4, 5], "delta": 4})",
         R"({"do": "drag", "of": "move", "level": 1, "points": [3], "delta": 9})",
         R"({"do": "move", "level": 1, "points": [20], "delta": [0, 0, 0.3],
             "falloff": {"radius": 1.5, "profile": "sharp"}})",
         R"({"do": "move", "level": 0, "points": [7], "delta": 1e-3})", R"({"do": "undo"})"});
    EXPECT_LT(off_the_file(session, surface(session)), kTolerance);
    const auto moves = codec::QuadFile::open(*again.file())->moves();
    ASSERT_GT(moves.size(), 4U);
    EXPECT_EQ(moves[0], (codec::QuadMove{0, 9, 0.5}));
    EXPECT_EQ(moves[2], (codec::QuadMove{2, 4, 4}));
}

TEST(QuadSession, FilesOfCoefficientsAreEdited) {
    Session session = opened(encoded(grid(4, 4, 2), {codec::Goal::Kind::Keep, 60}));
    Page page(session);
    run_history(session, 100, 12, [&](const Change& change) {
        page.take(change.surface);
        page.expect_current(session);
        EXPECT_LT(off_the_file(session, page.shown), kTolerance);
    });
}

TEST(QuadSession, CompressionIsShownWithItsBound) {
    Session session = opened(encoded(shuffled(grid(8, 8, 2))));
    ASSERT_TRUE(session.apply({.level = 2, .points = {40}, .delta = {0, 0, 9}}).ok());
    // Vertices are drawn first.
    expect_compressed(session, session.description().levels[0].control_points, 0.05);
    const auto moved = session.apply({.level = 2, .points = {4}, .delta = {0, 0, 9}});
    ASSERT_TRUE(moved.ok());
    EXPECT_TRUE(moved->surface.at.empty());
}

TEST(QuadSession, RefusesWhatItCanNotDo) {
    const Bytes file = encoded(grid(4, 4, 1));
    Session session = opened(file);
    expect_refused(session, R"({"do": "move", "level": 2, "points": [1], "delta": 1})",
                   "no level 2");
    expect_refused(session, R"({"do": "move", "level": 1, "points": [25], "delta": 1})", "25");
    expect_refused(session, R"({"do": "move", "level": 0, "points": [1], "delta": [1, 0, 0]})",
                   "up and down");
    expect_refused(session, R"({"do": "tilt", "level": 0, "points": [1], "slope": [1, 0]})",
                   "no slope");
    expect_refused(session, R"({"do": "move", "level": 0, "points": [1], "delta": 1e101})",
                   "1e100");
    ASSERT_TRUE(session.apply({.level = 0, .points = {1}, .delta = {0, 0, 9e99}}).ok());
    expect_refused(session, R"({"do": "move", "level": 0, "points": [1], "delta": 9e99})", "1e100");
    ASSERT_TRUE(codec::QuadFile::open(*session.file())->surface(0).ok());
    ASSERT_TRUE(session.undo().ok());
    EXPECT_EQ(*session.file(), file);
    EXPECT_FALSE(session.tile({0, 0, 0}).ok());
    EXPECT_FALSE(session.net(0, LatticeBox{0, 0, 2, 2}).ok());
}

}  // namespace
}  // namespace relief::edit
