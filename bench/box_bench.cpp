#include "relief/multires/box.h"

#include "transform_bench.h"

/// Scheme `box`, all levels, into kept buffers.
namespace relief::multires {
namespace {

template <class T>
Pyramid<T> pyramid_of(const Grid<T>& samples, std::int64_t order) {
    const SchemeSpec spec{.order = int(order)};
    auto pyramid = Pyramid<T>::allocate(*box::layout(spec, samples.rows(), samples.cols(), 1));
    box::analyse<T>(samples.view(), 0, pyramid);
    return pyramid;
}

template <class T>
void copying(benchmark::State& state) {
    const auto from = bench::terrain<T>(state.range(0));
    auto to = from.clone();
    bench::measure(state, from, 1, [&] { bench::copy(from, to); });
}

template <class T>
void analysis(benchmark::State& state) {
    const auto samples = bench::terrain<T>(state.range(0));
    auto pyramid = pyramid_of(samples, state.range(1));
    Workspace<T> workspace;
    bench::measure(state, samples, state.range(2),
                   [&] { box::analyse<T>(samples.view(), 0, pyramid, workspace); });
}

template <class T>
void synthesis(benchmark::State& state) {
    auto samples = bench::terrain<T>(state.range(0));
    const auto pyramid = pyramid_of(samples, state.range(1));
    Workspace<T> workspace;
    bench::measure(state, samples, state.range(2),
                   [&] { box::coefficients<T>(pyramid, 0, 0, samples.view(), workspace); });
}

template <class T>
void transposition(benchmark::State& state) {
    const auto samples = bench::terrain<T>(state.range(0));
    auto pyramid = pyramid_of(samples, state.range(1));
    bench::measure(state, samples, state.range(2),
                   [&] { box::adjoint<T>(samples.view(), 0, pyramid); });
}

void two_threads(benchmark::State& state) {
    const auto samples = bench::terrain<float>(4096);
    auto pyramid = pyramid_of(samples, state.range(0));
    Workspace<float> workspace;
    bench::measure_two_threads(state,
                               [&] { box::analyse<float>(samples.view(), 0, pyramid, workspace); });
}

void peak_memory(benchmark::State& state) {
    bench::measure_peak(state, [&] {
        const auto samples = bench::terrain<float>(4096);
        const auto pyramid = pyramid_of(samples, state.range(0));
        return sizeof(float) * double(samples.count() + pyramid.layout.coefficients());
    });
}

void sizes(benchmark::internal::Benchmark* b) {
    b->ArgNames({"side"})->RangeMultiplier(2)->Range(512, 8192)->UseRealTime();
}
void sizes_orders_threads(benchmark::internal::Benchmark* b) {
    b->ArgNames({"side", "order", "threads"})
        ->ArgsProduct({{512, 1024, 2048, 4096, 8192}, {1, 2}, {1, 2}})
        ->UseRealTime();
}
void orders(benchmark::internal::Benchmark* b) {
    b->ArgNames({"order"})->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);
}

BENCHMARK(copying<float>)->Name("memcpy/float")->Apply(sizes);
BENCHMARK(copying<double>)->Name("memcpy/double")->Apply(sizes);
BENCHMARK(analysis<float>)->Name("box/analysis/float")->Apply(sizes_orders_threads);
BENCHMARK(analysis<double>)->Name("box/analysis/double")->Apply(sizes_orders_threads);
BENCHMARK(synthesis<float>)->Name("box/synthesis/float")->Apply(sizes_orders_threads);
BENCHMARK(synthesis<double>)->Name("box/synthesis/double")->Apply(sizes_orders_threads);
BENCHMARK(transposition<float>)->Name("box/adjoint/float")->Apply(sizes_orders_threads);
BENCHMARK(two_threads)->Name("box/two_threads")->Apply(orders);
BENCHMARK(peak_memory)->Name("box/peak_memory")->Apply(orders)->Iterations(1);

}  // namespace
}  // namespace relief::multires
