#include "mesh_verbs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "level_files.h"
#include "ps_verbs.h"
#include "quad_verbs.h"
#include "relief/codec/scan_codec.h"
#include "relief/io/file.h"
#include "relief/io/file_kind.h"
#include "relief/io/mesh.h"
#include "relief/mesh/closest.h"

namespace relief::cli {

namespace {

using multires::MeshScheme;

/// Options of other schemes.
Status check_scheme(const SchemeOptions& scheme) {
    SchemeOptions plain;
    const bool untouched = scheme.order == plain.order && scheme.family == plain.family &&
                           scheme.dual == plain.dual && scheme.map == plain.map && !scheme.exact;
    if (!untouched)
        return Error{ErrorCode::InvalidArgument,
                     "--order, --family, --dual, --map and --exact are for rasters", ""};
    if (scheme.levels < -1)
        return Error{ErrorCode::InvalidArgument, "--levels must not be negative", ""};
    return {};
}

std::string text_of(const std::string& out, codec::MeshDistance distance,
                    const codec::MeshReport& report) {
    std::string text = fmt::format(
        "{}: {} vertices, {} faces -> {} bytes, {:.4g} bits a vertex\n"
        "scheme {}, {} levels over {} faces; {} of {} vectors kept\n"
        "{}: max error {}, rms error {}\n",
        out, grouped(report.samples), grouped(report.faces),
        grouped(static_cast<std::int64_t>(report.bytes)), report.bits_per_sample,
        multires::mesh_scheme_name(report.scheme), report.levels, grouped(report.base_faces),
        grouped(report.kept), grouped(report.coefficients), mesh_distance_name(distance),
        shown(report.max_error), shown(report.rms_error));
    if (report.lost_creases > 0)
        text += fmt::format(
            "warning: crease_without_parent: {} sharp edges are no part of sharp edges of the "
            "coarser meshes; they stay sharp at the finest level only\n",
            report.lost_creases);
    return text;
}

struct Box {
    std::array<double, 3> low{INFINITY, INFINITY, INFINITY};
    std::array<double, 3> high{-INFINITY, -INFINITY, -INFINITY};

    explicit Box(const PolygonMesh& mesh) {
        for (const auto& v : mesh.vertices)
            for (std::size_t k = 0; k < 3; ++k) {
                low[k] = std::min(low[k], v[k]);
                high[k] = std::max(high[k], v[k]);
            }
    }
    [[nodiscard]] double largest_side() const {
        return std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
    }
};

bool set(codec::MeshMove& move, const std::vector<double>& numbers) {
    if (numbers.size() != 3) return false;
    std::copy(numbers.begin(), numbers.end(), move.delta.begin());
    return true;
}

constexpr FaceCount<mesh::MeshCounts> kFaces = {"faces", &mesh::MeshCounts::faces};

}  // namespace

bool holds_mesh(const std::string& path) {
    return holds(path, "mesh");
}

Result<codec::MeshFile> open_mesh_file(const std::string& path,
                                       std::optional<std::uint64_t> max_bytes) {
    return open_file<codec::MeshFile>(path, max_bytes);
}

Result<PolygonMesh> read_polygons(const std::string& path, int level) {
    if (holds_mesh(path)) {
        RELIEF_TRY(const codec::MeshFile file, open_mesh_file(path));
        auto mesh = file.decode(level);
        if (!mesh.ok()) return located(mesh.error(), path);
        return mesh;
    }
    if (holds_quads(path)) {
        RELIEF_TRY(const codec::QuadFile file, open_quads(path));
        auto mesh = file.decode(level);
        if (!mesh.ok()) return located(mesh.error(), path);
        return codec::polygons_of(*mesh);
    }
    if (holds_ps(path)) {
        RELIEF_TRY(const codec::PsFile file, open_ps(path));
        RELIEF_TRY(const codec::PsSurface surface, located(file.surface(level), path));
        return located(codec::polygons_of(file, surface), path);
    }
    if (level != 0) return Error{ErrorCode::InvalidArgument, "--level needs a .relief file", path};
    RELIEF_TRY(io::LoadedMesh loaded, io::read_mesh(path));
    return std::move(loaded.mesh);
}

Result<bool> is_subdivision(const std::string& path, const SchemeOptions& scheme) {
    if (!scheme.scheme.empty()) return scheme.scheme != "fvs";
    if (holds_mesh(path)) return true;
    if (holds_quads(path)) return false;
    RELIEF_TRY(const io::LoadedMesh loaded, io::read_mesh(path));
    const PolygonMesh& mesh = loaded.mesh;
    return mesh.polygon_count() > 0 && !codec::is_over_plane(mesh);
}

namespace {

/// A file, and what was remeshed for it.
struct RemeshedFile {
    std::optional<remesh::Remeshed> remeshed;
    codec::EncodedMesh encoded;
};

Result<RemeshedFile> encode_scan(const PolygonMesh& mesh, const MeshEncodeVerb& verb,
                                 const codec::MeshEncodeOptions& options, const Globals& globals) {
    codec::ScanEncodeOptions scan{.goal = options.goal,
                                  .base_faces = verb.remesh->base,
                                  .feature_degrees = verb.remesh->features,
                                  .tolerance = verb.remesh->tolerance_of(mesh),
                                  .effort = static_cast<codec::ScanEffort>(verb.effort),
                                  .lift = options.lift,
                                  .remeshing = progress_bar(globals, "remeshing"),
                                  .encoding = options.progress};
    if (options.levels >= 0) scan.levels = options.levels;
    RELIEF_TRY(auto made, codec::encode_scan(mesh, scan));
    return RemeshedFile{std::move(made.remeshed), std::move(made.encoded)};
}

}  // namespace

Result<Outcome> encode_mesh(const MeshEncodeVerb& verb, const SchemeOptions& scheme,
                            const Globals& globals) {
    const Stopwatch watch;
    RELIEF_CHECK(check_scheme(scheme));
    codec::MeshEncodeOptions options;
    options.goal = verb.goal;
    options.distance = verb.distance;
    options.levels = scheme.levels;
    // A remesh has no numbers that anyone knows.
    options.keep_order = !verb.reorder && !verb.remesh;
    options.progress = progress_bar(globals, "encoding");
    if (!scheme.scheme.empty()) {
        RELIEF_TRY(options.scheme, multires::mesh_scheme_from_name(scheme.scheme));
    }
    if (verb.alpha && options.scheme != MeshScheme::Sqrt3)
        return Error{ErrorCode::InvalidArgument, "--alpha is for --scheme sqrt3", ""};
    options.alpha = verb.alpha;
    for (const multires::LiftKind kind : multires::kLiftKinds)
        if (verb.lift == multires::lift_name(kind)) options.lift = kind;
    RELIEF_TRY(PolygonMesh mesh, read_polygons(verb.in));
    std::string repairs;
    if (verb.repair) {
        mesh::RepairedMesh repaired = mesh::repair(mesh);
        repairs = repair_text(repaired.counts);
        mesh = std::move(repaired.mesh);
    }
    if (verb.of_diagonal) options.goal.value *= diagonal_of(mesh);
    RemeshedFile made;
    if (verb.remesh) {
        RELIEF_TRY(made, located(encode_scan(mesh, verb, options, globals), verb.in));
    } else {
        RELIEF_TRY(made.encoded, located(codec::encode_mesh(mesh, options), verb.in));
    }
    const auto& [remeshed, encoded] = made;
    RELIEF_CHECK(io::write_file_atomically(verb.out, encoded.bytes));
    const codec::MeshReport& report = encoded.report;
    Outcome outcome;
    outcome.json = Json{{"scheme", multires::mesh_scheme_name(report.scheme)},
                        {"order", nullptr},
                        {"levels", report.levels}};
    outcome.json.update(rate_json(report));
    outcome.json.update(Json{{"faces", report.faces},
                             {"base_vertices", report.base_vertices},
                             {"base_faces", report.base_faces},
                             {"lost_creases", report.lost_creases},
                             {"distance", mesh_distance_name(verb.distance)},
                             {"seconds", watch.seconds()}});
    if (remeshed) outcome.json["remesh"] = remesh_json(*remeshed);
    outcome.text = repairs + (remeshed ? remesh_text(*remeshed) : "") +
                   text_of(verb.out, verb.distance, report);
    return outcome;
}

std::string left_out(const std::vector<std::string>& names) {
    if (names.empty()) return "";
    return fmt::format("the format can not hold: {}\n", fmt::join(names, ", "));
}

Result<Outcome> decode_mesh(const std::string& in, const std::string& out, int level,
                            std::optional<std::uint64_t> max_bytes) {
    const Stopwatch watch;
    RELIEF_TRY(const codec::MeshFile file, open_mesh_file(in, max_bytes));
    const auto mesh = file.decode(level);
    if (!mesh.ok()) return located(mesh.error(), in);
    RELIEF_TRY(const auto missing, io::write_mesh(out, *mesh));
    const std::optional<double> bound = file.bound(level);
    Outcome outcome;
    outcome.json = Json{{"samples", mesh->vertices.size()},
                        {"bytes_read", file.bytes_for(level)},
                        {"level", level},
                        {"bound", json_number(bound)},
                        {"vertices", mesh->vertices.size()},
                        {"faces", mesh->polygon_count()},
                        {"finest_level", file.finest_level()},
                        {"left_out", missing},
                        {"seconds", watch.seconds()}};
    outcome.text = fmt::format("{}: {} vertices and {} faces of level {}\n", out,
                               grouped(static_cast<std::int64_t>(mesh->vertices.size())),
                               grouped(mesh->polygon_count()), level);
    if (bound) outcome.text += fmt::format("within {} of the original\n", shown(*bound));
    outcome.text += left_out(missing);
    return outcome;
}

Result<Outcome> info_of_mesh_file(const std::string& path) {
    RELIEF_TRY(const codec::MeshFile file, open_mesh_file(path));
    const bool sound = file.checksums_ok();
    const Json levels = levels_json(file, kFaces);
    const char* scheme = multires::mesh_scheme_name(file.spec().scheme);
    const Json bands =
        bands_json(file, [&](int level) { return level == file.levels() ? "base" : "details"; });
    Outcome outcome;
    outcome.json = info_json(file,
                             {.content = "mesh",
                              .scheme = scheme,
                              .order = nullptr,
                              .more = Json{{"lossless", file.lossless()},
                                           {"step", json_number(file.step())},
                                           {"distance", mesh_distance_name(file.distance())}},
                              .bands = bands,
                              .levels = levels},
                             sound);
    outcome.text = head_text(path, file, sound);
    outcome.text += fmt::format("mesh of {} vertices and {} faces, scheme {}, {} levels{}\n",
                                grouped(static_cast<std::int64_t>(file.counts(0).vertices)),
                                grouped(static_cast<std::int64_t>(file.counts(0).faces)), scheme,
                                file.levels(), file.lossless() ? ", lossless" : "");
    outcome.text += file.edited() ? edits_text(file.moves().size()) + '\n'
                                  : fmt::format("{} within {} of the original (rms {})\n",
                                                mesh_distance_name(file.distance()),
                                                shown(file.max_error()), shown(file.rms_error()));
    outcome.text += levels_text(levels, kFaces.name);
    return outcome;
}

namespace {

Result<Outcome> compare_surfaces(const PolygonMesh& a, const PolygonMesh& b) {
    RELIEF_TRY(const mesh::SurfaceDistance distance, mesh::surface_distance(a, b));
    const double rms = distance.rms();
    const auto directed = [](const mesh::DirectedDistance& d) {
        return Json{{"max_error", json_number(d.largest)}, {"rms_error", json_number(d.rms)}};
    };
    Outcome outcome;
    outcome.json = Json{{"samples", 2 * 60000},
                        {"max_error", json_number(distance.largest())},
                        {"rms_error", json_number(rms)},
                        {"mean_square", json_number(rms * rms)},
                        {"psnr_db", json_number(20 * std::log10(diagonal_of(a) / rms))},
                        {"energy_percent", nullptr},
                        {"diagonal", json_number(diagonal_of(a))},
                        {"a_to_b", directed(distance.a_to_b)},
                        {"b_to_a", directed(distance.b_to_a)}};
    outcome.text = fmt::format(
        "surfaces: max distance {} (there {}, back {}), rms distance {} (there {}, back {}); "
        "diagonal {}\n",
        shown(distance.largest()), shown(distance.a_to_b.largest), shown(distance.b_to_a.largest),
        shown(rms), shown(distance.a_to_b.rms), shown(distance.b_to_a.rms), shown(diagonal_of(a)));
    return outcome;
}

}  // namespace

Result<Outcome> compare_meshes(const std::string& path_a, const std::string& path_b, bool surface) {
    const std::string both = path_a + " and " + path_b;
    if (!is_mesh(path_a) || !is_mesh(path_b))
        return Error{ErrorCode::BadInput, "a mesh and a raster can not be compared", both};
    RELIEF_TRY(const PolygonMesh a, read_polygons(path_a));
    RELIEF_TRY(const PolygonMesh b, read_polygons(path_b));
    if (surface) {
        auto outcome = compare_surfaces(a, b);
        if (!outcome.ok()) return located(outcome.error(), both);
        return outcome;
    }
    if (a.vertices.size() != b.vertices.size())
        return Error{ErrorCode::BadInput,
                     fmt::format("have {} and {} vertices; they are compared vertex by vertex; "
                                 "'--surface' measures the distance of the surfaces",
                                 a.vertices.size(), b.vertices.size()),
                     both};
    double most = 0;
    double sum = 0;
    std::size_t worst = 0;
    for (std::size_t v = 0; v < a.vertices.size(); ++v) {
        double square = 0;
        for (std::size_t k = 0; k < 3; ++k)
            square += std::pow(a.vertices[v][k] - b.vertices[v][k], 2);
        sum += square;
        if (std::sqrt(square) > most) worst = v;
        most = std::max(most, std::sqrt(square));
    }
    const Box box(a);
    const double mean = a.vertices.empty() ? 0 : sum / static_cast<double>(a.vertices.size());
    const bool differ = a.offsets != b.offsets || a.corners != b.corners;
    Outcome outcome;
    outcome.json =
        Json{{"samples", a.vertices.size()},
             {"max_error", json_number(most)},
             {"rms_error", json_number(std::sqrt(mean))},
             {"mean_square", json_number(mean)},
             {"psnr_db", json_number(20 * std::log10(box.largest_side() / std::sqrt(mean)))},
             {"energy_percent", nullptr},
             {"diagonal", json_number(diagonal_of(a))},
             {"worst", Json{{"vertex", worst}}},
             {"faces_differ", differ}};
    outcome.text = fmt::format("{} vertices: max error {} at vertex {}; rms error {}\n",
                               grouped(static_cast<std::int64_t>(a.vertices.size())), shown(most),
                               worst, shown(std::sqrt(mean)));
    if (differ) outcome.text += "the faces differ\n";
    return outcome;
}

Result<Outcome> edit_mesh(const std::string& in, const std::string& out, int level,
                          const std::vector<std::string>& texts) {
    RELIEF_TRY(const auto moves,
               parse_moves<codec::MeshMove>(texts, level, {"a mesh", "INDEX:DX,DY,DZ"}, set));
    RELIEF_TRY(Bytes bytes, with_moves(in, moves, codec::add_mesh_moves));
    return write_edited_mesh(in, out, std::move(bytes));
}

Result<Outcome> write_edited_mesh(const std::string& in, const std::string& out, Bytes edited) {
    RELIEF_TRY(const codec::MeshFile before_file, open_mesh_file(in));
    RELIEF_TRY(const PolygonMesh before, located(before_file.decode(0), in));
    RELIEF_TRY(const auto result, reopened<codec::MeshFile>(in, std::move(edited)));
    RELIEF_TRY(const PolygonMesh after, located(result.file.decode(0), in));
    RELIEF_CHECK(io::write_file_atomically(out, result.bytes));
    Touched<3> touched;
    for (std::size_t v = 0; v < before.vertices.size(); ++v)
        if (before.vertices[v] != after.vertices[v]) touched.add(after.vertices[v]);
    Outcome outcome;
    outcome.json = edit_json(before_file, result, touched);
    outcome.text = fmt::format("{}: {} vertices moved, {} vertices touched\n", out,
                               moves_added(before_file, result), grouped(touched.count()));
    return outcome;
}

}  // namespace relief::cli
