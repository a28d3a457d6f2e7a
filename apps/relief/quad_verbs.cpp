#include "quad_verbs.h"

#include <fmt/format.h>

#include "level_files.h"
#include "relief/io/file.h"

namespace relief::cli {

namespace {

/// Meshes have one scheme, without options but --levels.
Status check_scheme(const SchemeOptions& scheme) {
    SchemeOptions plain;
    plain.levels = scheme.levels;
    const bool untouched = scheme.order == plain.order && scheme.family == plain.family &&
                           scheme.dual == plain.dual && scheme.map == plain.map && !scheme.exact;
    if (!scheme.scheme.empty() && scheme.scheme != "fvs")
        return Error{ErrorCode::InvalidArgument,
                     "meshes are coded with --scheme fvs, not " + scheme.scheme, ""};
    if (!untouched)
        return Error{ErrorCode::InvalidArgument,
                     "--order, --family, --dual, --map and --exact are for rasters", ""};
    if (scheme.levels < -1)
        return Error{ErrorCode::InvalidArgument, "--levels must not be negative", ""};
    return {};
}

bool set(codec::QuadMove& move, const std::vector<double>& numbers) {
    if (numbers.size() != 1) return false;
    move.rise = numbers[0];
    return true;
}

}  // namespace

Result<Outcome> encode_quads(const std::string& in, const std::string& out,
                             const SchemeOptions& scheme, const codec::Goal& goal) {
    const Stopwatch watch;
    RELIEF_CHECK(check_scheme(scheme));
    RELIEF_TRY(const codec::QuadMesh mesh, read_quads(in));
    const auto encoded = codec::encode_quads(mesh, {.goal = goal, .levels = scheme.levels});
    if (!encoded.ok()) return located(encoded.error(), in);
    RELIEF_CHECK(io::write_file_atomically(out, encoded->bytes));
    const codec::QuadReport& report = encoded->report;
    Outcome outcome;
    outcome.json = Json{{"scheme", "fvs"}, {"order", 3}, {"levels", report.levels}};
    outcome.json.update(rate_json(report));
    outcome.json.update(Json{{"surface_bound", json_number(report.surface_bound)},
                             {"quads", mesh.quads.size()},
                             {"seconds", watch.seconds()}});
    outcome.text = fmt::format(
        "{}: {} vertices, {} quads -> {} bytes, {:.4g} bits a vertex\n"
        "scheme fvs, {} levels, {} of {} numbers kept\n"
        "vertices: max error {}, rms error {}; surface within {} of the original one\n",
        out, grouped(report.samples), grouped(static_cast<std::int64_t>(mesh.quads.size())),
        grouped(static_cast<std::int64_t>(report.bytes)), report.bits_per_sample, report.levels,
        grouped(report.kept), grouped(report.coefficients), shown(report.max_error),
        shown(report.rms_error), shown(report.surface_bound));
    return outcome;
}

Result<Outcome> edit_quads(const std::string& in, const std::string& out, int level,
                           const std::vector<std::string>& texts) {
    RELIEF_TRY(const auto moves,
               parse_moves<codec::QuadMove>(texts, level, {"a mesh", "INDEX:DZ"}, set));
    RELIEF_TRY(Bytes bytes, with_moves(in, moves, codec::add_quad_moves));
    return write_edited_quads(in, out, std::move(bytes));
}

Result<Outcome> write_edited_quads(const std::string& in, const std::string& out, Bytes edited) {
    RELIEF_TRY(const codec::QuadFile before_file, open_quads(in));
    RELIEF_TRY(const codec::QuadMesh before, located(before_file.decode(0), in));
    RELIEF_TRY(const auto result, reopened<codec::QuadFile>(in, std::move(edited)));
    RELIEF_TRY(const codec::QuadMesh after, located(result.file.decode(0), in));
    RELIEF_CHECK(io::write_file_atomically(out, result.bytes));
    Touched<2> touched;
    for (std::size_t v = 0; v < before.vertices.size(); ++v)
        if (before.vertices[v][2] != after.vertices[v][2])
            touched.add({after.vertices[v][0], after.vertices[v][1]});
    Outcome outcome;
    outcome.json = edit_json(before_file, result, touched);
    outcome.text = fmt::format("{}: {} vertices moved, {} vertices touched\n", out,
                               moves_added(before_file, result), grouped(touched.count()));
    return outcome;
}

}  // namespace relief::cli
