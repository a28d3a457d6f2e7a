#include "quad_verbs.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

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

/// The index and rise of "INDEX:DZ".
Result<codec::QuadMove> parse_move(const std::string& text, int level) {
    codec::QuadMove move{level, 0, 0};
    const char* end = text.data() + text.size();
    const auto index = std::from_chars(text.data(), end, move.vertex);
    if (index.ec == std::errc() && index.ptr != end && *index.ptr == ':') {
        const auto rise = std::from_chars(index.ptr + 1, end, move.rise);
        if (rise.ec == std::errc() && rise.ptr == end) return move;
    }
    return Error{ErrorCode::InvalidArgument, "--move of a mesh takes INDEX:DZ, not '" + text + "'",
                 ""};
}

struct Touched {
    std::int64_t vertices = 0;
    double low[2] = {INFINITY, INFINITY};
    double high[2] = {-INFINITY, -INFINITY};
};

Touched touched_by(const codec::QuadMesh& before, const codec::QuadMesh& after) {
    Touched touched;
    for (std::size_t v = 0; v < before.vertices.size(); ++v) {
        if (before.vertices[v][2] == after.vertices[v][2]) continue;
        ++touched.vertices;
        for (std::size_t k = 0; k < 2; ++k) {
            touched.low[k] = std::min(touched.low[k], after.vertices[v][k]);
            touched.high[k] = std::max(touched.high[k], after.vertices[v][k]);
        }
    }
    return touched;
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
    std::vector<codec::QuadMove> moves;
    for (const std::string& text : texts) {
        RELIEF_TRY(const codec::QuadMove move, parse_move(text, level));
        moves.push_back(move);
    }
    if (moves.empty())
        return Error{ErrorCode::InvalidArgument, "nothing to do; give --level K --move INDEX:DZ",
                     ""};
    RELIEF_TRY(Bytes bytes, io::read_file(in));
    const auto edited = codec::add_quad_moves(std::move(bytes), moves);
    if (!edited.ok()) return located(edited.error(), in);
    return write_edited_quads(in, out, *edited);
}

Result<Outcome> write_edited_quads(const std::string& in, const std::string& out,
                                   const Bytes& edited) {
    RELIEF_TRY(const codec::QuadFile before_file, open_quads(in));
    const auto before = before_file.decode(0);
    if (!before.ok()) return located(before.error(), in);
    const auto after_file = codec::QuadFile::open(edited);
    if (!after_file.ok()) return located(after_file.error(), in);
    const auto after = after_file->decode(0);
    if (!after.ok()) return located(after.error(), in);
    RELIEF_CHECK(io::write_file_atomically(out, edited));
    const Touched touched = touched_by(*before, *after);
    const std::size_t moved = after_file->moves().size() - before_file.moves().size();
    const Json bounds =
        touched.vertices == 0
            ? Json(nullptr)
            : Json::array({touched.low[0], touched.low[1], touched.high[0], touched.high[1]});
    Outcome outcome;
    outcome.json = Json{{"moved", moved},
                        {"touched", touched.vertices},
                        {"bounds", bounds},
                        {"edits", after_file->moves().size()},
                        {"bytes", edited.size()}};
    outcome.text = fmt::format("{}: {} vertices moved, {} vertices touched\n", out, moved,
                               grouped(touched.vertices));
    return outcome;
}

Result<std::vector<std::optional<std::array<double, 6>>>> evaluate_quads(
    const std::string& path, const std::vector<Vec2>& points) {
    RELIEF_TRY(const codec::QuadFile file, open_quads(path));
    const auto surface = file.surface(0);
    if (!surface.ok()) return located(surface.error(), path);
    std::vector<Vec2> inside;
    std::vector<std::size_t> which;
    for (std::size_t k = 0; k < points.size(); ++k) {
        if (!surface->hierarchy.locator().locate(points[k])) continue;
        inside.push_back(points[k]);
        which.push_back(k);
    }
    std::vector<spline::PlaneJet> jets(inside.size());
    const Status status = multires::fvs_mesh::evaluate(surface->hierarchy, surface->level(),
                                                       surface->data, inside, jets);
    if (!status.ok()) return located(status.error(), path);
    std::vector<std::optional<std::array<double, 6>>> found(points.size());
    for (std::size_t k = 0; k < jets.size(); ++k) {
        const spline::PlaneJet& jet = jets[k];
        found[which[k]] = {jet.value, jet.gradient.x, jet.gradient.y, jet.xx, jet.xy, jet.yy};
    }
    return found;
}

}  // namespace relief::cli
