#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "relief/core/parallel.h"
#include "relief/mesh/delaunay.h"
#include "relief/mesh/scan.h"
#include "relief/mesh/triangle_locator.h"

// All on one thread: rates are per thread.
namespace relief::mesh {
namespace {

constexpr std::size_t kQueries = 1 << 20;

std::vector<Vec2> random_points(std::size_t count, unsigned seed) {
    std::mt19937_64 engine(seed);
    std::uniform_real_distribution<double> draw(0, 1);
    std::vector<Vec2> points(count);
    for (Vec2& p : points) p = {draw(engine), draw(engine)};
    return points;
}

Triangulation random_mesh(benchmark::State& state) {
    const auto points = random_points(static_cast<std::size_t>(state.range(0)), 1);
    return std::move(delaunay(points).value().mesh);
}

void delaunay_of_random_points(benchmark::State& state) {
    const auto points = random_points(static_cast<std::size_t>(state.range(0)), 1);
    for (auto _ : state) benchmark::DoNotOptimize(delaunay(points).ok());
    state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(delaunay_of_random_points)->Arg(50000)->Arg(1000000)->Unit(benchmark::kMillisecond);

void connect_triangles(benchmark::State& state) {
    const Triangulation mesh = random_mesh(state);
    for (auto _ : state)
        benchmark::DoNotOptimize(connect(mesh.origin, mesh.x, mesh.y, mesh.triangles).edge_count());
    state.SetItemsProcessed(state.iterations() * mesh.triangle_count());
}
BENCHMARK(connect_triangles)->Arg(50000)->Arg(1000000)->Unit(benchmark::kMillisecond);

void locate_one_by_one(benchmark::State& state) {
    const Triangulation mesh = random_mesh(state);
    const TriangleLocator locator(mesh);
    const auto points = random_points(kQueries, 2);
    for (auto _ : state)
        for (const Vec2 p : points) benchmark::DoNotOptimize(locator.locate(p));
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kQueries));
}
BENCHMARK(locate_one_by_one)->Arg(50000)->Arg(1000000)->Unit(benchmark::kMillisecond);

void locate_together(benchmark::State& state) {
    set_thread_count(1);
    const Triangulation mesh = random_mesh(state);
    const TriangleLocator locator(mesh);
    const auto points = random_points(kQueries, 2);
    std::vector<Index> found(kQueries);
    for (auto _ : state) {
        locator.locate(points, found);
        benchmark::DoNotOptimize(found.data());
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kQueries));
}
BENCHMARK(locate_together)->Arg(50000)->Arg(1000000)->Unit(benchmark::kMillisecond);

void scan_a_megapixel(benchmark::State& state) {
    constexpr Index kSide = 1024;
    const Triangulation mesh = random_mesh(state);
    for (auto _ : state) {
        const RowScan scan(mesh, {{0, 0}, {1.0 / kSide, 1.0 / kSide}, kSide, kSide});
        for (Index row = 0; row < kSide; ++row) benchmark::DoNotOptimize(scan.runs(row).size());
    }
    state.SetItemsProcessed(state.iterations() * std::int64_t{kSide} * kSide);
}
BENCHMARK(scan_a_megapixel)->Arg(500)->Arg(50000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace relief::mesh
