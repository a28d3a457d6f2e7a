#include "relief/io/raster.h"

#include <fstream>
#include <limits>

#include "io/scratch.h"
#include "relief/core/parallel.h"
#include "relief/io/file.h"
#include "relief/io/file_kind.h"

namespace relief::io {
namespace {

namespace fs = std::filesystem;

using RasterTest = Scratch;

constexpr SampleType kTypes[] = {SampleType::UInt8,  SampleType::UInt16, SampleType::Int16,
                                 SampleType::UInt32, SampleType::Int32,  SampleType::Float32,
                                 SampleType::Float64};
const double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A raster with samples over the whole range of its type, ends included.
Raster full_range(SampleType type, std::int64_t rows, std::int64_t cols, int planes) {
    Raster raster;
    raster.rows = rows;
    raster.cols = cols;
    raster.type = type;
    const auto [low, high] = sample_range(type);
    for (int p = 0; p < planes; ++p) {
        Grid<double> plane(rows, cols);
        for (std::int64_t k = 0; k < rows * cols; ++k) {
            const double t = static_cast<double>((k * 7919 + p * 31) % (rows * cols)) /
                             static_cast<double>(rows * cols - 1);
            plane(k / cols, k % cols) = stored_value(low * (1 - t) + high * t, type, {});
        }
        raster.planes.push_back(std::move(plane));
    }
    return raster;
}

Raster flat(SampleType type, const std::vector<double>& row) {
    Raster raster;
    raster.rows = 1;
    raster.cols = static_cast<std::int64_t>(row.size());
    raster.type = type;
    raster.planes.emplace_back(1, raster.cols);
    std::copy(row.begin(), row.end(), raster.planes[0].row(0));
    return raster;
}

std::vector<double> first_row(const Raster& raster) {
    return {raster.planes[0].row(0), raster.planes[0].row(0) + raster.cols};
}

void expect_same_planes(const Raster& a, const Raster& b) {
    ASSERT_EQ(a.planes.size(), b.planes.size());
    for (std::size_t p = 0; p < a.planes.size(); ++p)
        for (std::int64_t r = 0; r < a.rows; ++r)
            for (std::int64_t c = 0; c < a.cols; ++c)
                ASSERT_EQ(a.planes[p](r, c), b.planes[p](r, c)) << r << ',' << c;
}

TEST_F(RasterTest, EveryTypeSurvivesGeoTiffWithAllItsDescription) {
    for (const SampleType type : kTypes) {
        for (const int planes : {1, 3, 4}) {
            Raster raster = full_range(type, 13, 300, planes);
            raster.geo.transform = {500000.25, 30, 0, 5200000.5, 0, -30};
            raster.geo.crs = "EPSG:32632";
            raster.unit = "m";
            raster.scale = 0.5;
            raster.offset = -100;
            raster.metadata = {{"SURVEY", "2021, a=b"}};
            for (int p = 0; p < planes; ++p)
                raster.band_names.push_back("plane " + std::to_string(p));
            ASSERT_TRUE(write_raster(path("a.tif"), raster).ok()) << sample_type_name(type);
            const auto back = read_raster(path("a.tif"));
            ASSERT_TRUE(back.ok());
            EXPECT_EQ(back->type, type);
            EXPECT_EQ(back->rows, 13);
            EXPECT_EQ(back->cols, 300);
            EXPECT_TRUE(back->mask.empty());
            EXPECT_FALSE(back->nodata.has_value());
            EXPECT_EQ(back->geo.transform, raster.geo.transform);
            EXPECT_EQ(back->geo.crs, "EPSG:32632");
            EXPECT_FALSE(back->geo.pixel_is_point);
            EXPECT_EQ(back->unit, "m");
            EXPECT_EQ(back->scale, 0.5);
            EXPECT_EQ(back->offset, -100);
            EXPECT_EQ(back->band_names, raster.band_names);
            EXPECT_EQ(back->metadata, raster.metadata);
            expect_same_planes(*back, raster);
        }
    }
    EXPECT_EQ(files(), Names{"a.tif"});
}

/// Reference systems are named by a code only where the code says all of them.
TEST_F(RasterTest, ReferenceSystemsThatNoCodeDescribesStayWkt) {
    Raster raster = flat(SampleType::Int16, {1, 2, 3});
    raster.geo.transform = {10, 0.5, 0, 50, 0, -0.25};
    const auto returned = [&](const std::string& crs) {
        raster.geo.crs = crs;
        EXPECT_TRUE(write_raster(path("a.tif"), raster).ok());
        return read_raster(path("a.tif"))->geo.crs;
    };
    for (const char* code : {"EPSG:4326", "EPSG:26911", "EPSG:3035"})
        EXPECT_EQ(returned(code), code);
    const std::string own = returned("+proj=laea +lat_0=52 +lon_0=10 +ellps=GRS80");
    EXPECT_TRUE(own.starts_with("PROJCRS[")) << own;
    EXPECT_EQ(returned(own), own);
    EXPECT_EQ(returned(""), "");
}

TEST_F(RasterTest, PointRastersKeepTheirMeaningAndPlace) {
    Raster raster = flat(SampleType::Int16, {1, 2, 3});
    raster.geo.transform = {10, 0.5, 0, 50, 0, -0.25};
    raster.geo.crs = "EPSG:4326";
    raster.geo.pixel_is_point = true;
    ASSERT_TRUE(write_raster(path("a.tif"), raster).ok());
    const auto back = read_raster(path("a.tif"));
    ASSERT_TRUE(back.ok());
    EXPECT_TRUE(back->geo.pixel_is_point);
    EXPECT_EQ(back->geo.transform, raster.geo.transform);
}

TEST_F(RasterTest, HolesAreWrittenAsTheSourcesNodata) {
    for (const SampleType type : kTypes) {
        Raster raster = flat(type, {1, kNaN, 3});
        raster.nodata = 99;
        ASSERT_TRUE(write_raster(path("a.tif"), raster).ok());
        const auto back = read_raster(path("a.tif"));
        ASSERT_TRUE(back.ok());
        EXPECT_EQ(back->nodata, 99.0);
        ASSERT_EQ(back->mask.cols(), 3);
        EXPECT_EQ(back->mask(0, 0), 1);
        EXPECT_EQ(back->mask(0, 1), 0);
        EXPECT_EQ(back->mask(0, 2), 1);
        EXPECT_EQ(back->planes[0](0, 0), 1);
        EXPECT_TRUE(std::isnan(back->planes[0](0, 1)));
        EXPECT_EQ(back->planes[0](0, 2), 3);
    }
}

TEST_F(RasterTest, HolesWithoutNodataGetNanOrAFreeValue) {
    struct Case {
        SampleType type;
        std::vector<double> row;
        double nodata;
    };
    for (const Case& k : std::vector<Case>{{SampleType::Float32, {1, kNaN}, kNaN},
                                           {SampleType::Float64, {1, kNaN}, kNaN},
                                           {SampleType::Int16, {1, kNaN}, -32768},
                                           {SampleType::Int16, {-32768, kNaN}, 32767},
                                           {SampleType::Int16, {-32768, kNaN, 32767}, -32767},
                                           {SampleType::UInt8, {0, kNaN}, 255},
                                           {SampleType::UInt8, {255, kNaN}, 0},
                                           {SampleType::UInt8, {0, 1, kNaN, 255}, 2}}) {
        ASSERT_TRUE(write_raster(path("a.tif"), flat(k.type, k.row)).ok());
        const auto back = read_raster(path("a.tif"));
        ASSERT_TRUE(back.ok());
        ASSERT_TRUE(back->nodata.has_value());
        EXPECT_EQ(std::isnan(*back->nodata), std::isnan(k.nodata));
        if (!std::isnan(k.nodata)) {
            EXPECT_EQ(*back->nodata, k.nodata);
        }
        for (std::size_t c = 0; c < k.row.size(); ++c) {
            EXPECT_EQ(back->valid(0, static_cast<std::int64_t>(c)), std::isfinite(k.row[c]));
            if (std::isfinite(k.row[c])) {
                EXPECT_EQ(back->planes[0](0, static_cast<std::int64_t>(c)), k.row[c]);
            }
        }
    }
}

TEST_F(RasterTest, WhenEveryValueIsTakenAMaskBandMarksTheHoles) {
    std::vector<double> row(257);
    for (std::size_t k = 0; k < 257; ++k) row[k] = static_cast<double>(k % 256);
    row[256] = kNaN;
    ASSERT_TRUE(write_raster(path("a.tif"), flat(SampleType::UInt8, row)).ok());
    const auto back = read_raster(path("a.tif"));
    ASSERT_TRUE(back.ok());
    EXPECT_FALSE(back->nodata.has_value());
    for (std::int64_t c = 0; c < 256; ++c) EXPECT_EQ(back->planes[0](0, c), static_cast<double>(c));
    EXPECT_FALSE(back->valid(0, 256));
    EXPECT_EQ(files(), Names{"a.tif"});
    EXPECT_EQ(write_raster(path("a.png"), flat(SampleType::UInt8, row)).error().message,
              "the samples use every uint8 value, none is left for the holes; write .tif");
}

TEST_F(RasterTest, AHoleInOneBandIsAHoleInAll) {
    Raster raster = full_range(SampleType::Float32, 4, 5, 3);
    raster.planes[1](2, 3) = kNaN;
    raster.planes[2](0, 0) = std::numeric_limits<double>::infinity();
    ASSERT_TRUE(write_raster(path("a.tif"), raster).ok());
    const auto back = read_raster(path("a.tif"));
    ASSERT_TRUE(back.ok());
    for (std::int64_t r = 0; r < 4; ++r) {
        for (std::int64_t c = 0; c < 5; ++c) {
            const bool hole = (r == 2 && c == 3) || (r == 0 && c == 0);
            EXPECT_EQ(back->valid(r, c), !hole);
            for (int p = 0; p < 3; ++p)
                EXPECT_EQ(std::isnan(back->planes[static_cast<std::size_t>(p)](r, c)), hole);
        }
    }
}

TEST_F(RasterTest, ValidSamplesNeverReadAsNodata) {
    EXPECT_TRUE(rc::check([](std::uint8_t type_index, std::int16_t nodata,
                             std::vector<std::int16_t> values) {
        const SampleType type = kTypes[type_index % 7];
        std::vector<double> row = {
            kNaN, double(nodata), nodata + 0.25, nodata - 0.25, nodata * (1 + 1e-7), 1e300, -1e300};
        for (const std::int16_t value : values) row.push_back(value / 3.0);
        Raster raster = flat(type, row);
        raster.nodata = nodata;
        RC_ASSERT(write_raster("/vsimem/nudge.tif", raster).ok());
        const auto back = read_raster("/vsimem/nudge.tif");
        RC_ASSERT(back.ok());
        RC_ASSERT(!back->valid(0, 0));
        const auto [low, high] = sample_range(type);
        const bool kept = !is_integer(type) || (nodata >= low && nodata <= high);
        for (std::size_t c = 1; c < row.size(); ++c) {
            const auto col = static_cast<std::int64_t>(c);
            RC_ASSERT(back->valid(0, col));
            const double ideal = std::clamp(row[c], low, high);
            // Half a unit of rounding and one unit of moving; for floats 8 and one of their
            // relative precision.
            const double precision = 0x1p-23;
            const double slack =
                is_integer(type) ? (kept ? 1.5 : 0.5) : 9 * precision * std::abs(ideal) + 1e-37;
            RC_ASSERT(std::abs(back->planes[0](0, col) - ideal) <= slack);
        }
    }));
}

TEST(StoredValue, RoundsClampsAndAvoidsNodata) {
    EXPECT_EQ(stored_value(2.5, SampleType::Int16, {}), 2);
    EXPECT_EQ(stored_value(3.5, SampleType::Int16, {}), 4);
    EXPECT_EQ(stored_value(-40000, SampleType::Int16, {}), -32768);
    EXPECT_EQ(stored_value(-1, SampleType::UInt32, {}), 0);
    EXPECT_EQ(stored_value(6.9, SampleType::UInt8, 7.0), 6);
    EXPECT_EQ(stored_value(7.0, SampleType::UInt8, 7.0), 8);
    EXPECT_EQ(stored_value(300, SampleType::UInt8, 255.0), 254);
    EXPECT_EQ(stored_value(-3, SampleType::UInt8, 0.0), 1);
    EXPECT_EQ(stored_value(0.1, SampleType::Float32, {}), static_cast<double>(0.1F));
    EXPECT_EQ(stored_value(1e300, SampleType::Float32, {}),
              static_cast<double>(std::numeric_limits<float>::max()));
    EXPECT_EQ(stored_value(-9999, SampleType::Float64, -9999.0), -9999 + 9999 * 0x1p-20);
    EXPECT_EQ(stored_value(0, SampleType::Float64, 0.0), std::numeric_limits<double>::min());
}

TEST(SampleTypes, NamesGoBothWays) {
    for (const SampleType type : kTypes)
        EXPECT_EQ(*sample_type_from_name(sample_type_name(type)), type);
    EXPECT_EQ(sample_type_from_name("int8").error().message,
              "no sample type 'int8'; choose one of uint8, uint16, int16, uint32, int32, float32, "
              "float64");
}

TEST_F(RasterTest, WindowsAreCutOutWithTheirPlace) {
    Raster raster = full_range(SampleType::Int16, 40, 50, 2);
    raster.geo.transform = {1000, 2, 0.5, 3000, -0.25, -4};
    ASSERT_TRUE(write_raster(path("a.tif"), raster).ok());
    ReadOptions options;
    options.window = LatticeBox{10, 20, 5, 7};
    const auto part = read_raster(path("a.tif"), options);
    ASSERT_TRUE(part.ok());
    EXPECT_EQ(part->rows, 5);
    EXPECT_EQ(part->cols, 7);
    EXPECT_EQ((*part->geo.transform)[0], 1000 + 20 * 2 + 10 * 0.5);
    EXPECT_EQ((*part->geo.transform)[3], 3000 - 20 * 0.25 - 10 * 4);
    for (std::int64_t r = 0; r < 5; ++r)
        for (std::int64_t c = 0; c < 7; ++c)
            EXPECT_EQ(part->planes[1](r, c), raster.planes[1](r + 10, c + 20));
    for (const LatticeBox& box :
         {LatticeBox{-1, 0, 2, 2}, LatticeBox{39, 0, 2, 2}, LatticeBox{0, 50, 1, 1},
          LatticeBox{0, 0, 0, 1}, LatticeBox{1, 1, std::numeric_limits<std::int64_t>::max(), 1}}) {
        options.window = box;
        EXPECT_EQ(read_raster(path("a.tif"), options).error().code, ErrorCode::InvalidArgument);
    }
}

TEST_F(RasterTest, PngHolds16BitsAndTakesFittingIntegers) {
    Raster raster = flat(SampleType::UInt16, {0, 1, 65535});
    ASSERT_TRUE(write_raster(path("a.png"), raster).ok());
    auto back = read_raster(path("a.png"));
    ASSERT_TRUE(back.ok());
    EXPECT_EQ(back->type, SampleType::UInt16);
    EXPECT_EQ(first_row(*back), (std::vector<double>{0, 1, 65535}));

    ASSERT_TRUE(write_raster(path("b.png"), flat(SampleType::Int16, {0, 300, 8848})).ok());
    back = read_raster(path("b.png"));
    ASSERT_TRUE(back.ok());
    EXPECT_EQ(back->type, SampleType::UInt16);
    EXPECT_EQ(first_row(*back), (std::vector<double>{0, 300, 8848}));

    const Status refused = write_raster(path("c.png"), flat(SampleType::Float32, {0.5, 1}));
    EXPECT_EQ(refused.error().message,
              "PNG files can not hold these float32 values exactly (they hold Byte UInt16); "
              "write .tif");
    EXPECT_EQ(files(), (Names{"a.png", "b.png"}));
}

TEST_F(RasterTest, EsriGridsKeepValuesHolesAndCrs) {
    Raster raster = flat(SampleType::Float32, {1.5, kNaN, -2.25});
    raster.nodata = -9999;
    raster.geo.transform = {100, 10, 0, 200, 0, -10};
    raster.geo.crs = "EPSG:32632";
    ASSERT_TRUE(write_raster(path("a.asc"), raster).ok());
    EXPECT_EQ(files(), (Names{"a.asc", "a.prj"}));
    const auto back = read_raster(path("a.asc"));
    ASSERT_TRUE(back.ok());
    EXPECT_EQ(back->planes[0](0, 0), 1.5);
    EXPECT_FALSE(back->valid(0, 1));
    EXPECT_EQ(back->planes[0](0, 2), -2.25);
    EXPECT_EQ(back->geo.transform, raster.geo.transform);
    EXPECT_NE(back->geo.crs.find("UTM zone 32N"), std::string::npos);
    EXPECT_EQ(files(), (Names{"a.asc", "a.prj"}));
}

TEST_F(RasterTest, AlphaBecomesTheMask) {
    std::ofstream(path("a.vrt"))
        << "<VRTDataset rasterXSize='2' rasterYSize='1'>"
           "<VRTRasterBand dataType='Byte' band='1'/>"
           "<VRTRasterBand dataType='Byte' band='2'><ColorInterp>Alpha</ColorInterp>"
           "</VRTRasterBand></VRTDataset>";
    const auto raster = read_raster(path("a.vrt"));
    ASSERT_TRUE(raster.ok());
    EXPECT_EQ(raster->planes.size(), 1U);
    EXPECT_FALSE(raster->valid(0, 0));
    EXPECT_FALSE(raster->valid(0, 1));
    EXPECT_EQ(files(), Names{"a.vrt"});
}

TEST_F(RasterTest, SignedBytesAndMixedTypesAreWidened) {
    const auto vrt = [&](const std::string& bands) {
        std::ofstream(path("a.vrt"))
            << "<VRTDataset rasterXSize='2' rasterYSize='1'>" << bands << "</VRTDataset>";
        return read_raster(path("a.vrt"));
    };
    const auto band = [](const char* type) {
        return std::string("<VRTRasterBand dataType='") + type + "'/>";
    };
    EXPECT_EQ(vrt(band("Byte") + band("Int16"))->type, SampleType::Int16);
    EXPECT_EQ(vrt(band("Byte") + band("UInt16"))->type, SampleType::UInt16);
    EXPECT_EQ(vrt(band("UInt16") + band("Int16"))->type, SampleType::Int32);
    EXPECT_EQ(vrt(band("UInt32") + band("Int16"))->type, SampleType::Float64);
    EXPECT_EQ(vrt(band("UInt16") + band("Float32"))->type, SampleType::Float32);
    EXPECT_EQ(vrt(band("Int32") + band("Float32"))->type, SampleType::Float64);

    Raster bytes = flat(SampleType::UInt8, {0, 127, 128, 255});
    WriteOptions options;
    options.creation_options = {"PIXELTYPE=SIGNEDBYTE"};
    ASSERT_TRUE(write_raster(path("s.tif"), bytes, options).ok());
    const auto back = read_raster(path("s.tif"));
    ASSERT_TRUE(back.ok());
    EXPECT_EQ(back->type, SampleType::Int16);
    EXPECT_EQ(first_row(*back), (std::vector<double>{0, 127, -128, -1}));
}

TEST_F(RasterTest, UnusableInputsAreExplained) {
    const auto error = [](const std::string& name) { return read_raster(name).error(); };
    const auto vrt = [&](const std::string& body) {
        std::ofstream(path("a.vrt")) << body;
        return read_raster(path("a.vrt")).error();
    };
    const std::string open = "<VRTDataset rasterXSize='2' rasterYSize='1'>";
    const std::string byte = "<VRTRasterBand dataType='Byte'/>";

    EXPECT_EQ(error(path("none.tif")).text(), path("none.tif") + ": no such file; check the path");
    EXPECT_EQ(error(path("none.tif")).code, ErrorCode::NotFound);
    EXPECT_EQ(error(path("")).message, "is a directory; name a raster file in it");
    std::ofstream(path("text.tif")) << "this is no raster";
    EXPECT_EQ(error(path("text.tif")).code, ErrorCode::BadInput);
    EXPECT_NE(error(path("text.tif")).message.find("not a raster that GDAL can read"),
              std::string::npos);
    EXPECT_NE(error(path("text.tif")).message.find("(GDAL: "), std::string::npos);
    EXPECT_EQ(vrt(open + byte + byte + byte + byte + byte + "</VRTDataset>").message,
              "has 5 bands, at most 4 are supported; choose some: gdal_translate -b 1");
    EXPECT_EQ(vrt(open + "<VRTRasterBand dataType='CFloat32'/></VRTDataset>").message,
              "samples of type CFloat32 are not supported; take one part of it: gdal_translate -ot "
              "Float64");
    EXPECT_EQ(vrt(open + "<VRTRasterBand dataType='Int64'/></VRTDataset>").message,
              "samples of type Int64 are not supported; convert it: gdal_translate -ot Float64");
    EXPECT_EQ(vrt("<VRTDataset rasterXSize='2147483647' rasterYSize='2147483647'>" + byte +
                  "</VRTDataset>")
                  .message,
              "2147483647 x 2147483647 samples are too many for memory; read a window");
    EXPECT_EQ(files(), (Names{"a.vrt", "text.tif"}));
}

TEST_F(RasterTest, ContainersOfSeveralRastersNameTheirParts) {
    ASSERT_TRUE(write_raster(path("a.nc"), full_range(SampleType::Int16, 4, 5, 2)).ok());
    const auto raster = read_raster(path("a.nc"));
    ASSERT_FALSE(raster.ok());
    EXPECT_NE(
        raster.error().message.find("holds 2 subdatasets; name one of them, such as 'NETCDF:"),
        std::string::npos)
        << raster.error().message;
    EXPECT_TRUE(read_raster("NETCDF:" + path("a.nc") + ":Band2").ok());
}

TEST_F(RasterTest, DamagedFilesAreRefused) {
    ASSERT_TRUE(write_raster(path("a.tif"), full_range(SampleType::Int32, 300, 300, 1)).ok());
    const auto bytes = *read_file(path("a.tif"));
    ASSERT_TRUE(write_file_atomically(path("b.tif"), {bytes.data(), bytes.size() / 2}).ok());
    const auto raster = read_raster(path("b.tif"));
    ASSERT_FALSE(raster.ok());
    EXPECT_EQ(raster.error().code, ErrorCode::BadFile);
    EXPECT_NE(raster.error().where.find("b.tif, row "), std::string::npos);
}

TEST_F(RasterTest, UnusableOutputsAreExplainedAndLeaveNothing) {
    const Raster raster = flat(SampleType::Int16, {1, 2});
    const auto error = [&](const std::string& name) { return write_raster(name, raster).error(); };
    EXPECT_EQ(error(path("no/a.tif")).message,
              "there is no directory '" + path("no") + "'; create it first");
    EXPECT_EQ(
        error(path("a.nonsense")).message,
        "no raster format is written with the extension 'nonsense'; use .tif, or name a driver");
    EXPECT_EQ(error(path("a.vrt")).code, ErrorCode::InvalidArgument);
    EXPECT_EQ(error(path("a")).code, ErrorCode::InvalidArgument);
    fs::create_directory(path("dir.tif"));
    EXPECT_EQ(error(path("dir.tif")).message, "is a directory; give a file name");
    WriteOptions options;
    options.driver = "Nonsense";
    EXPECT_EQ(write_raster(path("a.tif"), raster, options).error().code,
              ErrorCode::InvalidArgument);
    options = {};
    options.creation_options = {"COMPRESS"};
    EXPECT_EQ(write_raster(path("a.tif"), raster, options).error().message,
              "the creation option 'COMPRESS' is not NAME=VALUE");
    Raster wrong = flat(SampleType::Int16, {1, 2});
    wrong.rows = 2;
    EXPECT_EQ(write_raster(path("a.tif"), wrong).error().message,
              "the planes have another size than the raster");
    EXPECT_EQ(files(), Names{"dir.tif"});
}

TEST_F(RasterTest, AFullDiskLeavesTheOldFile) {
    ASSERT_TRUE(write_raster(path("a.tif"), flat(SampleType::Int16, {1, 2})).ok());
    for (const char* name : {"a.tif", "b.asc"}) {
        const FileSizeLimit limit(20000);
        const Status status =
            write_raster(path(name), full_range(SampleType::Float32, 500, 500, 1));
        ASSERT_FALSE(status.ok()) << name;
        EXPECT_EQ(status.error().code, ErrorCode::CannotWrite);
    }
    EXPECT_EQ(files(), Names{"a.tif"});
    EXPECT_EQ(first_row(*read_raster(path("a.tif"))), (std::vector<double>{1, 2}));
}

TEST_F(RasterTest, CancellingLeavesNothing) {
    const Raster raster = full_range(SampleType::Float32, 600, 600, 1);
    WriteOptions write;
    write.progress = [](double fraction) { return fraction < 0.3; };
    EXPECT_EQ(write_raster(path("a.tif"), raster, write).error().code, ErrorCode::Cancelled);
    EXPECT_EQ(files(), Names{});
    ASSERT_TRUE(write_raster(path("a.tif"), raster).ok());
    std::vector<double> seen;
    ReadOptions read;
    read.progress = [&](double fraction) {
        seen.push_back(fraction);
        return true;
    };
    ASSERT_TRUE(read_raster(path("a.tif"), read).ok());
    EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
    EXPECT_EQ(seen.back(), 1);
    read.progress = [](double) { return false; };
    EXPECT_EQ(read_raster(path("a.tif"), read).error().code, ErrorCode::Cancelled);
}

TEST_F(RasterTest, SameBytesForAnyThreadCount) {
    const Raster raster = full_range(SampleType::Float32, 700, 900, 2);
    set_thread_count(1);
    ASSERT_TRUE(write_raster(path("a.tif"), raster).ok());
    set_thread_count(4);
    ASSERT_TRUE(write_raster(path("b.tif"), raster).ok());
    set_thread_count(0);
    EXPECT_EQ(*read_file(path("a.tif")), *read_file(path("b.tif")));
}

TEST_F(RasterTest, ReplacingAFileRemovesWhatDescribedTheOldOne) {
    const Raster raster = flat(SampleType::Int16, {1, 2});
    ASSERT_TRUE(write_raster(path("a.tif"), raster).ok());
    std::ofstream(path("a.tif.aux.xml")) << "<PAMDataset/>";
    ASSERT_TRUE(write_raster(path("a.tif"), raster).ok());
    EXPECT_EQ(files(), Names{"a.tif"});
}

TEST(CellSizeMetres, FollowsTheCrs) {
    GeoReference geo;
    EXPECT_EQ(cell_size_metres(geo, 10), (CellSize{1, 1}));
    geo.transform = {0, 25, 0, 0, 0, -20};
    EXPECT_EQ(cell_size_metres(geo, 10), (CellSize{25, 20}));
    geo.crs = "EPSG:2229";  // US survey feet
    EXPECT_NEAR(cell_size_metres(geo, 10).x, 25 * 1200.0 / 3937, 1e-9);
    // A degree at the equator and at 60 degrees north on WGS 84: published lengths, rounded to a
    // metre.
    geo.crs = "EPSG:4326";
    geo.transform = {0, 1, 0, 0.5, 0, -1};
    EXPECT_NEAR(cell_size_metres(geo, 1).x, 111320, 1);
    EXPECT_NEAR(cell_size_metres(geo, 1).y, 110574, 1);
    geo.transform = {0, 1, 0, 60.5, 0, -1};
    EXPECT_NEAR(cell_size_metres(geo, 1).x, 55800, 1);
    EXPECT_NEAR(cell_size_metres(geo, 1).y, 111412, 1);
}

TEST(CellSizeInUnit, IsThatOfTheHeights) {
    Raster about;
    about.geo.transform = {0, 25, 0, 0, 0, -20};
    EXPECT_FALSE(cell_size_in_unit(about));
    about.geo.crs = "EPSG:26911";  // metres
    EXPECT_EQ(cell_size_in_unit(about), (CellSize{25, 20}));
    about.unit = "m";
    EXPECT_EQ(cell_size_in_unit(about), (CellSize{25, 20}));
    about.unit = "ft";
    EXPECT_NEAR(cell_size_in_unit(about)->y, 20 / 0.3048, 1e-9);
    about.unit = "US survey foot";
    EXPECT_NEAR(cell_size_in_unit(about)->x, 25 * 3937.0 / 1200, 1e-9);
}

TEST_F(RasterTest, FileKindsAreRecognisedByContentThenExtension) {
    const auto kind = [&](const std::string& name, const std::string& content) {
        std::ofstream(path(name), std::ios::binary) << content;
        return recognise(path(name));
    };
    EXPECT_EQ(kind("a.tif", "RELIEF\x89\r\n\x1A"), FileKind::Relief);
    EXPECT_EQ(kind("a.dat", "ply\nformat ascii 1.0\n"), FileKind::Mesh);
    EXPECT_EQ(kind("b.dat", "OFF 3 1 0\n"), FileKind::Mesh);
    EXPECT_EQ(kind("a.obj", "v 0 0 0\n"), FileKind::Mesh);
    EXPECT_EQ(kind("a.STL", "solid x\n"), FileKind::Mesh);
    EXPECT_EQ(kind("a.glb", "glTF"), FileKind::Mesh);
    EXPECT_EQ(kind("a.xyz", "0 0 1\n1 0 2\n0 1 3\n1 1 4\n"), FileKind::Points);
    EXPECT_EQ(kind("a.csv", "x,y,z\n0,0,1\n"), FileKind::Points);
    EXPECT_EQ(kind("a.txt", "1 2 3\n"), FileKind::Points);
    EXPECT_EQ(kind("g.txt", "ncols 1\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n5\n"),
              FileKind::Raster);
    EXPECT_EQ(kind("a.bin", "nothing known"), FileKind::Unknown);
    EXPECT_EQ(recognise(path("none")), FileKind::Unknown);
    ASSERT_TRUE(write_raster(path("r.tif"), flat(SampleType::Int16, {1, 2})).ok());
    fs::rename(path("r.tif"), path("r.bin"));
    EXPECT_EQ(recognise(path("r.bin")), FileKind::Raster);
}

}  // namespace
}  // namespace relief::io
