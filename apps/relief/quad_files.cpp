#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "level_files.h"
#include "mesh_verbs.h"
#include "quad_verbs.h"
#include "relief/io/file.h"
#include "relief/io/file_kind.h"
#include "relief/io/mesh.h"
#include "relief/mesh/repair.h"
#include "relief/multires/mesh_hierarchy.h"

namespace relief::cli {

namespace {

constexpr std::string_view kQuadrangulation = "quadrangulation";

constexpr FaceCount<mesh::LevelCounts> kQuads = {"quads", &mesh::LevelCounts::quads};

}  // namespace

bool holds_quads(const std::string& path) {
    return holds(path, kQuadrangulation);
}

bool is_mesh(const std::string& path) {
    return io::recognise(path) == io::FileKind::Mesh || holds_quads(path) || holds_mesh(path);
}

Result<codec::QuadFile> open_quads(const std::string& path,
                                   std::optional<std::uint64_t> max_bytes) {
    return open_file<codec::QuadFile>(path, max_bytes);
}

Result<codec::QuadMesh> read_quads(const std::string& path) {
    if (io::recognise(path) == io::FileKind::Mesh) {
        RELIEF_TRY(const io::LoadedMesh loaded, io::read_mesh(path));
        return located(codec::quads_of(loaded.mesh), path);
    }
    RELIEF_TRY(const codec::QuadFile file, open_quads(path));
    auto mesh = file.decode(0);
    if (!mesh.ok()) return located(mesh.error(), path);
    return mesh;
}

Result<Outcome> decode_quads(const std::string& in, const std::string& out, int level,
                             std::optional<std::uint64_t> max_bytes) {
    const Stopwatch watch;
    RELIEF_TRY(const codec::QuadFile file, open_quads(in, max_bytes));
    const auto mesh = file.decode(level);
    if (!mesh.ok()) return located(mesh.error(), in);
    if (const auto written = io::write_mesh(out, codec::polygons_of(*mesh), {.up = io::Up::Z});
        !written.ok())
        return written.error();
    const auto surface = file.surface_bound(level);
    Outcome outcome;
    outcome.json = Json{{"samples", mesh->vertices.size()},
                        {"bytes_read", file.bytes_for(level)},
                        {"level", level},
                        {"bound", json_number(file.bound(level))},
                        {"surface_bound", json_number(surface)},
                        {"quads", mesh->quads.size()},
                        {"finest_level", file.finest_level()},
                        {"seconds", watch.seconds()}};
    outcome.text = fmt::format("{}: {} vertices, {} quads of level {}, {} bytes read\n", out,
                               grouped(static_cast<std::int64_t>(mesh->vertices.size())),
                               grouped(static_cast<std::int64_t>(mesh->quads.size())), level,
                               grouped(static_cast<std::int64_t>(file.bytes_for(level))));
    if (surface)
        outcome.text +=
            fmt::format("its surface is within {} of the original one\n", shown(*surface));
    return outcome;
}

Result<Outcome> info_of_quads(const std::string& path) {
    RELIEF_TRY(const codec::QuadFile file, open_quads(path));
    const Json levels = levels_json(file, kQuads);
    Json bands =
        bands_json(file, [&](int) { return file.holds_values() ? "values" : "coefficients"; });
    for (Json& band : bands) band["step"] = file.step();
    const bool sound = file.checksums_ok();
    const Json more{{"vertices", file.counts(0).vertices},
                    {"quads", file.counts(0).quads},
                    {"type", file.holds_values() ? Json(file.lattice()) : Json(nullptr)}};
    Outcome outcome;
    outcome.json = info_json(file,
                             {.content = kQuadrangulation,
                              .scheme = "fvs",
                              .order = 3,
                              .more = more,
                              .bands = bands,
                              .levels = levels},
                             sound);
    outcome.text = head_text(path, file, sound);
    outcome.text +=
        fmt::format("quadrangulation of {} vertices and {} quads, scheme fvs, {} levels, {}\n",
                    grouped(static_cast<std::int64_t>(file.counts(0).vertices)),
                    grouped(static_cast<std::int64_t>(file.counts(0).quads)), file.levels(),
                    file.holds_values() ? "values at vertices" : "coefficients");
    outcome.text += file.edited() ? edits_text(file.moves().size()) + '\n'
                                  : fmt::format("vertices within {} of the original (rms {})\n",
                                                shown(file.max_error()), shown(file.rms_error()));
    outcome.text += levels_text(levels, kQuads.name);
    return outcome;
}

namespace {

const char* element_of(const mesh::MeshProblem& problem) {
    const bool vertex = problem.kind == mesh::MeshProblemKind::SeveralFans ||
                        problem.kind == mesh::MeshProblemKind::UnusedVertex;
    return vertex ? "vertex" : "face";
}

Json problems_json(const mesh::MeshDiagnosis& diagnosis) {
    Json problems = Json::array();
    for (const mesh::MeshProblem& problem : diagnosis.problems)
        problems.push_back(Json{{"element", element_of(problem)},
                                {"number", problem.element},
                                {"message", problem.message}});
    return problems;
}

/// What the mesh is a subdivision of, by scheme.
Json schemes_of(const PolygonMesh& polygons) {
    Json schemes = Json::array();
    const std::vector<mesh::Index> corners(polygons.corners.begin(), polygons.corners.end());
    const auto topology =
        mesh::build(polygons.offsets, corners, static_cast<mesh::Index>(polygons.vertices.size()));
    if (!topology.ok()) return schemes;
    std::vector<Vec3<double>> points;
    for (const auto& v : polygons.vertices) points.push_back({v[0], v[1], v[2]});
    using multires::MeshScheme;
    for (const MeshScheme scheme :
         {MeshScheme::Sqrt3, MeshScheme::Loop, MeshScheme::CatmullClark}) {
        const auto origin = multires::origin_of(*topology, points, {}, scheme, 30);
        if (!origin.ok()) continue;
        schemes.push_back(Json{{"name", multires::mesh_scheme_name(scheme)},
                               {"levels", origin->steps},
                               {"base_vertices", origin->base.vertex_count},
                               {"base_faces", origin->base.face_count}});
    }
    return schemes;
}

}  // namespace

Result<Outcome> info_of_mesh(const std::string& path) {
    RELIEF_TRY(const io::LoadedMesh loaded, io::read_mesh(path));
    const PolygonMesh& mesh = loaded.mesh;
    std::array<double, 3> low{INFINITY, INFINITY, INFINITY};
    std::array<double, 3> high{-INFINITY, -INFINITY, -INFINITY};
    for (const auto& vertex : mesh.vertices)
        for (std::size_t k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], vertex[k]);
            high[k] = std::max(high[k], vertex[k]);
        }
    std::int64_t quads = 0;
    for (std::int64_t k = 0; k < mesh.polygon_count(); ++k) quads += mesh.polygon(k).size() == 4;
    const auto diagnosis =
        mesh::diagnose(mesh::faces_of(mesh), static_cast<mesh::Index>(mesh.vertices.size()), 5);
    std::error_code ignored;
    const auto bytes = std::filesystem::file_size(path, ignored);
    Outcome outcome;
    outcome.json = Json{{"format", "mesh"},
                        {"version", nullptr},
                        {"scheme", nullptr},
                        {"order", nullptr},
                        {"levels", 0},
                        {"vertices", mesh.vertices.size()},
                        {"polygons", mesh.polygon_count()},
                        {"quads", quads},
                        {"bands", Json::array()},
                        {"bytes", bytes},
                        {"bound", nullptr},
                        {"crs", ""},
                        {"extent", Json::array({json_number(low[0]), json_number(low[1]),
                                                json_number(high[0]), json_number(high[1])})},
                        {"min", json_number(low[2])},
                        {"max", json_number(high[2])},
                        {"degenerate_facets", loaded.degenerate_facets},
                        {"healthy", diagnosis.healthy()},
                        {"problems", problems_json(diagnosis)},
                        {"schemes", schemes_of(mesh)},
                        {"checksums_ok", nullptr}};
    outcome.text = fmt::format("{}: mesh of {} vertices and {} polygons, {} of them quads\n", path,
                               grouped(static_cast<std::int64_t>(mesh.vertices.size())),
                               grouped(mesh.polygon_count()), grouped(quads));
    outcome.text +=
        fmt::format("x {} .. {}, y {} .. {}, z {} .. {}\n", shown(low[0]), shown(high[0]),
                    shown(low[1]), shown(high[1]), shown(low[2]), shown(high[2]));
    outcome.text += diagnosis.healthy() ? "an oriented manifold\n"
                                        : "no oriented manifold; '--repair' mends this:\n";
    for (const mesh::MeshProblem& problem : diagnosis.problems)
        outcome.text +=
            fmt::format("  {} {}: {}\n", element_of(problem), problem.element, problem.message);
    for (const Json& scheme : outcome.json["schemes"])
        outcome.text += fmt::format("subdivision connectivity: {}, {} levels over {} faces\n",
                                    scheme["name"].get<std::string>(), scheme["levels"].get<int>(),
                                    grouped(scheme["base_faces"].get<std::int64_t>()));
    return outcome;
}

}  // namespace relief::cli
