#include <benchmark/benchmark.h>

#include <cmath>
#include <random>

#include "codec/embedded_coder.h"
#include "hills.h"
#include "relief/codec/raster_codec.h"
#include "transform_bench.h"

/// MB/s of the coefficients as float32, one thread, three bands of 256 x 256: a level of a 512 x
/// 512 tile.
namespace relief::codec {
namespace {

constexpr std::int64_t kSide = 256;

/// Laplacian values whose scale changes smoothly from place to place, as details of terrain do.
struct LaplacianLevel {
    std::vector<Grid<std::int32_t>> grids;
    std::vector<StreamBand> bands;

    explicit LaplacianLevel(double scale) {
        std::mt19937 engine(1);
        for (int k = 0; k < 3; ++k) {
            Grid<std::int32_t>& grid = grids.emplace_back(kSide, kSide);
            for (std::int64_t r = 0; r < kSide; ++r)
                for (std::int64_t c = 0; c < kSide; ++c) {
                    const double u = (engine() + 0.5) / 4294967296.0 - 0.5;
                    const double here = std::sin(0.04 * static_cast<double>(r)) *
                                        std::cos(0.03 * static_cast<double>(c));
                    const double size =
                        -scale * std::exp(1.5 * here) * std::log(1 - 2 * std::abs(u));
                    grid(r, c) =
                        static_cast<std::int32_t>(std::copysign(std::floor(size + 0.4), u));
                }
            bands.push_back({1, k + 1, {0, 0, kSide, kSide}, grid.view()});
        }
    }
};

constexpr double kSamples = 3 * kSide * kSide;

void report(benchmark::State& state, std::size_t bytes) {
    state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(4 * kSamples));
    state.counters["bits/sample"] = 8 * static_cast<double>(bytes) / kSamples;
}

/// The argument is the scale in thousandths of a step: about 0.5, 1 and 3 bits a sample.
void encode_bands(benchmark::State& state) {
    const LaplacianLevel level(static_cast<double>(state.range(0)) / 1000);
    std::size_t bytes = 0;
    for (auto _ : state) bytes = encode_stream(level.bands, {})->bytes.size();
    report(state, bytes);
}

void decode_bands(benchmark::State& state) {
    LaplacianLevel level(static_cast<double>(state.range(0)) / 1000);
    const EmbeddedStream stream = *encode_stream(level.bands, {});
    const StreamPart whole{stream.bytes, stream.planes, 3 * stream.planes};
    for (auto _ : state)
        if (!decode_stream(whole, level.bands, {}).ok()) state.SkipWithError("does not decode");
    report(state, stream.bytes.size());
}

/// Least squares on a fixed share, a root mean square error, a guaranteed error: all threads, wall
/// time.
void encode_file(benchmark::State& state, Goal goal) {
    const Raster raster = bench::hills(1024);
    EncodeOptions options;
    options.goal = goal;
    std::size_t bytes = 0;
    bench::measure(state, raster.planes[0], 0, [&] {
        const auto file = encode_raster(raster, options);
        if (file.ok()) bytes = file->bytes.size();
    });
    state.counters["bits/sample"] =
        8 * static_cast<double>(bytes) / static_cast<double>(raster.planes[0].count());
}

BENCHMARK_CAPTURE(encode_file, keep_13, Goal{Goal::Kind::Keep, 13})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(encode_file, rms_error_2, Goal{Goal::Kind::RmsError, 2})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(encode_file, max_error_1, Goal{Goal::Kind::MaxError, 1})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(encode_bands)->Arg(150)->Arg(300)->Arg(1700)->Unit(benchmark::kMillisecond);
BENCHMARK(decode_bands)->Arg(150)->Arg(300)->Arg(1700)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace relief::codec
