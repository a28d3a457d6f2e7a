#include "relief/multires/cubic.h"

#include <vector>

#include "relief/multires/cubic_window.h"
#include "relief/spline/cubic_surface.h"
#include "transform_bench.h"

/// Scheme `cubic`, all levels, into kept buffers; windows of it; and its surfaces.
namespace relief::multires {
namespace {

SchemeSpec spec_of(bool exact) {
    return {.id = SchemeId::Cubic, .exact = exact};
}

template <class T>
Pyramid<T> pyramid_of(const Grid<T>& samples, bool exact) {
    auto pyramid =
        Pyramid<T>::allocate(*cubic::layout(spec_of(exact), samples.rows(), samples.cols(), 1));
    cubic::analyse<T>(samples.view(), 0, pyramid);
    return pyramid;
}

template <class T>
void analysis(benchmark::State& state) {
    const auto samples = bench::terrain<T>(state.range(0));
    auto pyramid = pyramid_of(samples, state.range(1) != 0);
    Workspace<T> workspace;
    bench::measure(state, samples, state.range(2),
                   [&] { cubic::analyse<T>(samples.view(), 0, pyramid, workspace); });
}

template <class T>
void synthesis(benchmark::State& state) {
    auto samples = bench::terrain<T>(state.range(0));
    const auto pyramid = pyramid_of(samples, state.range(1) != 0);
    Workspace<T> workspace;
    bench::measure(state, samples, state.range(2),
                   [&] { cubic::coefficients<T>(pyramid, 0, 0, samples.view(), workspace); });
}

template <class T>
void transposition(benchmark::State& state) {
    const auto samples = bench::terrain<T>(state.range(0));
    auto pyramid = pyramid_of(samples, state.range(1) != 0);
    bench::measure(state, samples, state.range(2),
                   [&] { cubic::adjoint<T>(samples.view(), 0, pyramid); });
}

void two_threads(benchmark::State& state) {
    const auto samples = bench::terrain<float>(4096);
    auto pyramid = pyramid_of(samples, false);
    Workspace<float> workspace;
    bench::measure_two_threads(
        state, [&] { cubic::analyse<float>(samples.view(), 0, pyramid, workspace); });
}

void peak_memory(benchmark::State& state) {
    bench::measure_peak(state, [&] {
        const auto samples = bench::terrain<float>(4096);
        const auto pyramid = pyramid_of(samples, false);
        return sizeof(float) * double(samples.count() + pyramid.layout.coefficients());
    });
}

/// A window of so many samples a side in the middle of 4096 x 4096, per sample of the window.
void window_synthesis(benchmark::State& state) {
    const auto samples = bench::terrain<float>(4096);
    const auto pyramid = pyramid_of(samples, false);
    const std::int64_t side = state.range(0);
    const LatticeBox window{2048 - side / 2, 2048 - side / 2, side, side};
    const auto boxes = cubic::needed_boxes(pyramid.layout, 0, window);
    std::vector<GridView<const float>> parts;
    for (std::size_t k = 0; k < boxes.size(); ++k) {
        const GridView<const float> band = pyramid.bands[k][0].view();
        parts.emplace_back(band.row(boxes[k].row0) + boxes[k].col0, boxes[k].rows, boxes[k].cols,
                           band.stride);
    }
    const Grid<float> reference(side, side, 0.0F);
    bench::measure(state, reference, 1, [&] {
        benchmark::DoNotOptimize(
            cubic::synthesise_window<float>(pyramid.layout, 0, window, parts).ok());
    });
}

template <class T>
void surface_coefficients(benchmark::State& state) {
    const auto values = bench::terrain<T>(state.range(0));
    bench::measure(state, values, 1, [&] {
        benchmark::DoNotOptimize(spline::CubicSurface<T>::create(values.view()).ok());
    });
}

/// Values at scattered points of a 1024 x 1024 surface, one thread.
template <class T>
void surface_points(benchmark::State& state) {
    set_thread_count(1);
    const auto values = bench::terrain<T>(1024);
    const auto surface = *spline::CubicSurface<T>::create(values.view());
    std::vector<T> i(1 << 18), j(1 << 18), value(1 << 18);
    std::uint32_t random = 1;
    const auto draw = [&] {
        random = random * 1664525U + 1013904223U;
        return static_cast<T>(random) * T(1023.0 / 4294967296.0);
    };
    for (T& x : i) x = draw();
    for (T& x : j) x = draw();
    for (auto _ : state) {
        benchmark::DoNotOptimize(surface.evaluate(i, j, 0, {value}).ok());
        benchmark::ClobberMemory();
    }
    set_thread_count(0);
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(i.size()));
}

void cases(benchmark::internal::Benchmark* b) {
    b->ArgNames({"side", "exact", "threads"})
        ->ArgsProduct({{512, 1024, 2048, 4096, 8192}, {0}, {1, 2}})
        ->Args({4096, 1, 1})
        ->UseRealTime();
}

BENCHMARK(analysis<float>)->Name("cubic/analysis/float")->Apply(cases);
BENCHMARK(analysis<double>)->Name("cubic/analysis/double")->Apply(cases);
BENCHMARK(synthesis<float>)->Name("cubic/synthesis/float")->Apply(cases);
BENCHMARK(synthesis<double>)->Name("cubic/synthesis/double")->Apply(cases);
BENCHMARK(transposition<float>)->Name("cubic/adjoint/float")->Apply(cases);
BENCHMARK(two_threads)->Name("cubic/two_threads")->UseRealTime();
BENCHMARK(peak_memory)->Name("cubic/peak_memory")->Iterations(1);
BENCHMARK(window_synthesis)->Name("cubic/window")->ArgName("side")->Arg(64)->Arg(256)->Arg(512);
BENCHMARK(surface_coefficients<float>)->Name("cubic/surface/float")->ArgName("side")->Arg(4096);
BENCHMARK(surface_points<float>)->Name("cubic/surface/points/float");
BENCHMARK(surface_points<double>)->Name("cubic/surface/points/double");

}  // namespace
}  // namespace relief::multires
