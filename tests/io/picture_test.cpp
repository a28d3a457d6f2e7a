#include "relief/io/picture.h"

#include <cstdlib>
#include <limits>
#include <numbers>

#include "relief/core/parallel.h"
#include "relief/io/synthetic.h"
#include "relief/io/wireframe.h"

namespace relief::io {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
const double kNaN = std::numeric_limits<double>::quiet_NaN();

using Rgb = std::array<std::uint8_t, 3>;

Rgb at(const Image& image, int row, int col) {
    const std::uint8_t* p = image.pixel(row, col);
    return {p[0], p[1], p[2]};
}

/// z rises `east` a metre eastwards and `north` a metre northwards.
Grid<double> plane(std::int64_t rows, std::int64_t cols, CellSize cell, double east, double north) {
    Grid<double> z(rows, cols);
    for (std::int64_t r = 0; r < rows; ++r)
        for (std::int64_t c = 0; c < cols; ++c)
            z(r, c) = 100 + east * cell.x * static_cast<double>(c) -
                      north * cell.y * static_cast<double>(r);
    return z;
}

double closed_form(double east, double north, double azimuth, double altitude) {
    const double up = std::sin(altitude * kDegree) -
                      std::cos(altitude * kDegree) * (east * std::sin(azimuth * kDegree) +
                                                      north * std::cos(azimuth * kDegree));
    return std::max(0.0, up / std::sqrt(1 + east * east + north * north));
}

/// CIE lightness, 0 .. 100.
double lightness(const Rgb& rgb) {
    const auto linear = [](std::uint8_t code) {
        const double c = code / 255.0;
        return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
    };
    const double y = 0.2126 * linear(rgb[0]) + 0.7152 * linear(rgb[1]) + 0.0722 * linear(rgb[2]);
    return 116 * std::cbrt(y) - 16;  // all ramp colours are brighter than the linear toe
}

TEST(Illumination, APlaneHasItsClosedFormEverywhere) {
    EXPECT_TRUE(rc::check([] {
        const auto part = [](int low, int high) { return *rc::gen::inRange(low, high); };
        const CellSize cell{part(1, 100) / 4.0, part(1, 100) / 4.0};
        const double east = part(-30, 30) / 10.0;
        const double north = part(-30, 30) / 10.0;
        LightOptions light;
        light.azimuth = part(0, 360);
        light.altitude = part(1, 90);
        light.vertical_exaggeration = part(1, 5);
        const Grid<double> z = plane(part(1, 6) + 1, part(1, 6) + 1, cell, east, north);
        const Grid<double> shade = illumination(z.view(), {}, cell, light);
        const double expected =
            closed_form(east * light.vertical_exaggeration, north * light.vertical_exaggeration,
                        light.azimuth, light.altitude);
        // Differences of numbers near 1000 with 1e-13 of rounding, over cells of 0.25 at least,
        // exaggerated up to 4.
        for (std::int64_t r = 0; r < z.rows(); ++r)
            for (std::int64_t c = 0; c < z.cols(); ++c)
                RC_ASSERT(std::abs(shade(r, c) - expected) < 1e-10);
    }));
}

TEST(Illumination, HolesDoNotDisturbTheirNeighbours) {
    const CellSize cell{2, 3};
    Grid<double> z = plane(7, 8, cell, 0.4, -0.2);
    Grid<std::uint8_t> mask(7, 8, 1);
    mask(3, 3) = 0;
    z(3, 3) = 1e9;
    z(4, 5) = kNaN;
    const Grid<double> shade =
        illumination(z.view(), mask.view(), cell, {.vertical_exaggeration = 1});
    for (std::int64_t r = 0; r < 7; ++r) {
        for (std::int64_t c = 0; c < 8; ++c) {
            const bool hole = (r == 3 && c == 3) || (r == 4 && c == 5);
            EXPECT_EQ(std::isnan(shade(r, c)), hole);
            if (!hole) {
                EXPECT_NEAR(shade(r, c), closed_form(0.4, -0.2, 315, 45), 1e-12);
            }
        }
    }
}

TEST(Illumination, FourLightsAreTheirWeightedMean) {
    const CellSize cell{1, 1};
    const double east = 0.3;
    const double north = 0.7;
    const Grid<double> z = plane(3, 3, cell, east, north);
    const Grid<double> shade =
        illumination(z.view(), {}, cell, {.vertical_exaggeration = 1, .multidirectional = true});
    const double aspect = std::atan2(east, north);
    double expected = 0;
    for (const double azimuth : {225.0, 270.0, 315.0, 360.0})
        expected += std::pow(std::sin(aspect - azimuth * kDegree), 2) / 2 *
                    closed_form(east, north, azimuth, 45);
    EXPECT_NEAR(shade(1, 1), expected, 1e-12);
    const Grid<double> flat(3, 3, 5.0);
    const Grid<double> level = illumination(flat.view(), {}, cell, {.multidirectional = true});
    EXPECT_NEAR(level(1, 1), std::sqrt(0.5), 1e-12);
}

TEST(AutoExaggeration, MakesTheMeanSlope22Degrees) {
    const CellSize cell{10, 20};
    const Grid<double> z = plane(5, 6, cell, 0.03, 0.04);
    EXPECT_NEAR(auto_exaggeration(z.view(), {}, cell), 0.404 / 0.05, 1e-9);
    const Grid<double> flat(4, 4, 7.0);
    EXPECT_EQ(auto_exaggeration(flat.view(), {}, cell), 1);
}

TEST(Ramps, LightnessGrowsWithHeight) {
    for (const double start : {-1.0, 0.0}) {
        double before = -1;
        for (int k = 0; k < 100; ++k) {
            const double now = lightness(height_colour(start + k / 100.0));
            // One code of 255 of rounding in a channel is less than half a unit of lightness.
            EXPECT_GT(now, before - 0.5) << start << ' ' << k;
            before = std::max(before, now);
        }
    }
    EXPECT_LT(lightness(height_colour(-1)), 35);
    EXPECT_GT(lightness(height_colour(1)), 95);
    const double step = lightness(height_colour(1)) - lightness(height_colour(0.9));
    const double other = lightness(height_colour(0.1)) - lightness(height_colour(0.0));
    EXPECT_NEAR(step, other,
                0.5 * std::max(step, other));  // even to the eye: OKLab and CIE differ by that
}

TEST(Ramps, DifferencesAreSymmetricAboutNearWhite) {
    EXPECT_EQ(difference_colour(0)[0], difference_colour(0)[1]);
    EXPECT_GT(lightness(difference_colour(0)), 94);
    double before = 101;
    for (int k = 0; k <= 20; ++k) {
        const double cold = lightness(difference_colour(-k / 20.0));
        const double warm = lightness(difference_colour(k / 20.0));
        // Equal in OKLab; CIE lightness of saturated red and blue differs by some units.
        EXPECT_NEAR(cold, warm, 6) << k;
        EXPECT_LT(std::max(cold, warm), before);
        before = std::max(cold, warm);
    }
    EXPECT_EQ(difference_colour(7), difference_colour(1));
}

TEST(Pictures, HillshadeGreyFollowsIllumination) {
    const CellSize cell{1, 1};
    const Grid<double> z = plane(4, 5, cell, 0.5, 0);
    const Image image = hillshade(z.view(), {}, cell, {.light = {.vertical_exaggeration = 1}});
    const auto code =
        static_cast<std::uint8_t>(std::lround(24 + 228 * closed_form(0.5, 0, 315, 45)));
    EXPECT_EQ(image.width, 5);
    EXPECT_EQ(image.height, 4);
    for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 5; ++c) EXPECT_EQ(at(image, r, c), (Rgb{code, code, code}));
}

TEST(Pictures, SeaIsBlueOnlyWhereTheDataCrossesZero) {
    Grid<double> z(1, 3);
    z(0, 0) = -50, z(0, 1) = 0, z(0, 2) = 10;
    Image image = colour_by_height(z.view(), {}, {1, 1}, {}, Shading::Flat);
    EXPECT_EQ(at(image, 0, 0), height_colour(-1));
    EXPECT_EQ(at(image, 0, 1), height_colour(0));
    EXPECT_EQ(at(image, 0, 2), height_colour(1));
    z(0, 2) = -10, z(0, 1) = -30;
    image = colour_by_height(z.view(), {}, {1, 1}, {}, Shading::Flat);
    EXPECT_EQ(at(image, 0, 0), height_colour(0));
    EXPECT_EQ(at(image, 0, 1), height_colour(0.5));
    EXPECT_EQ(at(image, 0, 2), height_colour(1));
}

TEST(Pictures, HolesAreGreyOrTransparent) {
    const Grid<double> z(2, 2, 1.0);
    Grid<std::uint8_t> mask(2, 2, 1);
    mask(0, 1) = 0;
    const Image grey = colour_by_height(z.view(), mask.view(), {1, 1});
    EXPECT_EQ(at(grey, 0, 1), (Rgb{214, 214, 214}));
    const Image clear =
        colour_by_height(z.view(), mask.view(), {1, 1}, {.holes = HoleStyle::Transparent});
    ASSERT_EQ(clear.channels, 4);
    EXPECT_EQ(clear.pixel(0, 1)[3], 0);
    EXPECT_EQ(clear.pixel(0, 0)[3], 255);
}

TEST(Pictures, WidthKeepsTheProportionsOfTheGround) {
    const Grid<double> z = plane(20, 30, {1, 2}, 0.1, 0.1);
    const Image image = hillshade(z.view(), {}, {1, 2}, {.width = 60});
    EXPECT_EQ(image.width, 60);
    EXPECT_EQ(image.height, 80);
}

TEST(Pictures, ErrorMapIsColouredByTheDifferenceAndExplained) {
    Grid<double> reference(200, 300, 10.0);
    Grid<double> surface(200, 300, 10.0);
    surface(0, 0) = 13.5;
    surface(0, 1) = 6.5;
    const Image image = error_map(surface.view(), reference.view(), {}, {1, 1}, {.unit = "m"});
    EXPECT_EQ(at(image, 0, 0), difference_colour(0.7));  // the scale is 5, the next of 1, 2, 5
    EXPECT_EQ(at(image, 0, 1), difference_colour(-0.7));
    EXPECT_EQ(at(image, 100, 100), difference_colour(0));
    EXPECT_GT(image.height, 200);
    const Image fixed =
        error_map(surface.view(), reference.view(), {}, {1, 1}, {.scale = 3.5, .unit = "m"});
    EXPECT_EQ(at(fixed, 0, 0), difference_colour(1));
    // The legend: blue at the left end, red at the right end, ink below.
    const int bar = 200 + 6 + 5;
    EXPECT_EQ(at(image, bar, 30), difference_colour(2 * 0.5 / 240 - 1));
    EXPECT_EQ(at(image, bar, 269), difference_colour(1 - 2 * 0.5 / 240));
    int ink = 0;
    for (int r = 200; r < image.height; ++r)
        for (int c = 0; c < image.width; ++c) ink += at(image, r, c) == Rgb{60, 60, 64} ? 1 : 0;
    // Dots of -5, -2.5, 0, +2.5 and +5 m in the font, and five ticks of 3 pixels.
    EXPECT_EQ(ink, 22 + 41 + 16 + 45 + 41 + 5 * 3);
}

TEST(Pictures, ACaptionStandsBelow) {
    Image picture(80, 10, 3);
    std::fill(picture.pixels.begin(), picture.pixels.end(), std::uint8_t{90});
    const Image image = with_caption(picture, "il");
    // Two characters of 11 dots would fit at five pixels a dot; three is the largest.
    ASSERT_EQ(image.width, 80);
    ASSERT_EQ(image.height, 10 + 3 * (4 + 7 + 4));
    for (std::size_t k = 0; k < picture.pixels.size(); ++k) ASSERT_EQ(image.pixels[k], 90);
    std::string drawn;
    for (int row = 0; row < 7; ++row) {
        for (int dot = 0; dot < 11; ++dot)
            drawn += at(image, 10 + 12 + 3 * row, 23 + 3 * dot) == Rgb{60, 60, 64} ? '#' : '.';
        drawn += '\n';
    }
    EXPECT_EQ(drawn,
              "..#....##..\n"
              "........#..\n"
              ".##.....#..\n"
              "..#.....#..\n"
              "..#.....#..\n"
              "..#.....#..\n"
              ".###...###.\n");
    EXPECT_EQ(with_caption(picture, "").height, 10 + 3 * (4 + 7 + 4));
}

TEST(Resize, KeepsFlatColoursAndMeanLight) {
    EXPECT_TRUE(rc::check([](std::uint8_t r, std::uint8_t g, std::uint8_t b) {
        Image image(9, 7, 3);
        for (int k = 0; k < 63; ++k)
            image.pixels[3 * k] = r, image.pixels[3 * k + 1] = g, image.pixels[3 * k + 2] = b;
        for (const auto& [width, height] : {std::pair(4, 3), std::pair(20, 31), std::pair(1, 1)}) {
            const Image out = resize(image, width, height);
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x) RC_ASSERT((at(out, y, x) == Rgb{r, g, b}));
        }
    }));
    Image half(64, 64, 3);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
            for (int k = 0; k < 3; ++k) half.pixel(y, x)[k] = (x + y) % 2 == 0 ? 255 : 0;
    // Half of the light is code 188 in sRGB, not 128.
    EXPECT_NEAR(at(resize(half, 8, 8), 4, 4)[0], 188, 1);
}

TEST(Resize, TransparentPixelsDoNotBleed) {
    Image image(8, 1, 4);
    for (int x = 0; x < 8; ++x) {
        image.pixel(0, x)[0] = x < 4 ? 200 : 0;
        image.pixel(0, x)[1] = x < 4 ? 0 : 255;
        image.pixel(0, x)[3] = x < 4 ? 255 : 0;
    }
    const Image out = resize(image, 4, 1);
    for (int x = 0; x < 4; ++x)
        if (out.pixel(0, x)[3] > 40) {
            EXPECT_NEAR(out.pixel(0, x)[1], 0, 1);
        }
}

TEST(Wireframe, TheNearSurfaceHidesTheFarOne) {
    const auto sheet = [](double height, double half) {
        Grid<double> x(2, 2), y(2, 2), z(2, 2, height);
        for (int k = 0; k < 4; ++k) {
            x(k / 2, k % 2) = k % 2 == 0 ? -half : half;
            y(k / 2, k % 2) = k / 2 == 0 ? half : -half;
        }
        return point_sheet(x.view(), y.view(), z.view(), {});
    };
    const Sheet low = sheet(0, 2);
    const Sheet high = sheet(1, 1);
    for (const bool low_first : {true, false}) {
        std::array<Layer, 2> layers = {Layer{&low, {.fill = SheetFill::ByHeight}},
                                       Layer{&high, {.fill = SheetFill::Paper}}};
        if (!low_first) std::swap(layers[0], layers[1]);
        for (const double field : {0.0, 30.0}) {
            const Image image = draw_sheets(
                layers, {.width = 200, .azimuth = 180, .altitude = 90, .field_of_view = field});
            // Seen from above: white paper in the middle, the ramp's lowest colour around it, level
            // ground lit fully.
            const auto paper = at(image, image.height / 2, 100);
            EXPECT_NEAR(paper[0], 246, 1);
            EXPECT_EQ(paper[0], paper[2]);
            const auto ground = at(image, image.height / 2, 20);
            for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(ground[k], height_colour(0)[k], 1);
            EXPECT_EQ(at(image, image.height / 2, 1), (Rgb{255, 255, 255}));
        }
    }
}

TEST(Wireframe, ViewerStandsWhereTheAzimuthSays) {
    // A wall that rises to the north: from the south it fills the picture, and its top is at the
    // top.
    const Grid<double> z = plane(20, 20, {1, 1}, 0, 1);
    const Image image = wireframe(z.view(), {}, {1, 1},
                                  {.width = 120,
                                   .azimuth = 180,
                                   .altitude = 30,
                                   .background = HoleStyle::Transparent,
                                   .light = {.vertical_exaggeration = 1}});
    ASSERT_EQ(image.channels, 4);
    int top = 0;
    while (top < image.height && image.pixel(top, 60)[3] < 128) ++top;
    ASSERT_LT(top, image.height);
    const auto brightness = [&](int row) { return lightness(at(image, row, 62)); };
    EXPECT_GT(brightness(top + 6), brightness(image.height - 10));
    EXPECT_EQ(image.pixel(0, 0)[3], 0);
}

TEST(Wireframe, HiddenNetsShowFaintly) {
    Grid<double> x(2, 2), y(2, 2), z(2, 2, 0.0), below(2, 2, -1.0);
    for (int k = 0; k < 4; ++k) {
        x(k / 2, k % 2) = k % 2;
        y(k / 2, k % 2) = -(k / 2);
    }
    const Sheet surface = point_sheet(x.view(), y.view(), z.view(), {});
    const Sheet net = point_sheet(x.view(), y.view(), below.view(), {});
    const std::array<Layer, 2> layers = {Layer{&surface, {.fill = SheetFill::Paper}},
                                         Layer{&net,
                                               {.fill = SheetFill::None,
                                                .line_every = 1,
                                                .line_width = 8,
                                                .line_colour = {255, 0, 0}}}};
    const Image image = draw_sheets(layers, {.width = 300, .altitude = 90, .field_of_view = 25});
    int faint = 0;
    for (int r = 0; r < image.height; ++r)
        for (int c = 0; c < image.width; ++c) {
            const Rgb p = at(image, r, c);
            if (p[0] > p[1] + 20) {
                EXPECT_GT(p[1], 150);  // four tenths of red light over paper
                ++faint;
            }
        }
    EXPECT_GT(faint, 1000);
}

TEST(Wireframe, ANetAboveTheGroundLeavesItsColours) {
    const Grid<double> ground = plane(9, 9, {1, 1}, 0.2, 0.1);
    const Sheet surface = height_sheet(ground.view(), {}, {1, 1}, 1);
    const Sheet net = height_sheet(Grid<double>(2, 2, 300.0).view(), {}, {1, 1}, 1, {3, 3});
    const ViewOptions above{.width = 120, .altitude = 90, .field_of_view = 0};
    const std::array<Layer, 2> both = {Layer{&surface}, Layer{&net, {.fill = SheetFill::None}}};
    const Image alone = draw_sheets({both.data(), 1}, above);
    const Image covered = draw_sheets(both, above);
    ASSERT_EQ(covered.pixels.size(), alone.pixels.size());
    int difference = 0;
    for (std::size_t k = 0; k < alone.pixels.size(); ++k)
        difference = std::max(difference, std::abs(covered.pixels[k] - alone.pixels[k]));
    EXPECT_LE(difference, 2);  // the view's middle lies higher, which rounds positions differently
}

TEST(Wireframe, ThinnedSheetsLieOnTheSameGround) {
    const Grid<double> ground = plane(11, 8, {2, 3}, 0.5, 0.25);
    const Sheet all = height_sheet(ground.view(), {}, {2, 3}, 4, {10, 20});
    const Sheet third = height_sheet(ground.view(), {}, {2, 3}, 4, {10, 20}, 3);
    ASSERT_EQ(third.xyz[0].rows(), 4);
    ASSERT_EQ(third.xyz[0].cols(), 3);
    for (std::size_t k = 0; k < 3; ++k)
        for (int r = 0; r < 4; ++r)
            for (int c = 0; c < 3; ++c) EXPECT_EQ(third.xyz[k](r, c), all.xyz[k](3 * r, 3 * c));
}

TEST(Pictures, SameForAnyThreadCount) {
    const Raster raster = ridged(130, 5);
    const auto all = [&] {
        const auto z = raster.planes[0].view();
        std::vector<std::uint8_t> bytes = colour_by_height(z, {}, {30, 30}, {.width = 100}).pixels;
        for (const Image& image :
             {hillshade(z, {}, {30, 30}), wireframe(z, {}, {30, 30}, {.width = 150})})
            bytes.insert(bytes.end(), image.pixels.begin(), image.pixels.end());
        return bytes;
    };
    set_thread_count(1);
    const auto one = all();
    set_thread_count(4);
    const auto four = all();
    set_thread_count(0);
    EXPECT_EQ(one, four);
}

}  // namespace
}  // namespace relief::io
