#include "relief/io/drape.h"

#include "io/scratch.h"
#include "relief/io/file.h"
#include "relief/io/png.h"
#include "relief/io/raster.h"

namespace relief::io {
namespace {

using DrapeTest = Scratch;

/// 40 x 60 cells of 30 m, without samples.
Raster terrain() {
    Raster raster;
    raster.rows = 40;
    raster.cols = 60;
    raster.geo.crs = "EPSG:32611";
    raster.geo.transform = {400000, 30, 0, 5200000, 0, -30};
    return raster;
}

/// Samples of value(row, col, plane).
template <class Value>
Raster raster_of(std::int64_t rows, std::int64_t cols, int planes, SampleType type, Value value) {
    Raster raster;
    raster.rows = rows;
    raster.cols = cols;
    raster.type = type;
    for (int p = 0; p < planes; ++p) {
        Grid<double> plane(rows, cols);
        for (std::int64_t r = 0; r < rows; ++r)
            for (std::int64_t c = 0; c < cols; ++c) plane(r, c) = value(r, c, p);
        raster.planes.push_back(std::move(plane));
    }
    return raster;
}

using Pixel = std::array<int, 4>;
Pixel pixel(const Image& image, int row, int col) {
    const std::uint8_t* p = image.pixel(row, col);
    return {p[0], p[1], p[2], p[3]};
}

TEST_F(DrapeTest, PlainPictureStaysAsItIs) {
    Image image(5, 3, 3);
    for (std::size_t k = 0; k < image.pixels.size(); ++k)
        image.pixels[k] = static_cast<std::uint8_t>(5 * k);
    ASSERT_TRUE(write_png(path("a.png"), image).ok());
    const Raster under = terrain();
    const auto drape = read_drape(path("a.png"), &under, 4096);
    ASSERT_TRUE(drape.ok()) << drape.error().text();
    ASSERT_EQ(drape->width, 5);
    ASSERT_EQ(drape->height, 3);
    EXPECT_EQ(pixel(*drape, 0, 0), (Pixel{0, 5, 10, 255}));
    EXPECT_EQ(pixel(*drape, 2, 4), (Pixel{210, 215, 220, 255}));
    EXPECT_EQ(files(), Names{"a.png"});
}

TEST_F(DrapeTest, LargePicturesAreReduced) {
    Image image(64, 32, 4);
    for (std::uint8_t& sample : image.pixels) sample = 77;
    ASSERT_TRUE(write_png(path("a.png"), image).ok());
    const auto drape = read_drape(path("a.png"), nullptr, 16);
    ASSERT_TRUE(drape.ok());
    EXPECT_EQ(drape->width, 16);
    EXPECT_EQ(drape->height, 8);
    EXPECT_EQ(pixel(*drape, 3, 3), (Pixel{77, 77, 77, 77}));
}

TEST_F(DrapeTest, GreySamplesAreStretched) {
    const Raster grey = raster_of(2, 3, 1, SampleType::UInt16, [](auto r, auto c, int) {
        return static_cast<double>(1000 * (3 * r + c));
    });
    ASSERT_TRUE(write_raster(path("a.tif"), grey).ok());
    const auto drape = read_drape(path("a.tif"), nullptr, 4096);
    ASSERT_TRUE(drape.ok()) << drape.error().text();
    EXPECT_EQ(pixel(*drape, 0, 0), (Pixel{0, 0, 0, 255}));
    EXPECT_EQ(pixel(*drape, 1, 2), (Pixel{255, 255, 255, 255}));
    EXPECT_EQ(pixel(*drape, 0, 1), (Pixel{51, 51, 51, 255}));
}

// The picture has half the cell size, begins 10 cells east and 5 south of the terrain, and ends
// beyond it: where it is not, there is nothing.
TEST_F(DrapeTest, GeoreferencedPictureLiesWhereItBelongs) {
    Raster picture = raster_of(100, 200, 3, SampleType::UInt8, [](auto r, auto c, int p) {
        return p == 0 ? static_cast<double>(r) : p == 1 ? static_cast<double>(c) : 9.0;
    });
    picture.geo = terrain().geo;
    picture.geo.transform = {400300, 15, 0, 5199850, 0, -15};
    ASSERT_TRUE(write_raster(path("a.tif"), picture).ok());
    const Raster under = terrain();
    const auto drape = read_drape(path("a.tif"), &under, 4096);
    ASSERT_TRUE(drape.ok()) << drape.error().text();
    const int scale = drape->width / 60;
    ASSERT_GE(scale, 2);
    ASSERT_EQ(drape->width, 60 * scale);
    ASSERT_EQ(drape->height, 40 * scale);
    EXPECT_EQ(pixel(*drape, 0, 0)[3], 0);
    EXPECT_EQ(pixel(*drape, 20 * scale, 9 * scale)[3], 0);
    for (const auto& [row, col] : {std::pair{10, 20}, {30, 50}, {6, 11}}) {
        const Pixel found = pixel(*drape, row * scale, col * scale);
        // Bilinear interpolation of a ramp, rounded: one unit off at most.
        EXPECT_NEAR(found[0], 2 * (row - 5), 1);
        EXPECT_NEAR(found[1], 2 * (col - 10), 1);
        EXPECT_EQ(found[2], 9);
        EXPECT_EQ(found[3], 255);
    }
}

TEST_F(DrapeTest, OtherCrsIsWarped) {
    // One degree a pixel around the terrain (EPSG:32611, x 400000, y 5200000: 118.3 W, 46.9 N),
    // brighter to the north.
    Raster picture = raster_of(40, 40, 3, SampleType::UInt8,
                               [](auto r, auto, int) { return static_cast<double>(200 - 5 * r); });
    picture.geo.crs = "EPSG:4326";
    picture.geo.transform = {-119, 0.05, 0, 48, 0, -0.05};
    ASSERT_TRUE(write_raster(path("a.tif"), picture).ok());
    const Raster under = terrain();
    const auto drape = read_drape(path("a.tif"), &under, 4096);
    ASSERT_TRUE(drape.ok()) << drape.error().text();
    const Pixel middle = pixel(*drape, drape->height / 2, drape->width / 2);
    // Latitude 46.947: row 21.06 of the picture, its middle at 20.56.
    EXPECT_NEAR(middle[0], 200 - 5 * 20.56, 2);
    EXPECT_EQ(middle[3], 255);
}

TEST_F(DrapeTest, OthersAreRefused) {
    EXPECT_EQ(read_drape(path("none.png"), nullptr, 4096).error().code, ErrorCode::NotFound);
    const std::string vrt =
        "<VRTDataset rasterXSize=\"1\" rasterYSize=\"1\"><VRTRasterBand dataType=\"Byte\" "
        "band=\"1\"/></VRTDataset>";
    const auto* text = reinterpret_cast<const std::uint8_t*>(vrt.data());
    ASSERT_TRUE(write_file_atomically(path("a.png"), {text, vrt.size()}).ok());
    EXPECT_EQ(read_drape(path("a.png"), nullptr, 4096).error().code, ErrorCode::BadInput);

    Image image(300, 200, 3);
    std::uint32_t state = 1;
    for (std::uint8_t& sample : image.pixels)
        sample = static_cast<std::uint8_t>((state = state * 1664525U + 1013904223U) >> 24);
    ASSERT_TRUE(write_png(path("b.png"), image).ok());
    const auto bytes = *read_file(path("b.png"));
    for (const std::size_t keep : {10UL, 40UL, 1000UL, bytes.size() / 2}) {
        ASSERT_TRUE(write_file_atomically(path("c.png"), {bytes.data(), keep}).ok());
        EXPECT_FALSE(read_drape(path("c.png"), nullptr, 4096).ok()) << keep;
    }
}

}  // namespace
}  // namespace relief::io
