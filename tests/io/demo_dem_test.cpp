#include <cstdlib>

#include "io/scratch.h"
#include "relief/io/file.h"
#include "relief/io/raster.h"

namespace relief::io {
namespace {

using DemoDem = Scratch;

const std::string kScript =
    std::filesystem::path(RELIEF_TEST_DATA).parent_path().parent_path() / "tools/demo_dem.py";
constexpr const char* kArchive =
    "/usr/share/matplotlib/mpl-data/sample_data/jacksboro_fault_dem.npz";

TEST_F(DemoDem, WritesTheModelNorthUp) {
    if (!std::filesystem::exists(kArchive) ||
        std::system("/usr/bin/python3 -c 'import numpy, osgeo' 2>/dev/null") != 0)
        GTEST_SKIP() << "needs python3-numpy, python3-gdal and python-matplotlib-data";
    const std::string command = kScript + " " + path("sub/demo.tif");
    ASSERT_EQ(std::system(command.c_str()), 0);
    ASSERT_EQ(std::system(command.c_str()), 0);  // again over its own output
    const auto raster = read_raster(path("sub/demo.tif"));
    ASSERT_TRUE(raster.ok());
    EXPECT_EQ(raster->type, SampleType::Int16);
    EXPECT_EQ(raster->rows, 344);
    EXPECT_EQ(raster->cols, 403);
    EXPECT_EQ(raster->unit, "m");
    EXPECT_TRUE(raster->mask.empty());
    EXPECT_EQ(raster->geo.crs, "EPSG:4326");
    // Three arc seconds, from the north-western corner; heights of the model's first row and its
    // range.
    const auto& t = *raster->geo.transform;
    EXPECT_NEAR(t[0], -84.41375, 1e-9);
    EXPECT_NEAR(t[1], 3.0 / 3600, 1e-15);
    EXPECT_NEAR(t[3], 36.732916667, 1e-9);
    EXPECT_NEAR(t[5], -3.0 / 3600, 1e-15);
    const Grid<double>& z = raster->planes[0];
    EXPECT_EQ(z(0, 0), 483);
    EXPECT_EQ(z(0, 1), 487);
    double low = z(0, 0);
    double high = z(0, 0);
    for (std::int64_t r = 0; r < z.rows(); ++r) {
        low = std::min(low, *std::min_element(z.row(r), z.row(r) + z.cols()));
        high = std::max(high, *std::max_element(z.row(r), z.row(r) + z.cols()));
    }
    EXPECT_EQ(low, 236);
    EXPECT_EQ(high, 1076);
}

TEST_F(DemoDem, SaysWhatIsMissing) {
    const std::string command = kScript + " --source " + path("none.npz") + " " + path("demo.tif") +
                                " 2>" + path("message");
    EXPECT_NE(std::system(command.c_str()), 0);
    const auto message = read_file(path("message"));
    ASSERT_TRUE(message.ok());
    const std::string text(message->begin(), message->end());
    EXPECT_NE(text.find("install it: apt-get install python3-numpy python3-gdal"),
              std::string::npos)
        << text;
    EXPECT_EQ(files(), Names{"message"});
}

}  // namespace
}  // namespace relief::io
