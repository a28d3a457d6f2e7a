#include "relief/multires/barycentric.h"

#include "transform_bench.h"

namespace relief::multires {
namespace {

SchemeSpec spec_of(int order, bool semi_orthogonal) {
    return {SchemeId::Barycentric, order, semi_orthogonal ? Family::SemiOrthogonal : Family::Compact, 0, -1,
            DataMap::Coefficients};
}

template <class T>
void barycentric_analysis(benchmark::State& state) {
    const std::int64_t n = state.range(0);
    set_thread_count(static_cast<int>(state.range(2)));
    const Grid<T> data = bench::terrain<T>(n);
    const auto order = static_cast<int>(state.range(1));
    auto pyramid = Pyramid<T>::allocate(*barycentric::layout(spec_of(order % 10, order > 10), n, n, 1));
    Workspace<T> workspace;
    barycentric::analyse<T>(data.view(), 0, pyramid, workspace);
    bench::PerSample<T> measure(state, n);
    for (auto _ : state) barycentric::analyse<T>(data.view(), 0, pyramid, workspace);
}

template <class T>
void barycentric_synthesis(benchmark::State& state) {
    const std::int64_t n = state.range(0);
    set_thread_count(static_cast<int>(state.range(2)));
    Grid<T> data = bench::terrain<T>(n);
    const auto order = static_cast<int>(state.range(1));
    auto pyramid = Pyramid<T>::allocate(*barycentric::layout(spec_of(order % 10, order > 10), n, n, 1));
    barycentric::analyse<T>(data.view(), 0, pyramid);
    Workspace<T> workspace;
    barycentric::coefficients<T>(pyramid, 0, 0, data.view(), workspace);
    bench::PerSample<T> measure(state, n);
    for (auto _ : state) barycentric::coefficients<T>(pyramid, 0, 0, data.view(), workspace);
}

/// size, order (12: semi-orthogonal order 2), threads
void cases(benchmark::internal::Benchmark* bench) {
    bench->Unit(benchmark::kMillisecond)->UseRealTime()->MinTime(0.3);
    for (const int order : {1, 2, 3, 4, 12}) bench->Args({4096, order, 1});
    for (const int order : {1, 2}) bench->Args({4096, order, 2});
    for (const int n : {512, 1024, 2048, 8192}) bench->Args({n, 2, 1});
}
BENCHMARK_TEMPLATE(barycentric_analysis, float)->Apply(cases);
BENCHMARK_TEMPLATE(barycentric_synthesis, float)->Apply(cases);
BENCHMARK_TEMPLATE(barycentric_analysis, double)->Args({4096, 2, 1})->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_TEMPLATE(barycentric_synthesis, double)->Args({4096, 2, 1})->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace relief::multires
