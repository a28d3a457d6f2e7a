#include "relief/multires/barycentric.h"

#include "transform_bench.h"

/// Scheme `barycentric`, all levels, into kept buffers.
namespace relief::multires {
namespace {

/// 12 stands for order 2 of the semi-orthogonal family.
SchemeSpec spec_of(std::int64_t order) {
    return {SchemeId::Barycentric,
            static_cast<int>(order % 10),
            order > 10 ? Family::SemiOrthogonal : Family::Compact,
            0,
            -1,
            DataMap::Coefficients};
}

template <class T>
Pyramid<T> pyramid_of(const Grid<T>& samples, std::int64_t order) {
    auto pyramid = Pyramid<T>::allocate(
        *barycentric::layout(spec_of(order), samples.rows(), samples.cols(), 1));
    barycentric::analyse<T>(samples.view(), 0, pyramid);
    return pyramid;
}

template <class T>
void analysis(benchmark::State& state) {
    const auto samples = bench::terrain<T>(state.range(0));
    auto pyramid = pyramid_of(samples, state.range(1));
    Workspace<T> workspace;
    bench::measure(state, samples, state.range(2),
                   [&] { barycentric::analyse<T>(samples.view(), 0, pyramid, workspace); });
}

template <class T>
void synthesis(benchmark::State& state) {
    auto samples = bench::terrain<T>(state.range(0));
    const auto pyramid = pyramid_of(samples, state.range(1));
    Workspace<T> workspace;
    bench::measure(state, samples, state.range(2),
                   [&] { barycentric::coefficients<T>(pyramid, 0, 0, samples.view(), workspace); });
}

void two_threads(benchmark::State& state) {
    const auto samples = bench::terrain<float>(4096);
    auto pyramid = pyramid_of(samples, state.range(0));
    Workspace<float> workspace;
    bench::measure_two_threads(
        state, [&] { barycentric::analyse<float>(samples.view(), 0, pyramid, workspace); });
}

void peak_memory(benchmark::State& state) {
    bench::measure_peak(state, [&] {
        const auto samples = bench::terrain<float>(4096);
        const auto pyramid = pyramid_of(samples, state.range(0));
        return sizeof(float) * double(samples.count() + pyramid.layout.coefficients());
    });
}

void cases(benchmark::internal::Benchmark* b) {
    b->ArgNames({"side", "order", "threads"})->UseRealTime()->Unit(benchmark::kMillisecond);
    for (const int order : {1, 2, 3, 4, 12}) b->Args({4096, order, 1});
    for (const int order : {1, 2}) b->Args({4096, order, 2});
    for (const int side : {512, 1024, 2048, 8192}) b->Args({side, 2, 1});
}
void orders(benchmark::internal::Benchmark* b) {
    b->ArgNames({"order"})->Arg(1)->Arg(2)->Arg(12)->UseRealTime()->Unit(benchmark::kMillisecond);
}

BENCHMARK(analysis<float>)->Name("barycentric/analysis/float")->Apply(cases);
BENCHMARK(synthesis<float>)->Name("barycentric/synthesis/float")->Apply(cases);
BENCHMARK(analysis<double>)->Name("barycentric/analysis/double")->Apply(cases);
BENCHMARK(synthesis<double>)->Name("barycentric/synthesis/double")->Apply(cases);
BENCHMARK(two_threads)->Name("barycentric/two_threads")->Apply(orders);
BENCHMARK(peak_memory)->Name("barycentric/peak_memory")->Apply(orders)->Iterations(1);

}  // namespace
}  // namespace relief::multires
