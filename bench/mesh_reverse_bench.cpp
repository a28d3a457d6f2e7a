#include <benchmark/benchmark.h>

#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "relief/mesh/recognise.h"
#include "relief/multires/mesh_hierarchy.h"
#include "transform_bench.h"

/// Recognition, analysis and synthesis of meshes with subdivision connectivity: millions of faces
/// of the finest mesh a second. Arguments: scheme (0 sqrt(3), 1 Loop, 2 Catmull-Clark), shuffled,
/// threads.
namespace relief::multires {
namespace {

using mesh::Index;
using Points = std::vector<Vec3<double>>;

/// A torus of side x side cells in which valences vary: triangles with diagonals of both kinds, or
/// quads of which one in nine is cut in two.
mesh::FaceList base_faces(bool triangles, Index side) {
    mesh::FaceList faces;
    const auto at = [&](Index r, Index c) { return r % side * side + c % side; };
    for (Index r = 0; r < side; ++r)
        for (Index c = 0; c < side; ++c) {
            const std::array<Index, 4> q{at(r, c), at(r, c + 1), at(r + 1, c + 1), at(r + 1, c)};
            if (!triangles) {
                if ((r * side + c) % 9 == 4) {
                    faces.add(std::array<Index, 3>{q[0], q[1], q[2]});
                    faces.add(std::array<Index, 3>{q[0], q[2], q[3]});
                } else {
                    faces.add(q);
                }
            } else if ((7 * r + 3 * c) % 5 < 2) {
                faces.add(std::array<Index, 3>{q[0], q[1], q[3]});
                faces.add(std::array<Index, 3>{q[1], q[2], q[3]});
            } else {
                faces.add(std::array<Index, 3>{q[0], q[1], q[2]});
                faces.add(std::array<Index, 3>{q[0], q[2], q[3]});
            }
        }
    return faces;
}

Points base_points(Index side) {
    Points points;
    for (Index r = 0; r < side; ++r)
        for (Index c = 0; c < side; ++c) {
            const double u = 2 * M_PI * c / side;
            const double v = 2 * M_PI * r / side;
            const double tube = 1 + 0.1 * std::sin(5 * u) * std::cos(3 * v);
            points.push_back({(3 + tube * std::cos(v)) * std::cos(u),
                              (3 + tube * std::cos(v)) * std::sin(u), tube * std::sin(v)});
        }
    return points;
}

/// A rough subdivision surface: its hierarchy, its faces and points in their order or in another.
struct Sample {
    MeshScheme scheme;
    int steps;
    mesh::Topology base;
    mesh::FaceList faces;
    Points points;

    [[nodiscard]] std::int64_t face_count() const { return std::int64_t(faces.size()); }
    [[nodiscard]] MeshHierarchy hierarchy() const {
        return *MeshHierarchy::create(*mesh::build(mesh::faces_of(base), base.vertex_count), {},
                                      {.scheme = scheme}, steps);
    }
    [[nodiscard]] mesh::Topology topology() const {
        return *mesh::build(faces, static_cast<Index>(points.size()));
    }
};

void shuffle(Sample& sample) {
    std::mt19937 random(5);
    std::vector<Index> number(sample.points.size());
    std::iota(number.begin(), number.end(), Index{0});
    std::shuffle(number.begin(), number.end(), random);
    std::vector<std::size_t> order(sample.faces.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::shuffle(order.begin(), order.end(), random);
    Points points(sample.points.size());
    for (std::size_t v = 0; v < number.size(); ++v) points[number[v]] = sample.points[v];
    mesh::FaceList faces;
    for (const std::size_t f : order) {
        std::vector<Index> face;
        for (const Index v : sample.faces[f]) face.push_back(number[v]);
        std::rotate(face.begin(), face.begin() + static_cast<long>(random() % face.size()),
                    face.end());
        faces.add(face);
    }
    sample.points = std::move(points);
    sample.faces = std::move(faces);
}

Sample sample_of(std::int64_t scheme, bool shuffled) {
    Sample sample{static_cast<MeshScheme>(scheme), 0, {}, {}, {}};
    const bool triangles = sample.scheme != MeshScheme::CatmullClark;
    const Index side = triangles ? 12 : 20;
    sample.base = *mesh::build(base_faces(triangles, side), side * side);
    sample.steps = sample.scheme == MeshScheme::Sqrt3 ? 8 : 6;
    const MeshHierarchy hierarchy = sample.hierarchy();
    sample.points = base_points(side);
    sample.points.resize(hierarchy.vertices(sample.steps));
    StiffResiduals residuals;
    for (int step = 0; step < sample.steps; ++step)
        residuals.emplace_back(hierarchy.rules(step).stiff.size());
    const MeshMaps maps = *MeshMaps::create(hierarchy, {.lift = LiftKind::None});
    maps.synthesise(0, sample.steps, sample.points.data(), residuals);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> noise(-1e-3, 1e-3);
    for (auto& p : sample.points) p += {noise(random), noise(random), noise(random)};
    sample.faces = mesh::faces_of(hierarchy.topology(sample.steps));
    if (shuffled) shuffle(sample);
    return sample;
}

/// The best time of `body`, told as `elements` a second, and its most memory.
template <class Body>
void measure(benchmark::State& state, std::int64_t elements, std::int64_t faces, Body body) {
    const std::int64_t threads = state.range(2);
    set_thread_count(static_cast<int>(threads));
    const clockid_t clock = threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC;
    const double before = bench::memory_status("VmRSS");
    std::ofstream("/proc/self/clear_refs") << "5";  // the peak starts anew
    double best = std::numeric_limits<double>::infinity();
    for (auto _ : state) best = std::min(best, bench::time_of(clock, body));
    set_thread_count(0);
    state.counters["M_per_s"] = 1e3 * double(elements) / best;
    state.counters["bytes_per_face"] = (bench::memory_status("VmHWM") - before) / double(faces);
}

void build(benchmark::State& state) {
    const Sample sample = sample_of(state.range(0), state.range(1));
    measure(state, sample.face_count(), sample.face_count(),
            [&] { benchmark::DoNotOptimize(sample.topology()); });
}

void recognise_step(benchmark::State& state) {
    const Sample sample = sample_of(state.range(0), state.range(1));
    const mesh::Topology fine = sample.topology();
    const mesh::Split split = split_of(sample.scheme, 0);
    measure(state, sample.face_count(), sample.face_count(), [&] {
        const mesh::Recognition recognition(fine, split);
        benchmark::DoNotOptimize(
            recognition.unsplit(std::vector<std::size_t>(recognition.components(), 0)));
    });
}

void recognise(benchmark::State& state) {
    const Sample sample = sample_of(state.range(0), state.range(1));
    const mesh::Topology fine = sample.topology();
    measure(state, sample.face_count(), sample.face_count(), [&] {
        benchmark::DoNotOptimize(origin_of(fine, sample.points, {}, sample.scheme, 30));
    });
}

void create_hierarchy(benchmark::State& state) {
    const Sample sample = sample_of(state.range(0), state.range(1));
    measure(state, sample.face_count(), sample.face_count(), [&] {
        const MeshHierarchy hierarchy = sample.hierarchy();
        benchmark::DoNotOptimize(MeshMaps::create(hierarchy, {}));
    });
}

template <LiftKind lift>
void analyse(benchmark::State& state) {
    const Sample sample = sample_of(state.range(0), false);
    const MeshHierarchy hierarchy = sample.hierarchy();
    const MeshMaps maps = *MeshMaps::create(hierarchy, {.lift = lift});
    Points points = sample.points;
    StiffResiduals residuals;
    measure(state, sample.face_count(), sample.face_count(), [&] {
        std::copy(sample.points.begin(), sample.points.end(), points.begin());
        maps.analyse(points.data(), residuals);
    });
}

template <LiftKind lift>
void synthesise(benchmark::State& state) {
    const Sample sample = sample_of(state.range(0), false);
    const MeshHierarchy hierarchy = sample.hierarchy();
    const MeshMaps maps = *MeshMaps::create(hierarchy, {.lift = lift});
    Points coefficients = sample.points;
    StiffResiduals residuals;
    maps.analyse(coefficients.data(), residuals);
    Points points = coefficients;
    measure(state, std::int64_t(points.size()), sample.face_count(), [&] {
        std::copy(coefficients.begin(), coefficients.end(), points.begin());
        maps.synthesise(0, sample.steps, points.data(), residuals);
    });
}

/// Faces and points in, coefficients out.
void decompose(benchmark::State& state) {
    const Sample sample = sample_of(state.range(0), state.range(1));
    measure(state, sample.face_count(), sample.face_count(), [&] {
        mesh::Topology fine = sample.topology();
        MeshOrigin origin = *origin_of(fine, sample.points, {}, sample.scheme, 30);
        Points points(sample.points.size());
        const MeshHierarchy hierarchy = *MeshHierarchy::create(
            std::move(origin.base), std::move(origin.tags), origin.spec, origin.steps);
        const mesh::Topology& finest = hierarchy.topology(origin.steps);
        for (Index h = 0; h < finest.half_edge_count(); ++h)
            points[finest.origin[h]] = sample.points[fine.origin[origin.half_edge(h)]];
        fine = {};
        origin.corners = {};
        const MeshMaps maps = *MeshMaps::create(hierarchy, {});
        StiffResiduals residuals;
        maps.analyse(points.data(), residuals);
        benchmark::DoNotOptimize(points.data());
    });
}

constexpr std::int64_t kSchemes[] = {0, 1, 2};

void in_both_orders(benchmark::internal::Benchmark* b) {
    b->ArgNames({"scheme", "shuffled", "threads"})->MinTime(0.01);
    for (const std::int64_t scheme : kSchemes)
        for (const std::int64_t shuffled : {0, 1}) b->Args({scheme, shuffled, 1});
}
void with_threads(benchmark::internal::Benchmark* b) {
    b->ArgNames({"scheme", "shuffled", "threads"});
    for (const std::int64_t scheme : kSchemes)
        for (const std::int64_t threads : {1, 2}) b->Args({scheme, 0, threads});
}

BENCHMARK(build)->Name("mesh/build")->Apply(in_both_orders);
BENCHMARK(recognise_step)->Name("mesh/recognise_step")->Apply(in_both_orders);
BENCHMARK(recognise)->Name("mesh/recognise")->Apply(in_both_orders);
BENCHMARK(create_hierarchy)->Name("mesh/create_hierarchy")->Apply(with_threads);
BENCHMARK(analyse<LiftKind::None>)->Name("mesh/analyse/plain")->Apply(with_threads);
BENCHMARK(analyse<LiftKind::Chebyshev>)->Name("mesh/analyse/lifted")->Apply(with_threads);
BENCHMARK(synthesise<LiftKind::None>)->Name("mesh/synthesise/plain")->Apply(with_threads);
BENCHMARK(synthesise<LiftKind::Chebyshev>)->Name("mesh/synthesise/lifted")->Apply(with_threads);
BENCHMARK(decompose)->Name("mesh/decompose")->Apply(in_both_orders);

}  // namespace
}  // namespace relief::multires
