#include <benchmark/benchmark.h>

#include "relief/remesh/remesh.h"
#include "relief/remesh/simplify.h"
#include "shapes.h"

// Remeshing, stage by stage, of a bumpy torus of some 100 000 triangles.

namespace relief::remesh {

namespace {

const PolygonMesh& torus() {
    static const PolygonMesh mesh = [] {
        const test::Shape shape = test::grid(320, 160, true, true);
        PolygonMesh polygons{.vertices = shape.points, .offsets = shape.faces.offsets};
        polygons.corners.assign(shape.faces.corners.begin(), shape.faces.corners.end());
        return polygons;
    }();
    return mesh;
}

const Surface& surface() {
    static const Surface made = *surface_of(torus(), {});
    return made;
}

void count_triangles(benchmark::State& state) {
    state.counters["triangles_per_second"] =
        benchmark::Counter(static_cast<double>(torus().polygon_count()),
                           benchmark::Counter::kIsIterationInvariantRate);
}

void remesh_surface(benchmark::State& state) {
    for (auto _ : state) benchmark::DoNotOptimize(surface_of(torus(), {}));
    count_triangles(state);
}
BENCHMARK(remesh_surface)->Name("remesh/surface")->Unit(benchmark::kMillisecond);

void remesh_simplify(benchmark::State& state) {
    for (auto _ : state)
        benchmark::DoNotOptimize(Simplification(surface(), {.faces = 400}).vertices().size());
    count_triangles(state);
}
BENCHMARK(remesh_simplify)->Name("remesh/simplify")->Unit(benchmark::kMillisecond);

void remesh_map(benchmark::State& state) {
    const Simplification simple(surface(), {.faces = 400});
    for (auto _ : state) {
        std::vector<Place> places;
        for (mesh::Index f = 0; f < simple.faces().size(); ++f)
            for (int k = 0; k < 128; ++k) {
                const double a = (k % 12 + 0.5) / 13;
                places.push_back({f, {a, (1 - a) * k / 128, (1 - a) * (128 - k) / 128}});
            }
        simple.to_surface(places);
        benchmark::DoNotOptimize(places.data());
    }
    count_triangles(state);
}
BENCHMARK(remesh_map)->Name("remesh/map")->Unit(benchmark::kMillisecond);

void remesh_all(benchmark::State& state) {
    for (auto _ : state) {
        const auto result = remesh(torus(), {});
        if (!result.ok()) state.SkipWithError("it can not be remeshed");
        benchmark::DoNotOptimize(result);
    }
    count_triangles(state);
}
BENCHMARK(remesh_all)->Name("remesh/all")->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

}  // namespace relief::remesh
