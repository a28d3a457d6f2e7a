#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "relief/codec/raster_codec.h"
#include "relief/edit/session.h"

namespace relief::edit {
namespace {

using Json = nlohmann::json;

/// Hills, rounded to centimetres so that closed-loop files are exact.
Raster hills(std::int64_t rows, std::int64_t cols, int components = 1) {
    Raster raster;
    raster.rows = rows;
    raster.cols = cols;
    for (int c = 0; c < components; ++c) {
        Grid<double> plane(rows, cols);
        for (std::int64_t i = 0; i < rows; ++i)
            for (std::int64_t j = 0; j < cols; ++j) {
                const double x = static_cast<double>(j), y = static_cast<double>(i);
                const double z = 100 + 20 * std::sin(0.11 * x + c) * std::cos(0.07 * y) + 0.1 * x;
                plane(i, j) = static_cast<float>(std::round(100 * z) / 100);
            }
        raster.planes.push_back(std::move(plane));
    }
    return raster;
}

Bytes encoded(const Raster& raster, const std::optional<multires::SchemeSpec>& spec,
              codec::Goal goal) {
    codec::EncodeOptions options;
    options.spec = spec;
    options.goal = goal;
    auto file = codec::encode_raster(raster, options);
    EXPECT_TRUE(file.ok()) << file.error().text();
    return std::move(file->bytes);
}

Bytes lossless(const Raster& raster) {
    return encoded(raster, {}, {codec::Goal::Kind::Lossless, 0});
}

/// All coefficients of a scheme, to float precision.
Bytes complete(const Raster& raster, multires::SchemeId id, int order) {
    return encoded(raster, multires::SchemeSpec{.id = id, .order = order},
                   {codec::Goal::Kind::Keep, 400});
}

Session opened(Bytes bytes) {
    auto session = Session::open(std::make_shared<MemorySource>(std::move(bytes)));
    EXPECT_TRUE(session.ok()) << session.error().text();
    return *std::move(session);
}

TileGeometry tile(const Session& session, const TileName& name) {
    auto result = session.tile(name);
    EXPECT_TRUE(result.ok()) << result.error().text();
    return *std::move(result);
}

Raster decoded(const Session& session) {
    auto bytes = session.file();
    EXPECT_TRUE(bytes.ok()) << bytes.error().text();
    auto file = codec::RasterFile::open(*std::move(bytes));
    EXPECT_TRUE(file.ok()) << file.error().text();
    return *file->decode(0);
}

/// The largest difference between tiles of full detail and a raster.
double largest_difference(const Session& session, const Raster& raster) {
    const TileInfo& tiles = *session.description().tiles;
    const auto count = [&](std::int64_t samples) { return (samples - 2) / tiles.tile + 1; };
    double most = 0;
    for (std::int64_t r = 0; r < count(tiles.rows); ++r)
        for (std::int64_t c = 0; c < count(tiles.cols); ++c) {
            const TileGeometry t = tile(session, {0, r, c});
            for (std::int64_t i = 0; i < t.rect.rows; ++i)
                for (std::int64_t j = 0; j < t.rect.cols; ++j) {
                    const double z = raster.planes[0](r * tiles.tile + i, c * tiles.tile + j);
                    const auto at = static_cast<std::size_t>(i * t.rect.cols + j);
                    const double shown = t.height[at] + session.description().origin.z;
                    most = std::max(most, std::abs(shown - z));
                }
        }
    return most;
}

// Heights are 32-bit floats of less than 64 in magnitude: 2^-19 each.
constexpr double kFloat = 4e-6;
// Decoded samples are floats below 256: 2^-17 each, and heights.
constexpr double kFloatSamples = 8e-6 + kFloat;

TEST(RasterSession, TilesAreTheDecodedRaster) {
    const Raster raster = hills(200, 150);
    EXPECT_LT(largest_difference(opened(lossless(raster)), raster), kFloat);
    for (const int order : {1, 2}) {
        const Session session = opened(complete(raster, multires::SchemeId::Box, order));
        EXPECT_LT(largest_difference(session, decoded(session)), kFloatSamples) << order;
    }
}

TEST(RasterSession, DescribesLevelsAndTiles) {
    const Session session = opened(complete(hills(200, 150), multires::SchemeId::Box, 2));
    const Description& d = session.description();
    EXPECT_EQ(d.kind, Kind::Raster);
    EXPECT_EQ(d.scheme, "box");
    EXPECT_EQ(d.order, 2);
    ASSERT_TRUE(d.tiles);
    EXPECT_EQ(d.tiles->coarsest, 1);  // 199 cells in two steps: 100 <= 128
    EXPECT_FALSE(d.parametric);
    ASSERT_GT(d.levels.size(), 2U);
    for (std::size_t k = 1; k < d.levels.size(); ++k) {
        EXPECT_LT(d.levels[k].control_points, d.levels[k - 1].control_points);
        EXPECT_LE(d.levels[k].bytes, d.levels[k - 1].bytes);
    }
}

struct SchemeCase {
    const char* name;
    multires::SchemeId id;
    int order;
};
class MovedRaster : public testing::TestWithParam<SchemeCase> {};

TEST_P(MovedRaster, IsWhatTheSavedFileDecodesTo) {
    const SchemeCase& c = GetParam();
    Session session = opened(complete(hills(240, 270), c.id, c.order));
    ASSERT_TRUE(session.apply({.level = 2, .points = {321, 60}, .delta = {0, 0, 5}}).ok());
    ASSERT_TRUE(session.apply({.level = 3, .points = {41, 600}, .delta = {0, 0, -3}}).ok());
    ASSERT_TRUE(session.apply({.level = 0, .points = {5000}, .delta = {0, 0, 1}}).ok());
    EXPECT_LT(largest_difference(session, decoded(session)), kFloatSamples);
}

INSTANTIATE_TEST_SUITE_P(Schemes, MovedRaster,
                         testing::Values(SchemeCase{"linear", multires::SchemeId::Box, 1},
                                         SchemeCase{"quartic", multires::SchemeId::Box, 2},
                                         SchemeCase{"septic", multires::SchemeId::Barycentric, 3},
                                         SchemeCase{"frame", multires::SchemeId::Barycentric, 2},
                                         SchemeCase{"cubic", multires::SchemeId::Cubic, 2},
                                         SchemeCase{"fvs", multires::SchemeId::Fvs, 2}),
                         [](const auto& test) { return std::string(test.param.name); });

/// Puts patches into tiles.
void patch(std::vector<TileGeometry>& tiles, const Change& change) {
    for (const TileGeometry& part : change.tiles) {
        const auto found = std::find_if(tiles.begin(), tiles.end(),
                                        [&](const auto& t) { return t.tile == part.tile; });
        ASSERT_NE(found, tiles.end());
        for (std::int64_t r = 0; r < part.rect.rows; ++r)
            for (std::int64_t c = 0; c < part.rect.cols; ++c) {
                const auto from = static_cast<std::size_t>(r * part.rect.cols + c);
                const auto to = static_cast<std::size_t>((part.rect.row0 + r) * found->rect.cols +
                                                         part.rect.col0 + c);
                found->height[to] = part.height[from];
                found->normal[to] = part.normal[from];
            }
    }
}

std::vector<TileGeometry> held_tiles(Session& session) {
    std::vector<TileGeometry> tiles;
    for (const TileName& name : {TileName{0, 0, 0}, TileName{0, 0, 1}, TileName{0, 1, 0},
                                 TileName{0, 1, 1}, TileName{1, 0, 0}}) {
        tiles.push_back(tile(session, name));
        session.hold(name);
    }
    return tiles;
}

/// Box splines to the bit; bicubic ones, whose tails patches leave out, to some millionths of the
/// moves and the rounding of heights and normals.
void expect_current(const Session& session, const std::vector<TileGeometry>& tiles, bool exactly) {
    for (const TileGeometry& t : tiles) {
        const TileGeometry now = tile(session, t.tile);
        EXPECT_TRUE(!exactly || (now.height == t.height && now.normal == t.normal)) << t.tile.lod;
        for (std::size_t k = 0; k < t.height.size(); ++k) {
            ASSERT_NEAR(now.height[k], t.height[k], 1e-5 + kFloat);
            for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(now.normal[k][c], t.normal[k][c], 2);
        }
    }
}

TEST(RasterSession, PatchesKeepTilesCurrentThroughUndoAndRedo) {
    for (const bool closed_loop : {true, false}) {
        const Raster raster = hills(200, 180);
        Session session =
            opened(closed_loop ? lossless(raster) : complete(raster, multires::SchemeId::Box, 2));
        std::vector<TileGeometry> tiles = held_tiles(session);
        const std::vector<TileGeometry> before = tiles;
        const auto step = [&](Result<Change> change) {
            ASSERT_TRUE(change.ok()) << change.error().text();
            EXPECT_GT(change->touched, 0U);
            patch(tiles, *change);
            expect_current(session, tiles, !closed_loop);
        };
        step(session.apply({.level = 3, .points = {200}, .delta = {0, 0, 7}}));
        step(session.drag({.level = 1, .points = {1000}, .delta = {0, 0, 2}}));
        step(session.drag({.level = 1, .points = {1000}, .delta = {0, 0, 3}}));
        step(session.release());
        step(session.apply(
            {.level = 2, .points = {40, 900}, .delta = {0, 0, 1}, .falloff = {.radius = 20}}));
        step(session.undo());
        step(session.redo());
        step(session.undo(2));
        for (std::size_t k = 0; k < tiles.size(); ++k) {
            EXPECT_TRUE(tiles[k].height == before[k].height);
            EXPECT_TRUE(tiles[k].normal == before[k].normal);
        }
    }
}

TEST(RasterSession, PatchesAreAsLargeAsTheMove) {
    Session session = opened(complete(hills(1000, 1000), multires::SchemeId::Box, 2));
    for (std::int64_t r = 0; r < 8; ++r)
        for (std::int64_t c = 0; c < 8; ++c) session.hold({0, r, c});
    const auto change = session.apply({.level = 3, .points = {64 * 60 + 60}, .delta = {0, 0, 1}});
    ASSERT_TRUE(change.ok());
    std::int64_t samples = 0;
    for (const TileGeometry& part : change->tiles) samples += part.rect.count();
    EXPECT_EQ(change->touched, 31U * 31U);  // |i|, |j| < 2 * 8
    EXPECT_GE(samples, 33 * 33);            // normals reach one further
    EXPECT_LE(samples, 35 * 35);            // borders of tiles are in two of them
}

TEST(RasterSession, ScriptsReplayToTheSameBytes) {
    const Bytes file = lossless(hills(120, 90));
    Session session = opened(file);
    for (const char* command :
         {R"({"do": "move", "level": 2, "points": [30, 31], "delta": 4})",
          R"({"do": "drag", "of": "move", "level": 1, "points": [3], "delta": 9})",
          R"({"do": "move", "level": 1, "points": [200], "delta": [0, 0, 0.3],
              "falloff": {"radius": 9.5, "profile": "linear"}})",
          R"({"do": "move", "level": 0, "points": [7], "delta": 1e-3})", R"({"do": "undo"})",
          R"({"do": "move", "level": 3, "points": [7], "delta": 0.1})",
          R"({"do": "undo", "count": 2})", R"({"do": "redo", "count": 1})"})
        ASSERT_TRUE(session.run(Json::parse(command)).ok()) << command;
    EXPECT_EQ(session.history().done, 2U);
    EXPECT_EQ(session.history().entries.size(), 3U);
    EXPECT_EQ(session.history().entries[0].text, "move 2 points of level 2");

    Session again = opened(file);
    ASSERT_TRUE(again.replay(Json::parse(session.script().dump())).ok());
    EXPECT_EQ(*again.file(), *session.file());
    // Edited files are edited further.
    Session third = opened(*again.file());
    EXPECT_EQ(largest_difference(third, decoded(third)), largest_difference(again, decoded(again)));
    ASSERT_TRUE(third.apply({.level = 2, .points = {30}, .delta = {0, 0, 1}}).ok());
    EXPECT_LT(largest_difference(third, decoded(third)), kFloatSamples);
}

TEST(RasterSession, FalloffMovesNeighboursByTheirDistance) {
    Session session = opened(complete(hills(65, 65), multires::SchemeId::Box, 1));
    const std::uint64_t middle = 32 * 65 + 32;
    const Raster before = decoded(session);
    ASSERT_TRUE(session
                    .apply({.level = 0,
                            .points = {middle},
                            .delta = {0, 0, 8},
                            .falloff = {.radius = 4, .profile = Falloff::Profile::Linear}})
                    .ok());
    const Raster after = decoded(session);
    for (std::int64_t i = 0; i < 65; ++i)
        for (std::int64_t j = 0; j < 65; ++j) {
            const double d = std::hypot(static_cast<double>(i - 32), static_cast<double>(j - 32));
            const double expected = 8 * std::max(0.0, 1 - d / 4);
            EXPECT_NEAR(after.planes[0](i, j) - before.planes[0](i, j), expected, 2e-5);
        }
}

TEST(RasterSession, NormalsAndSlopesAreThoseOfThePlane) {
    Raster raster = hills(40, 50);
    for (std::int64_t i = 0; i < 40; ++i)
        for (std::int64_t j = 0; j < 50; ++j)
            raster.planes[0](i, j) = 3 * static_cast<double>(j) - static_cast<double>(i);
    raster.geo.transform = {1000, 10, 0, 5000, 0, -20};
    Session session = opened(lossless(raster));
    const TileGeometry t = tile(session, {0, 0, 0});
    // z = 0.3 x + 0.05 y in page coordinates.
    const double size = std::sqrt(1 + 0.3 * 0.3 + 0.05 * 0.05);
    for (std::size_t k = 0; k < t.normal.size(); ++k) {
        EXPECT_NEAR(t.normal[k][0] / 32767.0, -0.3 / size, 1e-4);  // 16 bits
        EXPECT_NEAR(t.normal[k][1] / 32767.0, -0.05 / size, 1e-4);
    }
    const auto probe = session.at({100, -200});
    ASSERT_TRUE(probe.ok() && probe->has_value());
    EXPECT_NEAR((*probe)->value, 30 - 10, 1e-9);
    EXPECT_NEAR((*probe)->gradient.x, 0.3, 1e-9);
    EXPECT_NEAR((*probe)->gradient.y, 0.05, 1e-9);
    EXPECT_EQ((*probe)->place, (Vec2{1000 + 105, 5000 - 210}));
    EXPECT_FALSE(session.at({-1, 0})->has_value());
}

TEST(RasterSession, ErrorsAndMeasurementsAreAgainstTheOriginal) {
    Session session = opened(complete(hills(129, 129), multires::SchemeId::Box, 1));
    ASSERT_TRUE(session.set_view({.extras = {.error = true, .curvature = true}}).ok());
    ASSERT_TRUE(session.apply({.level = 0, .points = {129 * 9 + 20}, .delta = {0, 0, -4}}).ok());
    const TileGeometry t = tile(session, {0, 0, 0});
    for (std::size_t k = 0; k < t.error.size(); ++k)
        EXPECT_EQ(t.error[k], k == 129 * 9 + 20 ? -4.0F : 0.0F);
    EXPECT_EQ(t.curvature.size(), t.height.size());
    const auto measured = session.measure();
    ASSERT_TRUE(measured.ok());
    EXPECT_DOUBLE_EQ(measured->max_error, 4);
    EXPECT_DOUBLE_EQ(measured->rms_error, 4.0 / 129);
    EXPECT_EQ(measured->place.x, 20);
    EXPECT_EQ(measured->place.y, -9);
}

TEST(RasterSession, CompressionIsShownWithItsBound) {
    Session session = opened(lossless(hills(129, 129)));
    ASSERT_TRUE(session.apply({.level = 3, .points = {40}, .delta = {0, 0, 9}}).ok());
    const auto report = session.compress(0.5, {});
    ASSERT_TRUE(report.ok()) << report.error().text();
    EXPECT_LE(report->max_error, 0.5);
    EXPECT_LT(report->bytes, session.description().bytes);
    const TileGeometry edited = tile(session, {0, 0, 0});
    ASSERT_TRUE(session.set_view({.show = View::Show::Compressed}).ok());
    const TileGeometry compressed = tile(session, {0, 0, 0});
    float most = 0;
    for (std::size_t k = 0; k < edited.height.size(); ++k)
        most = std::max(most, std::abs(compressed.height[k] - edited.height[k]));
    EXPECT_GT(most, 0.0F);
    EXPECT_LE(most, 0.5F + 1e-5F);
}

TEST(RasterSession, ParametricSurfacesMoveInSpace) {
    Session session = opened(complete(hills(33, 33, 3), multires::SchemeId::Box, 1));
    EXPECT_TRUE(session.description().parametric);
    const TileGeometry before = tile(session, {0, 0, 0});
    ASSERT_TRUE(session.apply({.level = 0, .points = {100}, .delta = {1, 2, 3}}).ok());
    const TileGeometry after = tile(session, {0, 0, 0});
    for (std::size_t k = 0; k < before.position.size(); ++k)
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(after.position[k][c] - before.position[k][c],
                        k == 100 ? 1.0 + static_cast<double>(c) : 0.0, 2 * kFloat);
}

TEST(RasterSession, NetFollowsMovesOfAllLevels) {
    Session session = opened(complete(hills(65, 65), multires::SchemeId::Box, 2));
    const auto net = [&] { return *session.net(1, {}); };
    const NetGeometry before = net();
    EXPECT_EQ(before.point.size(), session.description().levels[1].control_points);
    ASSERT_TRUE(session.apply({.level = 1, .points = {300}, .delta = {0, 0, 2}}).ok());
    const NetGeometry moved = net();
    for (std::size_t k = 0; k < before.position.size(); ++k)
        EXPECT_NEAR(moved.position[k][2] - before.position[k][2], k == 300 ? 2.0 : 0.0, 2 * kFloat);
    ASSERT_TRUE(session.apply({.level = 2, .points = {100}, .delta = {0, 0, 2}}).ok());
    EXPECT_NE(net().position, moved.position);
    ASSERT_TRUE(session.undo(2).ok());
    EXPECT_EQ(net().position, before.position);
    // A window counts from the first control point.
    const auto part = session.net(1, LatticeBox{2, 3, 4, 5});
    ASSERT_TRUE(part.ok());
    const auto cols = static_cast<std::uint32_t>(session.description().levels[1].cols);
    EXPECT_EQ(part->point.front(), 2 * cols + 3);
    EXPECT_EQ(part->position.front(), before.position[2 * cols + 3]);
}

TEST(RasterSession, RefusesWhatItCanNotDo) {
    Session session = opened(lossless(hills(40, 40)));
    const auto refused = [&](const char* command, const char* reason) {
        const auto change = session.run(Json::parse(command));
        ASSERT_FALSE(change.ok()) << command;
        EXPECT_NE(change.error().message.find(reason), std::string::npos) << change.error().message;
    };
    refused(R"({"do": "jump"})", "\"do\" is none of");
    refused(R"([])", "\"do\" is none of");
    refused(R"({"do": "move", "points": [1], "delta": 1})", "\"level\"");
    refused(R"({"do": "move", "level": 1, "points": [], "delta": 1})", "\"points\"");
    refused(R"({"do": "move", "level": 1, "points": [-1], "delta": 1})", "\"points\"");
    refused(R"({"do": "move", "level": 1, "points": [1, 1], "delta": 1})", "twice");
    refused(R"({"do": "move", "level": 1, "points": [999999], "delta": 1})", "999999");
    refused(R"({"do": "move", "level": 40, "points": [1], "delta": 1})", "no level 40");
    refused(R"({"do": "move", "level": 1, "points": [1], "delta": "up"})", "\"delta\"");
    refused(R"({"do": "move", "level": 1, "points": [1], "delta": [1, 0, 0]})", "up and down");
    refused(R"({"do": "move", "level": 1, "points": [1], "delta": 1e301})", "1e300");
    refused(R"({"do": "tilt", "level": 1, "points": [1], "slope": [1, 0]})", "no slope");
    refused(R"({"do": "move", "level": 1, "points": [1], "delta": 1,
                "falloff": {"radius": -1}})",
            "\"radius\"");
    refused(R"({"do": "goto", "done": 4})", "0 commands");
    EXPECT_TRUE(session.history().entries.empty());
    EXPECT_EQ(*session.file(), lossless(hills(40, 40)));
    EXPECT_FALSE(session.tile({9, 0, 0}).ok());
    EXPECT_FALSE(session.surface().ok());
    const Status bad = session.replay(Json::parse(
        R"({"commands": [{"do": "move", "level": 1, "points": [1], "delta": 1}, {"do": "x"}]})"));
    ASSERT_FALSE(bad.ok());
    EXPECT_EQ(bad.error().where, "command 2");
    EXPECT_EQ(session.history().done, 1U);
}

}  // namespace
}  // namespace relief::edit
