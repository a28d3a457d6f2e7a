#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <limits>
#include <random>

#include "relief/core/parallel.h"
#include "relief/multires/box.h"

/// Scheme `box`, all levels, into kept buffers; memcpy of the same raster is the yardstick.
/// The CPU column is that of the whole process.
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

double nanoseconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start)
        .count();
}

template <class T>
void copy(const Grid<T>& from, Grid<T>& to) {
    std::memcpy(to.row(0), from.row(0), std::size_t(from.rows() * from.stride()) * sizeof(T));
    benchmark::ClobberMemory();
}

/// Best of some, measured beside each benchmark because other work on the machine changes both.
template <class T>
double copy_nanoseconds(const Grid<T>& samples) {
    auto to = samples.clone();
    double best = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 7; ++k) {
        const auto start = std::chrono::steady_clock::now();
        copy(samples, to);
        best = std::min(best, nanoseconds_since(start));
    }
    return best;
}

/// Runs `body` and reports wall nanoseconds a sample, the best run's too, and the best run over
/// memcpy's.
template <class T, class Body>
void measure(benchmark::State& state, const Grid<T>& samples, Body body) {
    const double reference = copy_nanoseconds(samples);
    double total = 0;
    double best = std::numeric_limits<double>::infinity();
    for (auto _ : state) {
        const auto start = std::chrono::steady_clock::now();
        body();
        benchmark::ClobberMemory();
        const double spent = nanoseconds_since(start);
        total += spent;
        best = std::min(best, spent);
    }
    const auto count = double(samples.count());
    state.counters["ns/sample"] = total / double(state.iterations()) / count;
    state.counters["best"] = best / count;
    state.counters["memcpys"] = best / reference;
}

template <class T>
void copying(benchmark::State& state) {
    const auto from = raster<T>(state.range(0));
    auto to = from.clone();
    measure(state, from, [&] { copy(from, to); });
}

template <class T>
void analysis(benchmark::State& state) {
    const auto samples = raster<T>(state.range(0));
    auto pyramid = pyramid_of(samples, int(state.range(1)));
    Workspace<T> workspace;
    set_thread_count(int(state.range(2)));
    measure(state, samples, [&] { box::analyse<T>(samples.view(), 0, pyramid, workspace); });
    set_thread_count(0);
}

template <class T>
void synthesis(benchmark::State& state) {
    auto samples = raster<T>(state.range(0));
    const auto pyramid = pyramid_of(samples, int(state.range(1)));
    Workspace<T> workspace;
    set_thread_count(int(state.range(2)));
    measure(state, samples,
            [&] { box::coefficients<T>(pyramid, 0, 0, samples.view(), workspace); });
    set_thread_count(0);
}

template <class T>
void transposition(benchmark::State& state) {
    const auto samples = raster<T>(state.range(0));
    auto pyramid = pyramid_of(samples, int(state.range(1)));
    set_thread_count(int(state.range(2)));
    measure(state, samples, [&] { box::adjoint<T>(samples.view(), 0, pyramid); });
    set_thread_count(0);
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
