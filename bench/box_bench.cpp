#include <benchmark/benchmark.h>

#include <cstring>
#include <random>

#include "relief/core/parallel.h"
#include "relief/multires/box.h"

/// Scheme `box`, all levels, into kept buffers; memcpy of the same raster is the yardstick.
/// Arguments: side, order, threads. Counters: nanoseconds a sample of wall time and of CPU time.
namespace relief::multires {
namespace {

template <class T>
Grid<T> raster(std::int64_t side) {
    std::mt19937 engine(1);
    std::uniform_real_distribution<float> draw(0, 1000);
    Grid<T> grid(side, side);
    for (std::int64_t i = 0; i < side; ++i)
        for (std::int64_t j = 0; j < side; ++j) grid(i, j) = T(draw(engine));
    return grid;
}

template <class T>
Pyramid<T> pyramid_of(const Grid<T>& samples, int order) {
    const SchemeSpec spec{.order = order};
    auto pyramid =
        Pyramid<T>::allocate(box::layout(spec, samples.rows(), samples.cols(), 1).value());
    box::analyse<T>(samples.view(), 0, pyramid);
    return pyramid;
}

void report(benchmark::State& state, std::int64_t samples) {
    state.counters["ns/sample"] =
        benchmark::Counter(double(samples) * 1e-9, benchmark::Counter::kIsIterationInvariantRate |
                                                       benchmark::Counter::kInvert);
}

template <class T>
void copying(benchmark::State& state) {
    const auto from = raster<T>(state.range(0));
    auto to = from.clone();
    for (auto _ : state) {
        std::memcpy(to.row(0), from.row(0), std::size_t(from.rows() * from.stride()) * sizeof(T));
        benchmark::ClobberMemory();
    }
    report(state, from.count());
}

template <class T>
void analysis(benchmark::State& state) {
    const auto samples = raster<T>(state.range(0));
    auto pyramid = pyramid_of(samples, int(state.range(1)));
    set_thread_count(int(state.range(2)));
    box::Workspace<T> workspace;
    for (auto _ : state) {
        box::analyse<T>(samples.view(), 0, pyramid, workspace);
        benchmark::ClobberMemory();
    }
    set_thread_count(0);
    report(state, samples.count());
}

template <class T>
void synthesis(benchmark::State& state) {
    auto samples = raster<T>(state.range(0));
    const auto pyramid = pyramid_of(samples, int(state.range(1)));
    set_thread_count(int(state.range(2)));
    box::Workspace<T> workspace;
    for (auto _ : state) {
        box::coefficients<T>(pyramid, 0, 0, samples.view(), workspace);
        benchmark::ClobberMemory();
    }
    set_thread_count(0);
    report(state, samples.count());
}

template <class T>
void transposition(benchmark::State& state) {
    const auto samples = raster<T>(state.range(0));
    auto pyramid = pyramid_of(samples, int(state.range(1)));
    set_thread_count(int(state.range(2)));
    for (auto _ : state) {
        box::adjoint<T>(samples.view(), 0, pyramid);
        benchmark::ClobberMemory();
    }
    set_thread_count(0);
    report(state, samples.count());
}

void sizes(benchmark::internal::Benchmark* b) {
    b->ArgNames({"side"})->RangeMultiplier(2)->Range(512, 8192)->UseRealTime();
}
void sizes_orders_threads(benchmark::internal::Benchmark* b) {
    b->ArgNames({"side", "order", "threads"})
        ->ArgsProduct({{512, 1024, 2048, 4096, 8192}, {1, 2}, {1, 2}})
        ->UseRealTime()
        ->MeasureProcessCPUTime();
}

BENCHMARK(copying<float>)->Name("box/memcpy/float")->Apply(sizes);
BENCHMARK(copying<double>)->Name("box/memcpy/double")->Apply(sizes);
BENCHMARK(analysis<float>)->Name("box/analysis/float")->Apply(sizes_orders_threads);
BENCHMARK(analysis<double>)->Name("box/analysis/double")->Apply(sizes_orders_threads);
BENCHMARK(synthesis<float>)->Name("box/synthesis/float")->Apply(sizes_orders_threads);
BENCHMARK(synthesis<double>)->Name("box/synthesis/double")->Apply(sizes_orders_threads);
BENCHMARK(transposition<float>)->Name("box/adjoint/float")->Apply(sizes_orders_threads);

}  // namespace
}  // namespace relief::multires
