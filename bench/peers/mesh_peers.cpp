#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "mesh_peer.h"
#include "relief/core/parallel.h"
#include "relief/io/mesh.h"
#include "relief/mesh/split.h"
#include "shapes.h"

/// Measures relief and its peers at forward subdivision: one line of JSON for each base mesh,
/// scheme and library. One thread, whose own clock is read.
namespace relief::peers {

namespace {

using nlohmann::json;

constexpr std::uint64_t kMostFaces = 2'000'000;

Polygons polygons_of(const test::Shape& shape) {
    Polygons result{shape.faces, {}};
    for (const auto& p : shape.points) result.points.push_back({p[0], p[1], p[2]});
    return result;
}

Result<Polygons> read(const std::string& path) {
    RELIEF_TRY(const io::LoadedMesh loaded, io::read_mesh(path));
    Polygons result;
    result.faces.offsets = loaded.mesh.offsets;
    result.faces.corners.assign(loaded.mesh.corners.begin(), loaded.mesh.corners.end());
    for (const auto& p : loaded.mesh.vertices) result.points.push_back({p[0], p[1], p[2]});
    return result;
}

/// Best and median of some runs.
json summary(std::vector<double> seconds) {
    std::sort(seconds.begin(), seconds.end());
    return {{"best", seconds.front()}, {"median", seconds[seconds.size() / 2]}};
}

void measure(const std::string& name, const Subdividing& task, std::uint64_t faces, int runs) {
    for (const auto& peer : all_mesh_peers()) {
        if (!peer->offers(task.scheme)) continue;
        json line = {{"mesh", name},
                     {"scheme", multires::mesh_scheme_name(task.scheme)},
                     {"steps", task.steps},
                     {"faces", faces},
                     {"library", peer->name()},
                     {"scalar", peer->scalar()}};
        std::vector<double> first;
        std::vector<double> kept;
        std::vector<double> points;
        for (int run = 0; run < runs; ++run) {
            const auto times = peer->measure(task);
            if (!times.ok()) {
                line["error"] = times.error().text();
                break;
            }
            first.push_back(times->first);
            if (times->kept > 0) kept.push_back(times->kept);
            if (times->points > 0) points.push_back(times->points);
        }
        if (!first.empty()) line["first"] = summary(first);
        if (!kept.empty()) line["kept"] = summary(kept);
        if (!points.empty()) line["points"] = summary(points);
        std::cout << line.dump() << std::endl;
    }
}

/// With as many steps as give up to kMostFaces.
Status measure(const std::string& name, const Polygons& base, MeshScheme scheme, int runs) {
    RELIEF_TRY(const mesh::Topology mesh,
               mesh::build(base.faces, static_cast<mesh::Index>(base.points.size())));
    mesh::MeshCounts counts = mesh::counts_of(mesh);
    int steps = 0;
    for (;; ++steps) {
        const mesh::MeshCounts finer = mesh::refined(counts, multires::split_of(scheme, steps));
        if (finer.faces > kMostFaces && steps > 0) break;
        counts = finer;
    }
    measure(name, {base, scheme, steps}, counts.faces, runs);
    return {};
}

Status measure_shapes(int runs) {
    const struct {
        const char* name;
        test::Shape shape;
    } triangles[] = {{"icosahedron", test::icosahedron()},
                     {"torus", test::grid(32, 24, true, true)},
                     {"open grid", test::grid(24, 24, true)}},
      quads[] = {{"cube", test::cube()},
                 {"torus", test::grid(32, 24, false, true)},
                 {"open grid", test::grid(24, 24, false)}};
    for (const MeshScheme scheme : {MeshScheme::Loop, MeshScheme::Sqrt3})
        for (const auto& [name, shape] : triangles)
            RELIEF_CHECK(measure(name, polygons_of(shape), scheme, runs));
    for (const auto& [name, shape] : quads)
        RELIEF_CHECK(measure(name, polygons_of(shape), MeshScheme::CatmullClark, runs));
    return {};
}

Status measure_file(const std::string& path, int runs) {
    RELIEF_TRY(const Polygons base, read(path));
    const std::string name = stem(path);
    if (base.faces.corners.size() != 3 * base.faces.size())
        return measure(name, base, MeshScheme::CatmullClark, runs);
    RELIEF_CHECK(measure(name, base, MeshScheme::Loop, runs));
    return measure(name, base, MeshScheme::Sqrt3, runs);
}

int run(int count, char** arguments) {
    std::vector<std::string> paths(arguments + 1, arguments + count);
    int runs = 7;
    if (!paths.empty() && paths[0] == "--once") {
        runs = 1;
        paths.erase(paths.begin());
    }
    set_thread_count(1);
    std::cout << json{{"libraries",
                       {{"OpenSubdiv", RELIEF_OPENSUBDIV_VERSION},
                        {"OpenMesh", RELIEF_OPENMESH_VERSION},
                        {"CGAL", RELIEF_CGAL_VERSION}}}}
                     .dump()
              << std::endl;
    Status status = measure_shapes(runs);
    for (auto path = paths.begin(); status.ok() && path != paths.end(); ++path)
        status = measure_file(*path, runs);
    if (status.ok()) return 0;
    std::cerr << status.error().text() << '\n';
    return 1;
}

}  // namespace

}  // namespace relief::peers

int main(int count, char** arguments) {
    return relief::peers::run(count, arguments);
}
