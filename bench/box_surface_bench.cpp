#include "relief/spline/box_surface.h"

#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "relief/core/parallel.h"
#include "relief/spline/lattice_filters.h"

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

template <class T>
BoxSurface<T> surface_of(int order) {
    const Grid<T> coefficients = noise<T>(kSide, kSide);
    return std::move(BoxSurface<T>::create(coefficients.view(), order)).value();
}

/// Arguments: order, derivatives.
template <class T>
void random_point_jets(benchmark::State& state) {
    set_thread_count(1);
    const BoxSurface<T> surface = surface_of<T>(static_cast<int>(state.range(0)));
    const std::vector<T> i = random_points<T>(2);
    const std::vector<T> j = random_points<T>(3);
    std::vector<T> results[6];
    for (auto& r : results) r.resize(kPoints);
    const JetSpans<T> out{results[0], results[1], results[2], results[3], results[4], results[5]};
    for (auto _ : state) {
        benchmark::DoNotOptimize(
            surface.evaluate(i, j, static_cast<int>(state.range(1)), out).ok());
        benchmark::ClobberMemory();
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kPoints));
}
BENCHMARK_TEMPLATE(random_point_jets, float)
    ->ArgNames({"order", "derivatives"})
    ->ArgsProduct({{1, 2, 3, 4}, {0, 1, 2}});
BENCHMARK_TEMPLATE(random_point_jets, double)
    ->ArgNames({"order", "derivatives"})
    ->ArgsProduct({{1, 2, 3, 4}, {0, 1, 2}});

/// Arguments: order, step in hundredths of a lattice unit.
template <class T>
void surface_grid(benchmark::State& state) {
    set_thread_count(1);
    const BoxSurface<T> surface = surface_of<T>(static_cast<int>(state.range(0)));
    const double step = static_cast<double>(state.range(1)) / 100;
    Grid<T> out(kSide, kSide);
    for (auto _ : state) {
        surface.evaluate_grid(0, step, 0, step, out.view());
        benchmark::ClobberMemory();
    }
    state.SetItemsProcessed(state.iterations() * out.count());
}
BENCHMARK_TEMPLATE(surface_grid, float)
    ->ArgNames({"order", "step"})
    ->ArgsProduct({{1, 2, 3}, {25, 37, 50, 99}});
BENCHMARK_TEMPLATE(surface_grid, double)->ArgNames({"order", "step"})->ArgsProduct({{2}, {25, 37}});

/// Arguments: order, side of the square.
template <class T>
void interpolation_solve(benchmark::State& state) {
    set_thread_count(1);
    const Grid<T> samples = noise<T>(state.range(1), state.range(1));
    Grid<T> coefficients(samples.rows(), samples.cols(), T(0));
    for (auto _ : state)
        benchmark::DoNotOptimize(interpolate_lattice<T>(static_cast<int>(state.range(0)),
                                                        samples.view(), coefficients.view())
                                     .ok());
    state.SetItemsProcessed(state.iterations() * samples.count());
}
BENCHMARK_TEMPLATE(interpolation_solve, float)
    ->ArgNames({"order", "side"})
    ->ArgsProduct({{2, 3, 4}, {1024}})
    ->Args({2, 4096})
    ->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(interpolation_solve, double)
    ->ArgNames({"order", "side"})
    ->ArgsProduct({{2, 3, 4}, {1024}})
    ->Args({2, 4096})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace relief::spline
