#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "relief/core/parallel.h"
#include "relief/multires/fvs.h"
#include "relief/multires/fvs_certificate.h"
#include "relief/multires/fvs_grid_transform.h"
#include "relief/spline/fvs_surface.h"
#include "transform_bench.h"

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

/// Scheme `fvs` and the values-only tools. Arguments: side, threads.
namespace relief::multires::fvs {
namespace {

template <class T>
Pyramid<T> pyramid_of(const Grid<T>& samples) {
    SchemeSpec spec;
    spec.id = SchemeId::Fvs;
    auto pyramid = Pyramid<T>::allocate(*layout(spec, samples.rows(), samples.cols(), 1));
    analyse<T>(samples.view(), 0, pyramid);
    return pyramid;
}

template <class T>
void analysis(benchmark::State& state) {
    const auto samples = bench::terrain<T>(state.range(0));
    auto pyramid = pyramid_of(samples);
    bench::measure(state, samples, state.range(1), [&] { analyse<T>(samples.view(), 0, pyramid); });
}

template <class T>
void synthesis(benchmark::State& state) {
    const auto samples = bench::terrain<T>(state.range(0));
    const auto pyramid = pyramid_of(samples);
    bench::measure(state, samples, state.range(1), [&] { (void)coefficients(pyramid, 0, 0); });
}

/// Values of the next finer lattice, in nanoseconds a fine sample.
template <class T>
void value_prediction(benchmark::State& state) {
    auto fine = bench::terrain<T>(state.range(0));
    const std::int64_t n = coarser(fine.rows() - 1) + 1;
    const auto coarse = bench::terrain<T>(n);
    bench::measure(state, fine.clone(), state.range(1),
                   [&] { predict_values<T>(coarse.view(), fine.view()); });
}

/// Arguments: side, refinements.
void certificate(benchmark::State& state) {
    const auto original = bench::terrain<float>(state.range(0));
    const Grid<float> decoded(original.rows(), original.cols(), 0.0F);
    bench::measure(state, original, 1, [&] {
        (void)certify<float>(original.view(), decoded.view(), static_cast<int>(state.range(1)));
    });
}

BENCHMARK(analysis<float>)->Name("fvs/analysis/float")->Args({2048, 1})->Args({2048, 2});
BENCHMARK(synthesis<float>)->Name("fvs/synthesis/float")->Args({2048, 1})->Args({2048, 2});
BENCHMARK(value_prediction<float>)->Name("fvs/value_prediction/float")->Args({2048, 1});
BENCHMARK(certificate)->Name("fvs/certificate/float")->ArgsProduct({{1024}, {0, 1, 2}});

}  // namespace
}  // namespace relief::multires::fvs
