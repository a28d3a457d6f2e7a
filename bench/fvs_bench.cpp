#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "relief/core/parallel.h"
#include "relief/spline/fvs_surface.h"

// All on one thread: rates are per thread.
namespace relief::spline {
namespace {

constexpr std::int64_t kSide = 1024;
constexpr std::size_t kPoints = 1 << 18;

template <class T>
Grid<T> noise(std::int64_t rows, std::int64_t cols) {
    std::mt19937 engine(1);
    std::uniform_real_distribution<T> draw(-100, 100);
    Grid<T> grid(rows, cols);
    for (std::int64_t r = 0; r < rows; ++r)
        for (std::int64_t c = 0; c < cols; ++c) grid(r, c) = draw(engine);
    return grid;
}

template <class T>
std::vector<T> random_points(unsigned seed) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<T> draw(0, kSide - 1);
    std::vector<T> points(kPoints);
    for (T& x : points) x = draw(engine);
    return points;
}

/// Nodal data of a raster.
template <class T>
void fvs_estimate(benchmark::State& state) {
    set_thread_count(1);
    const Grid<T> values = noise<T>(kSide, kSide);
    const auto part = RasterPart<T>::whole(values.view());
    for (auto _ : state)
        benchmark::DoNotOptimize(estimate_fvs_grid(part, {0, 0, kSide, kSide}).ok());
    state.SetItemsProcessed(state.iterations() * values.count());
}
BENCHMARK_TEMPLATE(fvs_estimate, float);
BENCHMARK_TEMPLATE(fvs_estimate, double);

/// Argument: derivatives.
template <class T>
void fvs_random_point_jets(benchmark::State& state) {
    set_thread_count(1);
    const Grid<T> values = noise<T>(kSide, kSide);
    const auto part = RasterPart<T>::whole(values.view());
    const auto surface = std::move(FvsSurface<T>::create(part, {0, 0, kSide, kSide})).value();
    const std::vector<T> i = random_points<T>(2);
    const std::vector<T> j = random_points<T>(3);
    std::vector<T> results[6];
    for (auto& r : results) r.resize(kPoints);
    const JetSpans<T> out{results[0], results[1], results[2], results[3], results[4], results[5]};
    for (auto _ : state) {
        benchmark::DoNotOptimize(
            surface.evaluate(i, j, static_cast<int>(state.range(0)), out).ok());
        benchmark::ClobberMemory();
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kPoints));
}
BENCHMARK_TEMPLATE(fvs_random_point_jets, float)->ArgName("derivatives")->DenseRange(0, 2);
BENCHMARK_TEMPLATE(fvs_random_point_jets, double)->ArgName("derivatives")->DenseRange(0, 2);

/// From samples to a finer raster. Argument: step in hundredths of a sample.
template <class T>
void fvs_resample(benchmark::State& state) {
    set_thread_count(1);
    const Grid<T> values = noise<T>(kSide, kSide);
    const auto part = RasterPart<T>::whole(values.view());
    const double step = static_cast<double>(state.range(0)) / 100;
    const auto side = static_cast<std::int64_t>((kSide - 1) / step) + 1;
    Grid<T> out(side, side);
    for (auto _ : state) {
        benchmark::DoNotOptimize(FvsSurface<T>::resample(part, 0, step, 0, step, out.view()).ok());
        benchmark::ClobberMemory();
    }
    state.SetItemsProcessed(state.iterations() * out.count());
}
BENCHMARK_TEMPLATE(fvs_resample, float)->ArgName("step")->Arg(25)->Arg(37)->Arg(50)->Arg(99);
BENCHMARK_TEMPLATE(fvs_resample, double)->ArgName("step")->Arg(37)->Arg(50);

}  // namespace
}  // namespace relief::spline
