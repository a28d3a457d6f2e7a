#include "point_costs.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>

#include "relief/core/parallel.h"
#include "relief/mesh/delaunay.h"
#include "relief/multires/ps_adaptive.h"
#include "relief/multires/ps_fit.h"
#include "relief/multires/ps_gradients.h"
#include "relief/multires/ps_interpolant.h"
#include "relief/multires/ps_lift.h"
#include "relief/multires/ps_surface.h"

namespace relief::peers {

namespace ps = multires::ps;
using nlohmann::json;

namespace {

constexpr std::int64_t kSmallRaster = 1024;
constexpr std::int64_t kLargeRaster = 4608;
constexpr std::int64_t kLatticeSide = 50;  ///< 5000 triangles
constexpr int kLevels = 3;
constexpr std::size_t kFitVertices = 20'000;

/// Resident memory of the process, what was freed not counted.
double resident_bytes() {
    malloc_trim(0);
    std::int64_t all = 0;
    std::int64_t resident = 0;
    std::ifstream("/proc/self/statm") >> all >> resident;
    return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

double wall_seconds() {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    return std::chrono::duration<double>(now).count();
}

/// A spline with the values of xy at the vertices, flat there.
ps::Coefficients flat_spline(const ps::Space& space) {
    ps::TangentPlanes planes;
    for (mesh::Index v = 0; v < space.mesh.vertex_count(); ++v)
        planes.push_back({space.mesh.x[v] * space.mesh.y[v], {}});
    return ps::coefficients(space, planes);
}

/// A lattice whose inner points are moved a little, so that nothing is regular.
Result<ps::Space> lattice_space() {
    std::vector<Vec2> places;
    for (std::int64_t row = 0; row <= kLatticeSide; ++row)
        for (std::int64_t col = 0; col <= kLatticeSide; ++col) {
            const bool inner = row % kLatticeSide != 0 && col % kLatticeSide != 0;
            const double shift = inner ? 0.05 * static_cast<double>((7 * row + 3 * col) % 5) : 0;
            places.push_back({static_cast<double>(col) + shift, static_cast<double>(row) - shift});
        }
    RELIEF_TRY(mesh::Delaunay delaunay, mesh::delaunay(places));
    return ps::make_space(std::move(delaunay.mesh));
}

}  // namespace

json summary(std::vector<double> seconds) {
    std::sort(seconds.begin(), seconds.end());
    return {{"best", seconds.front()}, {"median", seconds[seconds.size() / 2]}};
}

Result<json> rasters(const Samples& sites, int runs) {
    const auto peer = relief_points();
    RELIEF_CHECK(peer->build(sites));
    json line{{"cost", "rasters"}, {"sites", sites.places.size()}};
    for (const std::int64_t side : {kSmallRaster, kLargeRaster}) {
        std::vector<double> values(static_cast<std::size_t>(side * side));
        std::vector<double> seconds;
        for (int run = 0; run < runs; ++run) {
            const double start = thread_seconds();
            RELIEF_CHECK(peer->raster(side, values));
            seconds.push_back(thread_seconds() - start);
        }
        line["rasters"].push_back({{"side", side}, {"seconds", summary(seconds)}});
    }
    return line;
}

Result<json> building(const Samples& sites, int runs) {
    json line{{"cost", "building"}, {"sites", sites.places.size()}};
    std::vector<double> triangulation;
    std::vector<double> gradients;
    std::vector<double> splits;
    std::vector<double> surfaces;
    std::vector<double> locators;
    std::vector<double> controls;
    for (int run = 0; run < runs; ++run) {
        double start = thread_seconds();
        const auto lap = [&start](std::vector<double>& seconds) {
            const double now = thread_seconds();
            seconds.push_back(now - start);
            start = now;
        };
        RELIEF_TRY(mesh::Delaunay delaunay, mesh::delaunay(sites.places));
        lap(triangulation);
        const std::vector<double> values(delaunay.mesh.x);
        RELIEF_CHECK(ps::estimate_gradients(delaunay.mesh, values));
        lap(gradients);
        RELIEF_TRY(const ps::Split cut, ps::split(delaunay.mesh));
        lap(splits);
        const ps::TangentPlanes flat(values.size());
        start = thread_seconds();
        RELIEF_CHECK(ps::Surface::create(delaunay.mesh, cut, std::span(&flat, 1)));
        lap(surfaces);
        const mesh::TriangleLocator locator(delaunay.mesh);
        lap(locators);
        RELIEF_CHECK(ps::make_space(std::move(delaunay.mesh)));
        lap(controls);
    }
    line["triangulation"] = summary(triangulation);
    line["gradients"] = summary(gradients);
    line["split"] = summary(splits);
    line["surface"] = summary(surfaces);
    line["locator"] = summary(locators);
    line["space"] = summary(controls);
    return line;
}

Result<json> memory(const Samples& sites) {
    const double start = resident_bytes();
    std::vector<double> parts;
    const auto lap = [&parts, start] {
        double before = start;
        for (const double part : parts) before += part;
        parts.push_back(resident_bytes() - before);
    };
    RELIEF_TRY(const ps::Interpolant interpolant,
               ps::Interpolant::create(sites.places, sites.values));
    lap();
    RELIEF_TRY(mesh::Delaunay delaunay, mesh::delaunay(sites.places));
    mesh::Triangulation mesh = std::move(delaunay.mesh);
    delaunay = {};
    lap();
    RELIEF_TRY(const ps::Space space, ps::make_space(std::move(mesh)));
    lap();
    const mesh::TriangleLocator locator(space.mesh);
    lap();
    const auto vertices = static_cast<double>(space.mesh.vertex_count());
    const mesh::PlaneTriangles& corners = interpolant.triangles();
    const double triangles =
        static_cast<double>(2 * sizeof(double) * corners.x.size() +
                            sizeof(corners.triangles[0]) * corners.triangles.size()) /
        vertices;
    return json{{"cost", "memory"},
                {"vertices", vertices},
                {"all", parts[0] / vertices},
                {"triangles", triangles},
                {"locator", parts[3] / vertices},
                {"surface", (parts[0] - parts[3]) / vertices - triangles},
                {"triangulation", parts[1] / vertices},
                {"split_and_control", parts[2] / vertices}};
}

Result<json> refinement(int runs) {
    RELIEF_TRY(const ps::Space base, lattice_space());
    const ps::Coefficients spline = flat_spline(base);
    std::vector<double> refining;
    std::vector<double> prolonging;
    std::size_t triangles = 0;
    for (int run = 0; run < runs; ++run) {
        double start = thread_seconds();
        RELIEF_TRY(const ps::Hierarchy hierarchy, ps::Hierarchy::create(base, kLevels));
        refining.push_back(thread_seconds() - start);
        start = thread_seconds();
        ps::Coefficients finer = spline;
        for (int level = 0; level < kLevels; ++level)
            finer = ps::prolong(hierarchy.space(level), hierarchy.step(level), finer);
        prolonging.push_back(thread_seconds() - start);
        triangles = hierarchy.space(kLevels).mesh.triangles.size();
    }
    return json{{"cost", "refinement"},
                {"base", base.mesh.triangles.size()},
                {"triangles", triangles},
                {"refine", summary(refining)},
                {"prolong", summary(prolonging)}};
}

Result<json> least_squares(const Samples& samples, int runs) {
    RELIEF_TRY(mesh::Triangulation base, ps::spread_triangulation(samples.places, kFitVertices));
    RELIEF_TRY(const ps::Space space, ps::make_space(std::move(base)));
    json line{{"cost", "least squares"},
              {"points", samples.places.size()},
              {"vertices", space.mesh.vertex_count()}};
    for (const int threads : {1, 2}) {
        set_thread_count(threads);
        const auto clock = [threads] { return threads == 1 ? thread_seconds() : wall_seconds(); };
        std::vector<double> seconds;
        for (int run = 0; run < runs; ++run) {
            const double start = clock();
            std::vector<mesh::Index> triangles(samples.places.size());
            mesh::TriangleLocator(space.mesh).locate(samples.places, triangles);
            RELIEF_TRY(const ps::LeastSquares squares,
                       ps::LeastSquares::create(space, {samples.places, triangles, {}}));
            RELIEF_TRY(const ps::FittedSpline fitted, squares.fit(samples.values));
            seconds.push_back(clock() - start);
            line["rms_error"] = fitted.report.rms_error;
            line["smoothing"] = fitted.report.smoothing;
        }
        line[threads == 1 ? "one_thread" : "two_threads"] = summary(seconds);
    }
    set_thread_count(1);
    return line;
}

}  // namespace relief::peers
