#include "relief/io/crs.h"

#include <fstream>

#include "io/scratch.h"
#include "relief/io/raster.h"

namespace relief::io {
namespace {

using CrsTest = Scratch;

TEST_F(CrsTest, CodesStandWhereTheySayEverything) {
    EXPECT_EQ(*crs_from_user("EPSG:26911"), "EPSG:26911");
    EXPECT_EQ(*crs_from_user("epsg:4326"), "EPSG:4326");
    const std::string wkt = *crs_from_user("+proj=laea +lat_0=52 +lon_0=10 +ellps=GRS80");
    EXPECT_TRUE(wkt.starts_with("PROJCRS[")) << wkt;
    EXPECT_EQ(*crs_from_user(wkt), wkt);
}

TEST_F(CrsTest, FilesAreReadForUsers) {
    const std::string wkt = *crs_from_user("+proj=utm +zone=11 +ellps=clrk66");
    std::ofstream(path("survey.prj")) << wkt;
    EXPECT_EQ(*crs_from_user(path("survey.prj")), wkt);
}

TEST_F(CrsTest, WhatIsNotKnownIsRefused) {
    for (const char* text : {"EPSG:99999999", "", "somewhere in the north"}) {
        const auto refused = crs_from_user(text);
        ASSERT_FALSE(refused.ok()) << text;
        EXPECT_EQ(refused.error().code, ErrorCode::InvalidArgument);
        EXPECT_NE(refused.error().message.find("EPSG:26911"), std::string::npos);
    }
}

/// A reference system that a file brings is not allowed to name another file.
TEST_F(CrsTest, FilesDoNotNameOtherFiles) {
    std::ofstream(path("other.prj")) << *crs_from_user("EPSG:2229");
    Raster raster{.rows = 1, .cols = 1};
    raster.planes.emplace_back(1, 1)(0, 0) = 7;
    raster.geo = {.transform = {{0, 25, 0, 0, 0, -20}}, .crs = path("other.prj")};
    EXPECT_EQ(cell_size_metres(raster.geo, 1), (CellSize{25, 20}));  // not feet
    EXPECT_EQ(write_raster(path("a.tif"), raster).error().code, ErrorCode::CannotWrite);
    raster.geo.crs = "EPSG:2229";
    EXPECT_TRUE(write_raster(path("a.tif"), raster).ok());
}

}  // namespace
}  // namespace relief::io
