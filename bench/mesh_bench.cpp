#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "relief/core/parallel.h"
#include "relief/multires/subdivider.h"
#include "shapes.h"

// Forward subdivision to about a million faces. All on one thread: rates are per thread.
namespace relief::multires {
namespace {

struct Case {
    const char* name;
    test::Shape (*base)();
    MeshScheme scheme;
    int steps;
};
test::Shape torus() {
    return test::grid(32, 24, true, true);
}
test::Shape quad_torus() {
    return test::grid(32, 24, false, true);
}
test::Shape open_grid() {
    return test::grid(24, 24, true);
}
test::Shape open_quads() {
    return test::grid(24, 24, false);
}
constexpr Case kCases[] = {
    {"loop/icosahedron", test::icosahedron, MeshScheme::Loop, 8},
    {"loop/torus", torus, MeshScheme::Loop, 5},
    {"loop/open_grid", open_grid, MeshScheme::Loop, 5},
    {"catmull-clark/cube", test::cube, MeshScheme::CatmullClark, 9},
    {"catmull-clark/torus", quad_torus, MeshScheme::CatmullClark, 5},
    {"catmull-clark/large_torus", quad_torus, MeshScheme::CatmullClark, 6},
    {"catmull-clark/open_grid", open_quads, MeshScheme::CatmullClark, 5},
    {"sqrt3/icosahedron", test::icosahedron, MeshScheme::Sqrt3, 10},
    {"sqrt3/torus", torus, MeshScheme::Sqrt3, 6},
    {"sqrt3/open_grid", open_grid, MeshScheme::Sqrt3, 6},
};

/// A base mesh and what its subdivision fills.
template <class T>
struct Work {
    explicit Work(const Case& its_case) : spec{.scheme = its_case.scheme}, steps(its_case.steps) {
        const test::Shape shape = its_case.base();
        base = shape.topology();
        for (const auto& p : shape.points)
            places.push_back({static_cast<T>(p[0]), static_cast<T>(p[1]), static_cast<T>(p[2])});
    }

    void prepare() {
        if (!subdivider.prepare(base, {}, spec, steps).ok()) std::abort();
        corners.renew(subdivider.counts().half_edges);
        points.renew(subdivider.counts().vertices);
    }
    void set_faces() { subdivider.faces({corners.data(), corners.size()}); }
    void set_points() {
        subdivider.points<T>(places, {points.data(), points.size()});
        benchmark::ClobberMemory();
    }
    void all() {
        prepare();
        set_faces();
        set_points();
    }
    void forget() {
        subdivider = {};
        corners = {};
        points = {};
    }

    MeshSpec spec;
    int steps;
    mesh::Topology base;
    std::vector<Vec3<T>> places;
    Subdivider subdivider;
    Buffer<mesh::Index> corners;
    Buffer<Vec3<T>> points;
};

template <class T, class Call>
void run(benchmark::State& state, const Case& its_case, Call call) {
    set_thread_count(1);
    Work<T> work(its_case);
    work.all();
    for (auto _ : state) call(work);
    state.counters["faces_per_second"] =
        benchmark::Counter(static_cast<double>(work.corners.size()) / work.subdivider.sides(),
                           benchmark::Counter::kIsIterationInvariantRate);
}

template <class T>
void add(const Case& its_case, const std::string& type) {
    const auto name = [&](const char* what) {
        return "forward/" + std::string(its_case.name) + "/" + type + "/" + what;
    };
    const auto add_one = [&](const char* what, auto call) {
        benchmark::RegisterBenchmark(name(what).c_str(), [its_case, call](benchmark::State& state) {
            run<T>(state, its_case, call);
        })->Unit(benchmark::kMillisecond);
    };
    add_one("first_call", [](Work<T>& work) {
        work.forget();
        work.all();
    });
    add_one("kept_memory", [](Work<T>& work) { work.all(); });
    add_one("points", [](Work<T>& work) { work.set_points(); });
}

const bool kRegistered = [] {
    for (const Case& its_case : kCases) {
        add<float>(its_case, "float");
        add<double>(its_case, "double");
    }
    return true;
}();

}  // namespace
}  // namespace relief::multires
