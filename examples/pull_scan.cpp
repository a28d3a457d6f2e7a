// Remeshes a scan, pulls the highest control point of a coarse level up by HEIGHT, those within
// RADIUS with it, and writes the edited surface, whose details have turned and grown along. usage:
// pull_scan SCAN OUT_MESH RADIUS HEIGHT
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "relief/codec/mesh_codec.h"
#include "relief/edit/session.h"
#include "relief/io/mesh.h"
#include "relief/remesh/remesh.h"

using namespace relief;

std::size_t highest(const PolygonMesh& mesh) {
    const auto& all = mesh.vertices;
    const auto lower = [](const auto& a, const auto& b) { return a[2] < b[2]; };
    return static_cast<std::size_t>(std::max_element(all.begin(), all.end(), lower) - all.begin());
}

Status run(const char* scan_path, const char* out_path, double radius, double height) {
    RELIEF_TRY(const io::LoadedMesh scan, io::read_mesh(scan_path));
    RELIEF_TRY(const remesh::Remeshed remeshed, remesh::remesh(scan.mesh, {}));
    std::printf("%d levels, rms distance from the scan %.1e of the diagonal\n", remeshed.levels,
                remeshed.report.rms_error / remeshed.report.diagonal);

    RELIEF_TRY(auto encoded, codec::encode_mesh(remeshed.mesh, {.levels = remeshed.levels}));
    RELIEF_TRY(const auto file, codec::MeshFile::open(encoded.bytes));
    const int level = file.levels();  // of the base
    RELIEF_TRY(const PolygonMesh net, file.decode(level));
    RELIEF_TRY(auto session,
               edit::Session::open(std::make_shared<MemorySource>(std::move(encoded.bytes))));
    RELIEF_CHECK(session.apply({.level = level,
                                .points = {highest(net)},
                                .delta = {0, 0, height},
                                .falloff = {.radius = radius}}));

    RELIEF_TRY(Bytes edited, session.file());
    RELIEF_TRY(const auto result, codec::MeshFile::open(std::move(edited)));
    RELIEF_TRY(const PolygonMesh mesh, result.decode(0));
    std::printf("the highest point rose from %.2f to %.2f\n",
                scan.mesh.vertices[highest(scan.mesh)][2], mesh.vertices[highest(mesh)][2]);
    RELIEF_CHECK(io::write_mesh(out_path, mesh));
    return {};
}

int main(int argc, char** argv) {
    if (argc != 5) return 2;
    const Status done = run(argv[1], argv[2], std::atof(argv[3]), std::atof(argv[4]));
    if (done.ok()) return 0;
    std::fprintf(stderr, "pull_scan: %s\n", done.error().text().c_str());
    return 1;
}
