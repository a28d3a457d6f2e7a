#include "relief/core/sampling.h"

#include <gtest/gtest.h>

namespace relief {
namespace {

TEST(Sampling, CutsCellsThatCoverTheSameGround) {
    const SampleAxis samples{0, 1, 12};
    EXPECT_EQ(samples.cut(0, 12, 12), samples);
    EXPECT_EQ(samples.cut(3, 4, 4), (SampleAxis{3, 1, 4}));
    // Three cells of four samples: centres 1.5, 5.5, 9.5.
    EXPECT_EQ(samples.cut(0, 12, 3), (SampleAxis{1.5, 4, 3}));
    // Halves of cells 2 and 3: centres a quarter before and behind theirs.
    EXPECT_EQ(samples.cut(2, 2, 4), (SampleAxis{1.75, 0.5, 4}));
    // Of cells of two samples that begin at -1: the second and third, in quarters.
    EXPECT_EQ((SampleAxis{-1, 2, 6}.cut(1, 2, 8)), (SampleAxis{0.25, 0.5, 8}));
}

TEST(Sampling, GeoreferencesFollow) {
    GeoReference geo;
    geo.transform = {100, 2, 1, 50, -1, -4};
    EXPECT_EQ(georeference_of(geo, {{0, 1, 5}, {0, 1, 7}}), geo);
    // Window from row 2, column 3 on.
    EXPECT_EQ(*georeference_of(geo, {{2, 1, 5}, {3, 1, 7}}).transform,
              (std::array<double, 6>{100 + 2 * 3 + 1 * 2, 2, 1, 50 - 1 * 3 - 4 * 2, -1, -4}));
    // Cells of 4 rows and 2 columns over the whole: the corner stays.
    EXPECT_EQ(*georeference_of(geo, {{1.5, 4, 2}, {0.5, 2, 3}}).transform,
              (std::array<double, 6>{100, 4, 4, 50, -2, -16}));
    EXPECT_FALSE(georeference_of({}, {{2, 1, 5}, {3, 1, 7}}).transform);
}

TEST(PlaceMap, InvertsTransforms) {
    GeoReference geo;
    geo.transform = {100, 2, 1, 50, -1, -4};
    const auto map = PlaceMap::create(geo);
    ASSERT_TRUE(map.ok());
    // Sample (i, j) = (3, 5) has its centre at column 5.5, row 3.5.
    const double x = 100 + 2 * 5.5 + 3.5;
    const double y = 50 - 5.5 - 4 * 3.5;
    EXPECT_DOUBLE_EQ(map->row(x, y), 3);
    EXPECT_DOUBLE_EQ(map->col(x, y), 5);
    // f = 3 x - y in samples: df/di = 3 * 1 + 4, df/dj = 3 * 2 + 1.
    const auto [dx, dy] = map->gradient(7, 7);
    EXPECT_DOUBLE_EQ(dx, 3);
    EXPECT_DOUBLE_EQ(dy, -1);
    // f = x^2 - 3 x y + 2 y^2: its second derivatives along rows (1, -4) and columns (2, -1).
    const auto second = [](double ax, double ay, double bx, double by) {
        return 2 * ax * bx - 3 * (ax * by + ay * bx) + 4 * ay * by;
    };
    const auto [xx, xy, yy] =
        map->hessian(second(1, -4, 1, -4), second(1, -4, 2, -1), second(2, -1, 2, -1));
    // Rounding of a few products of small numbers.
    EXPECT_NEAR(xx, 2, 1e-13);
    EXPECT_NEAR(xy, -3, 1e-13);
    EXPECT_NEAR(yy, 4, 1e-13);
}

TEST(PlaceMap, WithoutTransformSamplesAreTheCoordinates) {
    const auto map = PlaceMap::create({});
    ASSERT_TRUE(map.ok());
    EXPECT_EQ(map->row(7, 3), 3);
    EXPECT_EQ(map->col(7, 3), 7);
    EXPECT_EQ(map->gradient(2, 5), (std::array<double, 2>{5, 2}));
}

TEST(PlaceMap, RefusesTransformsWithoutArea) {
    GeoReference geo;
    geo.transform = {0, 1, 2, 0, 2, 4};
    const auto map = PlaceMap::create(geo);
    ASSERT_FALSE(map.ok());
    EXPECT_EQ(map.error().code, ErrorCode::BadInput);
}

}  // namespace
}  // namespace relief
