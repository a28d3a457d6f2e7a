#include <benchmark/benchmark.h>
#include <cpl_conv.h>
#include <cpl_vsi.h>
#include <gdal.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "hills.h"
#include "relief/codec/raster_codec.h"
#include "relief/core/parallel.h"
#include "relief/io/file.h"
#include "transform_bench.h"

/// What reading through GDAL costs, in times of the library's own call: of one thread, alternately,
/// the best of each.
namespace relief {
namespace {

constexpr std::int64_t kSide = 2048;
constexpr const char* kPath = "/vsimem/hills.relief";

/// A file of the fast profile, whose decoding leaves the least room for other costs.
class OpenBoth {
  public:
    OpenBoth() {
        CPLSetConfigOption("GDAL_DRIVER_PATH", RELIEF_GDAL_DRIVER_DIR);
        CPLSetConfigOption("GDAL_NUM_THREADS", "1");
        GDALAllRegister();
        codec::EncodeOptions options;
        options.goal = {codec::Goal::Kind::MaxError, 1};
        options.profile = codec::Profile::Fast;
        const auto encoded = codec::encode_raster(bench::hills(kSide), options);
        if (!encoded.ok() || !io::write_file_atomically(kPath, encoded->bytes).ok()) return;
        auto opened = codec::RasterFile::open(encoded->bytes);
        if (opened.ok()) file_.emplace(*std::move(opened));
        dataset_ = GDALOpen(kPath, GA_ReadOnly);
        set_thread_count(1);
    }
    OpenBoth(const OpenBoth&) = delete;
    OpenBoth& operator=(const OpenBoth&) = delete;
    ~OpenBoth() {
        set_thread_count(0);
        if (dataset_) GDALClose(dataset_);
        VSIUnlink(kPath);
    }

    [[nodiscard]] bool ok() const { return file_ && dataset_; }
    [[nodiscard]] const codec::RasterFile& file() const { return *file_; }
    [[nodiscard]] GDALRasterBandH band(int level) const {
        GDALRasterBandH finest = GDALGetRasterBand(dataset_, 1);
        return level == 0 ? finest : GDALGetOverview(finest, level - 1);
    }

  private:
    std::optional<codec::RasterFile> file_;
    GDALDatasetH dataset_ = nullptr;
};

/// `window` is moved on by a row each time, so that nothing is given again.
void read_window(benchmark::State& state, int level, LatticeBox window) {
    const OpenBoth both;
    if (!both.ok()) return state.SkipWithError("the file can not be opened");
    GDALRasterBandH band = both.band(level);
    std::vector<float> pixels(static_cast<std::size_t>(window.count()));
    const int width = static_cast<int>(window.cols);
    const int height = static_cast<int>(window.rows);
    bool read = true;
    double library = std::numeric_limits<double>::infinity();
    double through_gdal = library;
    for (auto _ : state) {
        window.row0 = (window.row0 + 1) % (both.file().box(level).rows - window.rows + 1);
        library = std::min(library, bench::time_of(CLOCK_THREAD_CPUTIME_ID, [&] {
                               read = both.file().decode_window(level, window).ok() && read;
                           }));
        GDALFlushRasterCache(band);
        through_gdal = std::min(
            through_gdal, bench::time_of(CLOCK_THREAD_CPUTIME_ID, [&] {
                read = GDALRasterIO(band, GF_Read, static_cast<int>(window.col0),
                                    static_cast<int>(window.row0), width, height, pixels.data(),
                                    width, height, GDT_Float32, 0, 0) == CE_None &&
                       read;
            }));
    }
    if (!read) state.SkipWithError("the file can not be read");
    state.counters["times_library"] = through_gdal / library;
}

BENCHMARK_CAPTURE(read_window, side_1000, 0, LatticeBox{300, 300, 1000, 1000})
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_window, overview_1, 1, LatticeBox{0, 0, 1000, 1024})
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_window, overview_3, 3, LatticeBox{0, 0, 250, 256})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace relief
