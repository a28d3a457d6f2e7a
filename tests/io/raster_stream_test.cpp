#include <fstream>
#include <limits>
#include <sstream>
#include <thread>

#include "io/scratch.h"
#include "relief/core/parallel.h"
#include "relief/io/file.h"
#include "relief/io/raster.h"

namespace relief::io {
namespace {

namespace fs = std::filesystem;

using RasterStreamTest = Scratch;

const double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Whole numbers 1 .. 200 that differ between neighbours, rows and planes; every 11th sample may be
/// a hole.
double sample(std::int64_t row, std::int64_t col, std::size_t plane) {
    return static_cast<double>((row * 131 + col * 17 + static_cast<std::int64_t>(plane) * 7) % 200 +
                               1);
}

bool is_hole(std::int64_t row, std::int64_t col) {
    return (row * 3 + col) % 11 == 0;
}

/// Rows first .. first + rows - 1 of a raster of such samples.
Raster strip_of(const Raster& whole, std::int64_t first, std::int64_t rows) {
    Raster strip;
    strip.rows = rows;
    strip.cols = whole.cols;
    for (const Grid<double>& plane : whole.planes) {
        strip.planes.emplace_back(rows, whole.cols);
        for (std::int64_t r = 0; r < rows; ++r)
            std::copy_n(plane.row(first + r), whole.cols, strip.planes.back().row(r));
    }
    if (whole.mask.empty()) return strip;
    strip.mask = Grid<std::uint8_t>(rows, whole.cols);
    for (std::int64_t r = 0; r < rows; ++r)
        std::copy_n(whole.mask.row(first + r), whole.cols, strip.mask.row(r));
    return strip;
}

Raster samples(SampleType type, std::int64_t rows, std::int64_t cols, std::size_t planes = 1) {
    Raster raster;
    raster.rows = rows;
    raster.cols = cols;
    raster.type = type;
    raster.geo.transform = {1000, 2, 0, 3000, 0, -2};
    for (std::size_t k = 0; k < planes; ++k) {
        raster.planes.emplace_back(rows, cols);
        for (std::int64_t r = 0; r < rows; ++r)
            for (std::int64_t c = 0; c < cols; ++c) raster.planes[k](r, c) = sample(r, c, k);
    }
    return raster;
}

/// Holes in rows 0 .. rows - 1.
Raster with_holes(Raster raster, std::int64_t rows) {
    raster.mask = Grid<std::uint8_t>(raster.rows, raster.cols, 1);
    for (std::int64_t r = 0; r < rows; ++r) {
        for (std::int64_t c = 0; c < raster.cols; ++c) {
            if (!is_hole(r, c)) continue;
            raster.mask(r, c) = 0;
            for (Grid<double>& plane : raster.planes) plane(r, c) = kNaN;
        }
    }
    return raster;
}

/// Whether `part` holds the samples and holes of `whole` from (row0, col0) on.
void expect_crop(const Raster& part, const Raster& whole, const LatticeBox& box) {
    ASSERT_EQ(part.rows, box.rows);
    ASSERT_EQ(part.cols, box.cols);
    ASSERT_EQ(part.planes.size(), whole.planes.size());
    bool holes = false;
    for (std::int64_t r = 0; r < box.rows; ++r) {
        for (std::int64_t c = 0; c < box.cols; ++c) {
            const bool valid = whole.valid(box.row0 + r, box.col0 + c);
            holes = holes || !valid;
            ASSERT_EQ(part.valid(r, c), valid) << r << ',' << c;
            for (std::size_t k = 0; k < part.planes.size(); ++k) {
                const double value = part.planes[k](r, c);
                const double expected = valid ? whole.planes[k](box.row0 + r, box.col0 + c) : kNaN;
                ASSERT_TRUE(value == expected || (!valid && std::isnan(value)))
                    << r << ',' << c << ": " << value;
            }
        }
    }
    EXPECT_EQ(part.mask.empty(), !holes);
}

void expect_same(const Raster& a, const Raster& b) {
    expect_crop(a, b, {0, 0, b.rows, b.cols});
    EXPECT_EQ(a.type, b.type);
    EXPECT_EQ(a.geo, b.geo);
    EXPECT_EQ(a.unit, b.unit);
    EXPECT_EQ(a.scale, b.scale);
    EXPECT_EQ(a.offset, b.offset);
    EXPECT_EQ(a.band_names, b.band_names);
    EXPECT_EQ(a.metadata, b.metadata);
}

Status write_in_strips(const std::string& path, const Raster& raster, Holes holes,
                       const std::vector<std::int64_t>& heights, const WriteOptions& options = {}) {
    RELIEF_TRY(
        RasterWriter writer,
        RasterWriter::create(path, raster, static_cast<int>(raster.planes.size()), holes, options));
    std::int64_t row = 0;
    for (std::size_t k = 0; row < raster.rows; ++k) {
        const std::int64_t rows = std::min(heights[k % heights.size()], raster.rows - row);
        RELIEF_CHECK(writer.write(row, strip_of(raster, row, rows)));
        row += rows;
    }
    return writer.commit();
}

Raster in_full(const std::string& path) {
    auto raster = read_raster(path);
    EXPECT_TRUE(raster.ok()) << raster.error().text();
    return raster.ok() ? *std::move(raster) : Raster{};
}

struct Format {
    const char* name;
    SampleType type;
    std::size_t planes;
    std::vector<std::string> options;
};

const std::vector<Format> kFormats = {
    {"strips.tif", SampleType::Int16, 1, {"TILED=NO", "BLOCKYSIZE=7"}},
    {"tiles.tif", SampleType::Float32, 1, {"TILED=YES", "BLOCKXSIZE=64", "BLOCKYSIZE=48"}},
    {"bands.tif", SampleType::Float64, 3, {"TILED=YES", "BLOCKXSIZE=32", "BLOCKYSIZE=16"}},
    {"pixels.tif", SampleType::UInt16, 4, {"INTERLEAVE=PIXEL"}},
    {"default.tif", SampleType::Int32, 2, {}},
    {"a.png", SampleType::UInt16, 1, {}},
    {"a.asc", SampleType::Float32, 1, {}},
};

TEST_F(RasterStreamTest, WindowsAreCropsOfTheWholeRaster) {
    const std::vector<LatticeBox> windows = {{0, 0, 300, 260},   {0, 0, 1, 1},     {299, 259, 1, 1},
                                             {90, 0, 60, 260},   {13, 57, 100, 3}, {47, 63, 2, 2},
                                             {250, 100, 50, 160}};
    for (const Format& format : kFormats) {
        Raster raster = with_holes(samples(format.type, 300, 260, format.planes), 100);
        raster.nodata = 999;
        ASSERT_TRUE(
            write_raster(path(format.name), raster, {.creation_options = format.options}).ok());
        const auto reader = RasterReader::open(path(format.name));
        ASSERT_TRUE(reader.ok());
        EXPECT_EQ(reader->components(), static_cast<int>(format.planes));
        for (const LatticeBox& window : windows) {
            SCOPED_TRACE(format.name);
            const auto part = reader->read(window);
            ASSERT_TRUE(part.ok());
            expect_crop(*part, raster, window);
            EXPECT_EQ(part->type, reader->description().type);
            EXPECT_EQ(part->nodata, 999);
            if (!raster.geo.transform || std::string(format.name) == "a.png") continue;
            EXPECT_EQ((*part->geo.transform)[0], 1000 + 2 * static_cast<double>(window.col0));
            EXPECT_EQ((*part->geo.transform)[3], 3000 - 2 * static_cast<double>(window.row0));
        }
    }
}

TEST_F(RasterStreamTest, TheReaderDescribesWhatReadRasterReads) {
    Raster raster = samples(SampleType::Int16, 30, 20, 2);
    raster.nodata = -1;
    raster.geo.crs = "EPSG:32632";
    raster.unit = "m";
    raster.scale = 0.5;
    raster.offset = -100;
    raster.band_names = {"a", "b"};
    raster.metadata = {{"SURVEY", "2021"}};
    ASSERT_TRUE(write_raster(path("a.tif"), raster).ok());
    const Raster whole = in_full(path("a.tif"));
    const auto reader = RasterReader::open(path("a.tif"));
    ASSERT_TRUE(reader.ok());
    const Raster& about = reader->description();
    EXPECT_EQ(about.rows, 30);
    EXPECT_EQ(about.cols, 20);
    EXPECT_TRUE(about.planes.empty());
    EXPECT_TRUE(about.mask.empty());
    EXPECT_EQ(about.type, SampleType::Int16);
    EXPECT_EQ(about.nodata, -1.0);
    EXPECT_EQ(about.geo, whole.geo);
    EXPECT_EQ(about.geo.crs, "EPSG:32632");
    EXPECT_EQ(about.unit, "m");
    EXPECT_EQ(about.scale, 0.5);
    EXPECT_EQ(about.offset, -100);
    EXPECT_EQ(about.band_names, raster.band_names);
    EXPECT_EQ(about.metadata, raster.metadata);
}

TEST_F(RasterStreamTest, FourThreadsReadTheSameAsOne) {
    Raster raster = with_holes(samples(SampleType::Float32, 400, 300, 2), 200);
    ASSERT_TRUE(write_raster(path("a.tif"), raster).ok());
    const auto reader = RasterReader::open(path("a.tif"));
    ASSERT_TRUE(reader.ok());
    std::vector<std::thread> threads;
    for (std::int64_t t = 0; t < 4; ++t)
        threads.emplace_back([&, t] {
            for (std::int64_t k = 0; k < 12; ++k) {
                const LatticeBox window{(k * 61 + t * 97) % 300, (k * 37) % 200, 100, 100};
                const auto part = reader->read(window);
                ASSERT_TRUE(part.ok());
                expect_crop(*part, raster, window);
            }
        });
    for (std::thread& thread : threads) thread.join();
}

TEST_F(RasterStreamTest, ReaderErrorsSayWhatAndWhere) {
    EXPECT_EQ(RasterReader::open(path("none.tif")).error().code, ErrorCode::NotFound);
    std::ofstream(path("text.tif")) << "this is no raster";
    EXPECT_EQ(RasterReader::open(path("text.tif")).error().code, ErrorCode::BadInput);
    ASSERT_TRUE(write_raster(path("a.tif"), samples(SampleType::Int16, 40, 50)).ok());
    const auto reader = RasterReader::open(path("a.tif"));
    ASSERT_TRUE(reader.ok());
    constexpr std::int64_t huge = std::numeric_limits<std::int64_t>::max();
    for (const LatticeBox& box :
         {LatticeBox{-1, 0, 2, 2}, LatticeBox{39, 0, 2, 2}, LatticeBox{0, 50, 1, 1},
          LatticeBox{0, 0, 0, 1}, LatticeBox{1, 1, huge, 1}, LatticeBox{huge, 0, 1, 1}})
        EXPECT_EQ(reader->read(box).error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(reader->read({39, 0, 2, 2}).error().text(),
              path("a.tif") + ": the window 0,39,2,2 is not inside the 50 x 40 raster");
    EXPECT_EQ(reader->read({0, 0, 9, 9}, [](double) { return false; }).error().code,
              ErrorCode::Cancelled);

    std::ofstream(path("huge.vrt"))
        << "<VRTDataset rasterXSize='2147483647' rasterYSize='2147483647'>"
           "<VRTRasterBand dataType='Byte'/></VRTDataset>";
    const auto vast = RasterReader::open(path("huge.vrt"));
    ASSERT_TRUE(vast.ok());
    const auto corner = vast->read({2147483640, 2147483640, 7, 7});
    ASSERT_TRUE(corner.ok());
    EXPECT_EQ(corner->planes[0](6, 6), 0);
}

TEST_F(RasterStreamTest, ADamagedFileGivesWhatIsWholeAndRefusesTheRest) {
    Raster raster = samples(SampleType::Int32, 300, 300);
    ASSERT_TRUE(write_raster(path("a.tif"), raster,
                             {.creation_options = {"TILED=NO", "BLOCKYSIZE=10", "COMPRESS=NONE"}})
                    .ok());
    fs::resize_file(path("a.tif"), 200 * 300 * 4);
    const auto reader = RasterReader::open(path("a.tif"));
    ASSERT_TRUE(reader.ok());
    const auto good = reader->read({20, 0, 100, 300});
    ASSERT_TRUE(good.ok());
    expect_crop(*good, raster, {20, 0, 100, 300});
    const auto bad = reader->read({250, 0, 50, 300});
    ASSERT_FALSE(bad.ok());
    EXPECT_EQ(bad.error().code, ErrorCode::BadFile);
    EXPECT_EQ(bad.error().where, path("a.tif") + ", row 250");
    EXPECT_TRUE(reader->read({0, 0, 10, 10}).ok());
}

TEST_F(RasterStreamTest, AnyDamagedByteIsReadOrRefused) {
    ASSERT_TRUE(write_raster(path("a.tif"), samples(SampleType::UInt8, 40, 50)).ok());
    const Bytes bytes = *read_file(path("a.tif"));
    for (std::size_t k = 0; k < bytes.size(); k += 1 + bytes.size() / 300) {
        Bytes damaged = bytes;
        damaged[k] = static_cast<std::uint8_t>(damaged[k] ^ (1U << (k % 8)));
        std::ofstream(path("b.tif"), std::ios::binary)
            .write(reinterpret_cast<const char*>(damaged.data()),
                   static_cast<std::streamsize>(damaged.size()));
        const auto reader = RasterReader::open(path("b.tif"));
        if (!reader) continue;
        const Raster& about = reader->description();
        const std::int64_t rows = std::min<std::int64_t>(about.rows, 40);
        const std::int64_t cols = std::min<std::int64_t>(about.cols, 50);
        const auto part = reader->read({0, 0, rows, cols});
        EXPECT_TRUE(part.ok() || part.error().code == ErrorCode::BadFile) << part.error().text();
    }
}

TEST_F(RasterStreamTest, StripsMakeTheRasterThatWriteRasterMakes) {
    for (const Format& format : kFormats) {
        SCOPED_TRACE(format.name);
        Raster raster = with_holes(samples(format.type, 300, 260, format.planes), 300);
        raster.nodata = 999;
        raster.unit = "m";
        raster.scale = 0.5;
        raster.offset = -100;
        raster.geo.crs = "EPSG:32632";
        raster.metadata = {{"SURVEY", "2021"}};
        for (std::size_t k = 0; k < format.planes; ++k)
            raster.band_names.push_back("plane " + std::to_string(k));
        const WriteOptions options{.creation_options = format.options};
        const std::string once = std::string("once-") + format.name;
        ASSERT_TRUE(write_raster(path(once), raster, options).ok());
        const Status status =
            write_in_strips(path(format.name), raster, Holes::Possible, {1, 100, 37}, options);
        ASSERT_TRUE(status.ok()) << status.error().text();
        const Raster back = in_full(path(format.name));
        expect_same(back, in_full(path(once)));
        expect_crop(back, raster, {0, 0, 300, 260});
        EXPECT_EQ(back.nodata, 999);
    }
}

TEST_F(RasterStreamTest, EveryTypeKeepsItsRangeAndStaysOffNodata) {
    for (const SampleType type :
         {SampleType::UInt8, SampleType::UInt16, SampleType::Int16, SampleType::UInt32,
          SampleType::Int32, SampleType::Float32, SampleType::Float64}) {
        const auto [low, high] = sample_range(type);
        Raster raster = samples(type, 5, 4);
        raster.nodata = 7;
        raster.planes[0](0, 0) = low;
        raster.planes[0](1, 1) = high;
        raster.planes[0](2, 2) = 7;
        raster.planes[0](3, 3) = 2.5;
        raster.planes[0](4, 0) = kNaN;
        ASSERT_TRUE(write_in_strips(path("a.tif"), raster, Holes::None, {2}).ok());
        const Raster back = in_full(path("a.tif"));
        EXPECT_EQ(back.type, type);
        EXPECT_EQ(back.nodata, 7.0);
        for (std::int64_t r = 0; r < 5; ++r)
            for (std::int64_t c = 0; c < 4; ++c) {
                ASSERT_EQ(back.valid(r, c), r != 4 || c != 0);
                if (!back.valid(r, c)) continue;
                EXPECT_EQ(back.planes[0](r, c), stored_value(raster.planes[0](r, c), type, 7.0));
            }
    }
}

TEST_F(RasterStreamTest, HolesWithoutNodataBecomeNanOrAMaskBand) {
    // Strips of 8192 bytes and tiles: the mask has the blocks of the bands.
    for (const std::int64_t rows : {40, 300}) {
        for (const SampleType type : {SampleType::UInt8, SampleType::Int32, SampleType::Float32}) {
            const Raster raster = with_holes(samples(type, rows, 270, 2), rows);
            ASSERT_TRUE(write_in_strips(path("a.tif"), raster, Holes::Possible, {50}).ok());
            const Raster back = in_full(path("a.tif"));
            EXPECT_EQ(back.nodata.has_value(), !is_integer(type));
            EXPECT_TRUE(is_integer(type) || std::isnan(*back.nodata));
            expect_crop(back, raster, {0, 0, rows, 270});

            const Raster whole = samples(type, rows, 270, 2);
            ASSERT_TRUE(write_in_strips(path("b.tif"), whole, Holes::Possible, {50}).ok());
            expect_crop(in_full(path("b.tif")), whole, {0, 0, rows, 270});
        }
    }
    EXPECT_EQ(files(), (Names{"a.tif", "b.tif"}));
}

TEST_F(RasterStreamTest, MisplacedStripsAreRefused) {
    const Raster raster = samples(SampleType::Int16, 20, 10);
    for (const char* name : {"a.tif", "a.png"}) {
        auto writer = RasterWriter::create(path(name), raster, 1, Holes::None);
        ASSERT_TRUE(writer.ok());
        const auto refused = [&](std::int64_t row, const Raster& strip) {
            const Status status = writer->write(row, strip);
            EXPECT_FALSE(status.ok());
            EXPECT_EQ(status.error().code, ErrorCode::InvalidArgument);
            return status.error().message;
        };
        EXPECT_EQ(refused(1, strip_of(raster, 1, 2)),
                  "strips go from top to bottom: row 0 comes next, not row 1");
        ASSERT_TRUE(writer->write(0, strip_of(raster, 0, 15)).ok());
        EXPECT_EQ(refused(0, strip_of(raster, 0, 5)),
                  "strips go from top to bottom: row 15 comes next, not row 0");
        EXPECT_EQ(refused(15, strip_of(raster, 0, 6)), "6 rows do not fit: 5 are left of 20");
        EXPECT_EQ(refused(15, samples(SampleType::Int16, 2, 9)),
                  "a strip has 10 columns and 1 planes here, not 9 and 1");
        EXPECT_EQ(refused(15, samples(SampleType::Int16, 2, 10, 2)),
                  "a strip has 10 columns and 1 planes here, not 10 and 2");
        Raster wrong = samples(SampleType::Int16, 2, 10);
        wrong.rows = 3;
        EXPECT_EQ(refused(15, wrong), "the planes have another size than the raster");
        Raster hole = samples(SampleType::Int16, 3, 10);
        hole.planes[0](1, 4) = kNaN;
        EXPECT_EQ(refused(15, hole),
                  "row 16 has a hole; say when creating the file that holes are possible, or give "
                  "a nodata value");
        EXPECT_EQ(writer->commit().error().message, "only 15 of 20 rows are written");
        ASSERT_TRUE(writer->write(15, strip_of(raster, 15, 5)).ok());
        ASSERT_TRUE(writer->commit().ok());
        expect_crop(in_full(path(name)), raster, {0, 0, 20, 10});
    }
}

TEST_F(RasterStreamTest, ImpossibleOutputsAreRefusedBeforeTheFirstStrip) {
    const auto error = [&](const std::string& name, const Raster& about, int components,
                           const WriteOptions& options = {}) {
        const auto writer = RasterWriter::create(name, about, components, Holes::None, options);
        return writer.ok() ? Error{} : writer.error();
    };
    const Raster raster = samples(SampleType::Int16, 20, 10);
    for (const char* name : {"no/a.tif", "no/a.png"})
        EXPECT_EQ(error(path(name), raster, 1).message,
                  "there is no directory '" + path("no") + "'; create it first");
    EXPECT_EQ(error(path("a.tif"), raster, 5).message, "a raster has 1 to 4 planes");
    EXPECT_EQ(error(path("a.tif"), raster, -1).message, "a raster has 1 to 4 planes");
    EXPECT_EQ(error(path("a.tif"), Raster{}, 1).message,
              "a raster without samples can not be written");
    EXPECT_EQ(error(path("a.nonsense"), raster, 1).code, ErrorCode::InvalidArgument);
    EXPECT_EQ(error(path("a.tif"), raster, 1, {.creation_options = {"COMPRESS"}}).message,
              "the creation option 'COMPRESS' is not NAME=VALUE");
    EXPECT_EQ(files(), Names{});
}

TEST_F(RasterStreamTest, WithoutACommitTheOldFileStays) {
    const Raster raster = samples(SampleType::Float32, 600, 300);
    for (const char* name : {"a.tif", "a.asc"}) {
        ASSERT_TRUE(write_raster(path(name), samples(SampleType::Float32, 1, 1)).ok());
        {
            auto writer = RasterWriter::create(path(name), raster, 1, Holes::None);
            ASSERT_TRUE(writer.ok());
            RasterWriter moved = *std::move(writer);
            ASSERT_TRUE(moved.write(0, strip_of(raster, 0, 300)).ok());
        }
        EXPECT_EQ(in_full(path(name)).cols, 1);
        const Status cancelled =
            write_in_strips(path(name), raster, Holes::None, {100},
                            {.progress = [](double fraction) { return fraction < 0.4; }});
        ASSERT_FALSE(cancelled.ok());
        EXPECT_EQ(cancelled.error().code, ErrorCode::Cancelled);
        const FileSizeLimit limit(20000);
        const Status full =
            write_in_strips(path(name), raster, Holes::None, {100}, {.creation_options = {}});
        ASSERT_FALSE(full.ok()) << name;
        EXPECT_EQ(full.error().code, ErrorCode::CannotWrite);
        EXPECT_EQ(in_full(path(name)).cols, 1);
    }
    EXPECT_EQ(files(), (Names{"a.asc", "a.tif"}));
}

TEST_F(RasterStreamTest, SameBytesForAnyThreadsAndStrips) {
    const Raster raster = with_holes(samples(SampleType::Int16, 700, 530, 2), 700);
    set_thread_count(1);
    ASSERT_TRUE(write_in_strips(path("a.tif"), raster, Holes::Possible, {700}).ok());
    set_thread_count(4);
    ASSERT_TRUE(write_in_strips(path("b.tif"), raster, Holes::Possible, {3, 300}).ok());
    set_thread_count(0);
    EXPECT_EQ(*read_file(path("a.tif")), *read_file(path("b.tif")));
}

TEST_F(RasterStreamTest, VirtualFilesAreWrittenInPlace) {
    const Raster raster = samples(SampleType::Int16, 20, 10);
    ASSERT_TRUE(write_in_strips("/vsimem/strips.tif", raster, Holes::None, {6}).ok());
    expect_crop(in_full("/vsimem/strips.tif"), raster, {0, 0, 20, 10});
    ASSERT_TRUE(RasterWriter::create("/vsimem/strips.tif", raster, 1, Holes::None).ok());
    EXPECT_FALSE(read_raster("/vsimem/strips.tif").ok());
}

/// A number after `name` in a file of /proc/self; 0 if there is none.
std::uint64_t process_number(const std::string& file, const std::string& name) {
    std::ifstream lines("/proc/self/" + file);
    for (std::string line; std::getline(lines, line);)
        if (line.starts_with(name)) return std::stoull(line.substr(name.size()));
    return 0;
}

/// Rows of whole numbers that compress to almost nothing.
Raster ramp(std::int64_t row, std::int64_t rows, std::int64_t cols) {
    Raster strip;
    strip.rows = rows;
    strip.cols = cols;
    strip.planes.emplace_back(rows, cols);
    for (std::int64_t r = 0; r < rows; ++r)
        for (std::int64_t c = 0; c < cols; ++c)
            strip.planes[0](r, c) = static_cast<double>((row + r) % 1000 + c % 64);
    return strip;
}

Status write_ramp(const std::string& path, const Raster& about, std::int64_t height,
                  const std::vector<std::string>& creation_options) {
    RELIEF_TRY(RasterWriter writer, RasterWriter::create(path, about, 1, Holes::None,
                                                         {.creation_options = creation_options}));
    for (std::int64_t row = 0; row < about.rows; row += height)
        RELIEF_CHECK(writer.write(row, ramp(row, std::min(height, about.rows - row), about.cols)));
    return writer.commit();
}

/// Reads all strips; the number of samples that are not those of the ramp.
std::int64_t differences(const RasterReader& reader, std::int64_t height) {
    std::int64_t count = 0;
    const Raster& about = reader.description();
    for (std::int64_t row = 0; row < about.rows; row += height) {
        const std::int64_t rows = std::min(height, about.rows - row);
        const auto strip = reader.read({row, 0, rows, about.cols});
        if (!strip || !strip->mask.empty()) return about.rows * about.cols;
        for (std::int64_t r = 0; r < rows; ++r)
            for (std::int64_t c = 0; c < about.cols; ++c)
                count += strip->planes[0](r, c) != static_cast<double>((row + r) % 1000 + c % 64);
    }
    return count;
}

TEST_F(RasterStreamTest, StripsReadEachBlockOnceHoweverWideTheRaster) {
    if (!fs::exists("/proc/self/io")) GTEST_SKIP() << "no /proc/self/io";
    // The one row of blocks takes 83 MiB, more than GDAL's cache has without the reader.
    Raster about;
    about.rows = 1000;
    about.cols = 10500;
    about.type = SampleType::Float64;
    about.nodata = -1;
    ASSERT_TRUE(write_ramp(path("a.tif"), about, 512,
                           {"COMPRESS=NONE", "TILED=YES", "BLOCKXSIZE=512", "BLOCKYSIZE=1008"})
                    .ok());
    const auto reader = RasterReader::open(path("a.tif"));
    ASSERT_TRUE(reader.ok());
    const std::uint64_t before = process_number("io", "rchar:");
    EXPECT_EQ(differences(*reader, 300), 0);
    const std::uint64_t read = process_number("io", "rchar:") - before;
    const std::uint64_t size = fs::file_size(path("a.tif"));
    // A hundredth for directories and for what is read ahead.
    EXPECT_LE(read, size + size / 100);
}

TEST_F(RasterStreamTest, MemoryDoesNotGrowWithTheRows) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "sanitizers keep memory of their own";
#endif
    if (process_number("status", "VmHWM:") == 0) GTEST_SKIP() << "no /proc/self/status";
    std::ofstream("/proc/self/clear_refs") << "5";  // the peak so far is that of other tests
    const std::uint64_t before = process_number("status", "VmHWM:");
    Raster about;
    about.rows = 60000;
    about.cols = 2000;
    about.type = SampleType::Int16;
    about.nodata = -1;
    ASSERT_TRUE(write_ramp(path("a.tif"), about, 512, {"ZLEVEL=1"}).ok());
    const std::uint64_t written = process_number("status", "VmHWM:");
    const auto reader = RasterReader::open(path("a.tif"));
    ASSERT_TRUE(reader.ok());
    EXPECT_EQ(differences(*reader, 512), 0);
    const std::uint64_t read = process_number("status", "VmHWM:");
    // Of 229 MiB in the file's type and 916 MiB in double: two strips of 8 MiB and a row of blocks;
    // and then the cache of 64 MiB.
    constexpr std::uint64_t MiB = 1024;
    EXPECT_LE(written, before + 40 * MiB);
    EXPECT_LE(read, before + 120 * MiB);
}

}  // namespace
}  // namespace relief::io
