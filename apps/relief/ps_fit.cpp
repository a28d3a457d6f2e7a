#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mesh_verbs.h"
#include "ps_verbs.h"
#include "relief/codec/point_codec.h"
#include "relief/io/crs.h"
#include "relief/io/file.h"

namespace relief::cli {

namespace ps = multires::ps;

namespace {

Result<codec::PointMethod> method_of(const FitVerb& verb) {
    codec::FitWishes wishes{.levels = verb.levels, .smoothing = verb.smoothing};
    if (verb.vertices)
        wishes.vertices = static_cast<std::size_t>(std::max<std::int64_t>(*verb.vertices, 0));
    if (!verb.energy.empty())
        wishes.energy = verb.energy == "jumps" ? ps::Energy::Jump : ps::Energy::ThinPlate;
    if (!verb.gradients.empty()) {
        RELIEF_TRY(wishes.gradients, ps::gradient_rule_from_name(verb.gradients));
    }
    if (verb.vertices && !verb.mesh.empty())
        return Error{ErrorCode::InvalidArgument, "--vertices and --mesh exclude each other", ""};
    if (!verb.mesh.empty()) {
        RELIEF_TRY(const PolygonMesh mesh, read_polygons(verb.mesh));
        RELIEF_TRY(wishes.triangles, located(codec::triangulation_of(mesh), verb.mesh));
    }
    return codec::point_method(std::move(wishes), verb.goal);
}

Json report_json(const codec::PsReport& report) {
    Json json{{"scheme", "powell-sabin"}, {"order", 2}, {"levels", report.levels}};
    json.update(rate_json(report));
    json.update(Json{{"vertices", report.vertices},
                     {"triangles", report.triangles},
                     {"delaunay", report.delaunay},
                     {"base_bytes", report.base_bytes},
                     {"surface_bound", json_number(report.surface_bound)}});
    return json;
}

std::string text_of(const std::string& out, const codec::PsReport& report, const char* what,
                    const codec::PsReference& reference) {
    const std::string unit = reference.unit.empty() ? "" : " " + reference.unit;
    return fmt::format(
        "{}: {} {} -> {} bytes, {:.4g} bits each\n"
        "scheme powell-sabin on {} vertices and {} triangles, {} levels; {} of {} numbers kept\n"
        "max error {}{}, rms error {}{}\n",
        out, grouped(report.samples), what, grouped(static_cast<std::int64_t>(report.bytes)),
        report.bits_per_sample, grouped(report.vertices), grouped(report.triangles), report.levels,
        grouped(report.kept), grouped(report.coefficients), shown(report.max_error), unit,
        shown(report.rms_error), unit);
}

std::string notes_of(const codec::EncodedPoints& encoded, const std::optional<codec::Goal>& goal) {
    const auto count = [](std::size_t n, const char* what) {
        return n == 0 ? "" : fmt::format("{} {}\n", grouped(static_cast<std::int64_t>(n)), what);
    };
    std::string text;
    if (encoded.smoothing) text += fmt::format("smoothing {}\n", shown(*encoded.smoothing));
    text +=
        count(encoded.merged, "points lie where others do: the surface passes through the mean");
    text += count(encoded.outside, "points lie outside the mesh and were left out");
    if (encoded.beyond > 0)
        text += count(encoded.beyond, fmt::format("points are not within {}: {}",
                                                  shown(goal->value), encoded.reason)
                                          .c_str());
    return text;
}

}  // namespace

void ReferenceOptions::add_to(CLI::App& verb) {
    verb.add_option("--crs", crs,
                    "of the coordinates of points or triangles: EPSG:26911, WKT, a PROJ string or "
                    "a .prj file; kept in the file, and written to rasters decoded from it");
    verb.add_option("--unit", unit, "of their values: m, ft, ..; kept likewise");
}

Result<codec::PsReference> ReferenceOptions::reference() const {
    codec::PsReference reference{"", unit};
    if (crs.empty()) return reference;
    RELIEF_TRY(reference.crs, io::crs_from_user(crs));
    return reference;
}

Result<Outcome> fit_points(const FitVerb& verb, const Globals& globals) {
    const Stopwatch watch;
    RELIEF_TRY(const codec::PointMethod method, method_of(verb));
    RELIEF_TRY(const io::PointColumns columns, columns_of(verb.columns));
    RELIEF_TRY(const codec::PsReference reference, verb.reference.reference());
    RELIEF_TRY(io::PointSet points, io::read_points(verb.in, columns));
    const codec::PsData data{std::move(points.places), std::move(points.values),
                             std::move(points.weights)};
    const auto encoded =
        codec::encode_points(data, method, verb.goal, progress_bar(globals, "fitting"), reference);
    if (!encoded.ok()) return located(encoded.error(), verb.in);
    RELIEF_CHECK(io::write_file_atomically(verb.out, encoded->bytes));
    Outcome outcome;
    outcome.json = Json{{"points", data.points.size()}};
    outcome.json.update(report_json(encoded->report));
    const Json energy =
        encoded->smoothing ? Json(verb.energy == "jumps" ? "jumps" : "plate") : Json();
    outcome.json.update(Json{{"smoothing", json_number(encoded->smoothing)},
                             {"energy", energy},
                             {"merged", encoded->merged},
                             {"outside", encoded->outside},
                             {"beyond", encoded->beyond},
                             {"reason", encoded->reason},
                             {"seconds", watch.seconds()}});
    outcome.text = text_of(verb.out, encoded->report,
                           data.values.size() == 1 ? "points" : "numbers", reference) +
                   notes_of(*encoded, verb.goal);
    return outcome;
}

Result<Outcome> encode_triangles(const TrianglesVerb& verb, const SchemeOptions& scheme,
                                 const Globals& globals) {
    const Stopwatch watch;
    SchemeOptions plain;
    plain.scheme = scheme.scheme;
    if (!(scheme == plain))
        return Error{ErrorCode::InvalidArgument,
                     "--scheme powell-sabin takes a mesh as it is: --levels and options of other "
                     "schemes do not apply",
                     ""};
    RELIEF_TRY(const codec::PsReference reference, verb.reference.reference());
    RELIEF_TRY(const PolygonMesh polygons, read_polygons(verb.in));
    RELIEF_TRY(codec::PsModel model,
               located(verb.over_uv ? codec::model_over_uv(polygons) : codec::model_of(polygons),
                       verb.in));
    model.reference = reference;
    const auto encoded =
        codec::encode_ps(model, {.goal = verb.goal, .progress = progress_bar(globals, "encoding")});
    if (!encoded.ok()) return located(encoded.error(), verb.in);
    RELIEF_CHECK(io::write_file_atomically(verb.out, encoded->bytes));
    Outcome outcome;
    outcome.json = report_json(encoded->report);
    outcome.json["seconds"] = watch.seconds();
    outcome.text =
        text_of(verb.out, encoded->report, verb.over_uv ? "numbers" : "vertices", reference);
    return outcome;
}

}  // namespace relief::cli
