#include "relief/codec/plane_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "relief/codec/point_codec.h"

namespace relief::codec {
namespace {

using spline::PlaneJet;

std::vector<PlaneJet> jets(const PlaneSurface& surface, const std::vector<Vec2>& places) {
    std::vector<PlaneJet> found(places.size() * static_cast<std::size_t>(surface.components()));
    const Status status = surface.evaluate(places, 2, found);
    EXPECT_TRUE(status.ok()) << status.error().text();
    return found;
}

/// z = 2 x + 3 y on a rotated raster: its gradient in data units, whatever the transform.
TEST(PlaneSurface, OfARasterIsInDataUnits) {
    Raster raster;
    raster.rows = 40;
    raster.cols = 60;
    raster.type = SampleType::Float64;
    raster.geo.transform = {1000, 3, 1, 500, 1.5, -4};
    const auto& t = *raster.geo.transform;
    Grid<double> plane(40, 60);
    const auto place = [&](double r, double c) {
        return Vec2{t[0] + t[1] * (c + 0.5) + t[2] * (r + 0.5),
                    t[3] + t[4] * (c + 0.5) + t[5] * (r + 0.5)};
    };
    for (std::int64_t r = 0; r < 40; ++r)
        for (std::int64_t c = 0; c < 60; ++c) {
            const Vec2 p = place(static_cast<double>(r), static_cast<double>(c));
            plane(r, c) = 2 * p.x + 3 * p.y;
        }
    raster.planes.push_back(std::move(plane));
    const auto encoded = encode_raster(raster, {.goal = {Goal::Kind::Lossless, 0}});
    ASSERT_TRUE(encoded.ok());
    const auto file = RasterFile::open(encoded->bytes);
    const auto surface = plane_surface(*file);
    ASSERT_TRUE(surface.ok());
    const auto found = jets(**surface, {place(10.25, 30.5), place(39, 59), {0, 0}, {NAN, 0}});
    for (const std::size_t k : {0U, 1U}) {
        const Vec2 p = k == 0 ? place(10.25, 30.5) : place(39, 59);
        // Heights of 4000: 1e-12 of them, divided by cells of 3 for slopes.
        EXPECT_NEAR(found[k].value, 2 * p.x + 3 * p.y, 1e-8);
        EXPECT_NEAR(found[k].gradient.x, 2, 1e-8);
        EXPECT_NEAR(found[k].gradient.y, 3, 1e-8);
        EXPECT_NEAR(found[k].xx, 0, 1e-8);
    }
    for (const std::size_t k : {2U, 3U}) {
        EXPECT_TRUE(std::isnan(found[k].value));
        EXPECT_TRUE(std::isnan(found[k].yy));
    }
}

TEST(PlaneSurface, OfPointsHasTheirComponents) {
    PsData data;
    for (int k = 0; k < 60; ++k)
        data.points.push_back({std::fmod(0.618 * k, 1), std::fmod(0.324 * k, 1)});
    data.values.resize(2);
    for (const Vec2& p : data.points) {
        data.values[0].push_back(p.x - p.y);
        data.values[1].push_back(5 * p.y);
    }
    const auto encoded = encode_points(data, Interpolation{});
    ASSERT_TRUE(encoded.ok()) << encoded.error().text();
    const auto file = PsFile::open(encoded->bytes);
    const auto surface = plane_surface(*file);
    ASSERT_TRUE(surface.ok());
    ASSERT_EQ((*surface)->components(), 2);
    const auto found = jets(**surface, {{0.5, 0.5}, {9, 9}});
    EXPECT_NEAR(found[0].value, 0, 1e-12);
    EXPECT_NEAR(found[0].gradient.y, -1, 1e-11);
    EXPECT_NEAR(found[1].value, 2.5, 1e-12);
    EXPECT_TRUE(std::isnan(found[2].value) && std::isnan(found[3].value));
}

TEST(PlaneSurface, RefusesWrongSizesAndDerivatives) {
    Raster raster;
    raster.rows = raster.cols = 3;
    raster.planes.emplace_back(3, 3, 1.0);
    const auto encoded = encode_raster(raster, {});
    const auto file = RasterFile::open(encoded->bytes);
    const auto surface = plane_surface(*file);
    std::vector<Vec2> places(2);
    std::vector<PlaneJet> out(2);
    EXPECT_EQ((*surface)->evaluate(places, 3, out).error().code, ErrorCode::InvalidArgument);
    out.resize(1);
    EXPECT_EQ((*surface)->evaluate(places, 0, out).error().code, ErrorCode::InvalidArgument);
    raster.geo.transform = {0, 1, 1, 0, 1, 1};
    const auto flat = RasterFile::open(encode_raster(raster, {})->bytes);
    EXPECT_EQ(plane_surface(*flat).error().code, ErrorCode::BadInput);
}

}  // namespace
}  // namespace relief::codec
