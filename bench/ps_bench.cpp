#include <benchmark/benchmark.h>

#include <algorithm>
#include <random>
#include <vector>

#include "relief/core/parallel.h"
#include "relief/mesh/delaunay.h"
#include "relief/multires/ps_energy.h"
#include "relief/multires/ps_lift.h"
#include "relief/multires/ps_surface.h"

// Random sites in the unit square. All on one thread: rates are per thread.
namespace relief::multires::ps {
namespace {

constexpr std::size_t kSites = 100'000;
constexpr std::size_t kLiftedSites = 10'000;
constexpr std::size_t kPoints = 1'000'000;

std::vector<Vec2> random_points(std::size_t count, unsigned seed) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> draw(0, 1);
    std::vector<Vec2> points(count);
    for (Vec2& p : points) {
        p.x = draw(engine);
        p.y = draw(engine);
    }
    return points;
}

Coefficients random_spline(const Space& space) {
    std::mt19937 engine(3);
    std::uniform_real_distribution<double> draw(-1, 1);
    Coefficients spline(space.mesh.vertex_count());
    for (Heights& heights : spline)
        for (double& height : heights) height = draw(engine);
    return spline;
}

struct Scene {
    explicit Scene(std::size_t sites)
        : space(*make_space(mesh::delaunay(random_points(sites, 1)).value().mesh)),
          spline(random_spline(space)) {}

    Space space;
    Coefficients spline;
};

const Scene& scene() {
    set_thread_count(1);
    static const Scene scene(kSites);
    return scene;
}

void ps_make_space(benchmark::State& state) {
    const mesh::Triangulation& mesh = scene().space.mesh;
    for (auto _ : state) benchmark::DoNotOptimize(make_space(mesh).ok());
    state.SetItemsProcessed(state.iterations() * mesh.vertex_count());
}
BENCHMARK(ps_make_space)->Unit(benchmark::kMillisecond);

/// Value, gradient and Hessian; with argument 1 the triangles are known.
void ps_jets(benchmark::State& state, bool sorted) {
    const Surface surface = *Surface::create(scene().space, std::span(&scene().spline, 1));
    const mesh::TriangleLocator locator(scene().space.mesh);
    std::vector<Vec2> points = random_points(kPoints, 2);
    std::vector<mesh::Index> triangles(kPoints);
    if (sorted)
        std::sort(points.begin(), points.end(), [&](Vec2 a, Vec2 b) {
            return static_cast<int>(300 * a.y) < static_cast<int>(300 * b.y) ||
                   (static_cast<int>(300 * a.y) == static_cast<int>(300 * b.y) && a.x < b.x);
        });
    std::vector<spline::PlaneJet> jets(kPoints);
    if (state.range(0) == 0) {
        for (auto _ : state)
            benchmark::DoNotOptimize(evaluate(surface, locator, points, jets, Outside::Nan).ok());
    } else {
        locator.locate(points, triangles);
        std::replace(triangles.begin(), triangles.end(), mesh::kNone, mesh::Index{0});
        for (auto _ : state)
            for (std::size_t k = 0; k < kPoints; ++k)
                surface.jets(triangles[k], points[k] - scene().space.mesh.origin, &jets[k]);
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kPoints));
}
BENCHMARK_CAPTURE(ps_jets, random, false)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ps_jets, sorted, true)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

/// Argument: samples a side; 1000 are 5 a triangle, 4472 are 100.
void ps_raster(benchmark::State& state) {
    const Surface surface = *Surface::create(scene().space, std::span(&scene().spline, 1));
    Grid<double> raster(state.range(0), state.range(0));
    const double step = 1 / static_cast<double>(state.range(0));
    for (auto _ : state)
        benchmark::DoNotOptimize(
            evaluate_raster(surface, {{0, 0}, {step, step}}, raster.view()).ok());
    state.SetItemsProcessed(state.iterations() * raster.rows() * raster.cols());
}
BENCHMARK(ps_raster)->Arg(1000)->Arg(4472)->Unit(benchmark::kMillisecond);

/// Rates count vertices of the refined mesh.
void ps_refine(benchmark::State& state) {
    const Space& space = scene().space;
    std::int64_t vertices = 0;
    for (auto _ : state) vertices += refine(space)->fine.mesh.vertex_count();
    state.SetItemsProcessed(vertices);
}
BENCHMARK(ps_refine)->Unit(benchmark::kMillisecond);

void ps_prolong(benchmark::State& state) {
    const Refinement step = *refine(scene().space);
    std::int64_t vertices = 0;
    for (auto _ : state)
        vertices += static_cast<std::int64_t>(prolong(scene().space, step, scene().spline).size());
    state.SetItemsProcessed(vertices);
}
BENCHMARK(ps_prolong)->Unit(benchmark::kMillisecond);

void ps_analyse(benchmark::State& state) {
    set_thread_count(1);
    const Scene lifted(kLiftedSites);
    const Refinement step = *refine(lifted.space);
    const Coefficients fine = random_spline(step.fine);
    const auto update = static_cast<Update>(state.range(0));
    for (auto _ : state) benchmark::DoNotOptimize(analyse(lifted.space, step, fine, update).ok());
    state.SetItemsProcessed(state.iterations() * step.fine.mesh.vertex_count());
}
BENCHMARK(ps_analyse)
    ->ArgName("update")
    ->DenseRange(static_cast<int>(Update::None), static_cast<int>(Update::Full))
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace relief::multires::ps
