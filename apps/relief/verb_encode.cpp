#include <fmt/format.h>

#include "command.h"
#include "mesh_verbs.h"
#include "ps_verbs.h"
#include "quad_verbs.h"
#include "relief/io/file.h"

namespace relief::cli {

namespace {

struct Encode {
    std::string in;
    std::string out;
    SchemeOptions scheme;
    std::optional<Length> max_error, rms_error;
    std::optional<double> keep, bytes;
    bool lossless = false;
    int effort = 1;
    std::string profile = "dense";
    bool surface = false;
    bool reorder = false;
    bool repair = false;
    bool over_uv = false;
    std::optional<double> alpha;
    std::string lift;
    bool remesh = false;
    RemeshFlags remesh_flags;
    ReferenceOptions reference;

    [[nodiscard]] bool of_diagonal() const {
        return (max_error && max_error->of_diagonal) || (rms_error && rms_error->of_diagonal);
    }
};

Result<codec::Goal> goal_of(const Encode& options) {
    using Kind = codec::Goal::Kind;
    if (options.max_error) return codec::Goal{Kind::MaxError, options.max_error->value};
    if (options.rms_error) return codec::Goal{Kind::RmsError, options.rms_error->value};
    if (options.keep) return codec::Goal{Kind::Keep, *options.keep};
    if (options.bytes) return codec::Goal{Kind::Bytes, *options.bytes};
    return codec::Goal{Kind::Lossless, 0};
}

std::string text_of(const Encode& options, const codec::EncodeReport& report,
                    const Raster& raster) {
    const std::string scheme =
        report.closed_loop
            ? fmt::format("fvs, closed loop, profile {}", options.profile)
            : fmt::format("{} order {}", multires::scheme_name(report.spec.id), report.spec.order);
    const std::string lattice =
        report.lattice > 0 && !is_integer(raster.type)
            ? fmt::format("samples are multiples of {}\n", shown(report.lattice))
            : "";
    const std::string unit = raster.unit.empty() ? "" : " " + raster.unit;
    std::string text = fmt::format(
        "{}: {} x {} samples -> {} bytes, {:.4g} bits a sample\n"
        "scheme {}{}, {} levels, {} of {} coefficients kept\n{}"
        "max error {}{}, rms error {}{}, error energy {:.4g} %\n",
        options.out, raster.cols, raster.rows, grouped(static_cast<std::int64_t>(report.bytes)),
        report.bits_per_sample, scheme,
        options.scheme.scheme.empty() ? " (best for this goal)" : "", report.spec.levels,
        grouped(report.kept), grouped(report.coefficients), lattice, shown(report.max_error), unit,
        shown(report.rms_error), unit, report.energy_percent);
    if (options.max_error)
        text +=
            fmt::format("bound {}{} verified at every valid sample\n", shown(report.bound), unit);
    return text;
}

Json json_of(const codec::EncodeReport& report, const std::string& profile, double seconds) {
    Json json{{"scheme", multires::scheme_name(report.spec.id)},
              {"order", report.spec.order},
              {"levels", report.spec.levels}};
    json.update(rate_json(report));
    json.update(Json{{"corrected", report.corrected},
                     {"closed_loop", report.closed_loop},
                     {"profile", report.closed_loop ? Json(profile) : Json(nullptr)},
                     {"lattice", report.lattice > 0 ? Json(report.lattice) : Json(nullptr)},
                     {"seconds", seconds}});
    return json;
}

MeshEncodeVerb mesh_verb(const Encode& options, const codec::Goal& goal) {
    using codec::MeshDistance;
    return {options.in,
            options.out,
            goal,
            options.surface || options.remesh ? MeshDistance::Surface : MeshDistance::Vertices,
            options.reorder,
            options.repair,
            options.alpha,
            options.lift,
            options.of_diagonal(),
            options.remesh ? std::optional(options.remesh_flags) : std::nullopt,
            options.effort};
}

/// Options that say how to remesh.
Status check_remesh(const Encode& options, const codec::Goal& goal) {
    const auto refuse = [](const char* why) { return Error{ErrorCode::InvalidArgument, why, ""}; };
    if (!options.remesh && !(options.remesh_flags == RemeshFlags()))
        return refuse("--base, --features and --tolerance are for --remesh");
    if (!options.remesh) return {};
    if (goal.kind == codec::Goal::Kind::Lossless)
        return refuse(
            "--remesh makes another mesh of the same shape, so that no file of it is "
            "lossless; say --max-error, --rms-error or --bytes");
    const std::string& scheme = options.scheme.scheme;
    if (!is_mesh(options.in) || !(scheme.empty() || scheme == "loop"))
        return refuse("--remesh is for meshes, with the scheme loop");
    return {};
}

/// Options that only subdivision surfaces have.
Status check_no_mesh_options(const Encode& options) {
    const auto refuse = [](const char* why) { return Error{ErrorCode::InvalidArgument, why, ""}; };
    if (options.alpha || !options.lift.empty())
        return refuse("--alpha and --lift are for subdivision surfaces");
    if (options.of_diagonal())
        return refuse("errors in diagonals (1e-4d) are for subdivision surfaces");
    if (options.surface)
        return refuse(
            "--surface is for subdivision surfaces; rasters and quads over the plane are measured "
            "sample by sample");
    return {};
}

/// Splines on triangles alone are told what their coordinates and values are.
Status check_no_reference(const Encode& options) {
    if (options.reference == ReferenceOptions()) return {};
    return Error{ErrorCode::InvalidArgument,
                 "--crs and --unit are for points, and for triangles with --scheme powell-sabin; "
                 "rasters bring their own",
                 ""};
}

/// As `fit`, which has more to choose from.
Result<Outcome> encode_points(const Encode& options, const codec::Goal& goal,
                              const Globals& globals) {
    SchemeOptions plain;
    plain.scheme = options.scheme.scheme;
    if (!(options.scheme == plain) || (!plain.scheme.empty() && plain.scheme != "powell-sabin"))
        return Error{ErrorCode::InvalidArgument,
                     "points have the scheme powell-sabin, without further options; see 'relief "
                     "fit --help'",
                     ""};
    return fit_points(
        {.in = options.in, .out = options.out, .goal = goal, .reference = options.reference},
        globals);
}

Result<Outcome> run(const Encode& options, const Globals& globals) {
    const Stopwatch watch;
    codec::EncodeOptions encode;
    RELIEF_TRY(encode.goal, goal_of(options));
    if (options.over_uv && (options.scheme.scheme != "powell-sabin" || !is_mesh(options.in)))
        return Error{ErrorCode::InvalidArgument, "--uv is for meshes with --scheme powell-sabin",
                     ""};
    RELIEF_CHECK(check_remesh(options, encode.goal));
    if (is_points(options.in)) {
        RELIEF_CHECK(check_no_mesh_options(options));
        return encode_points(options, encode.goal, globals);
    }
    if (is_mesh(options.in)) {
        if (options.scheme.scheme == "powell-sabin") {
            RELIEF_CHECK(check_no_mesh_options(options));
            return encode_triangles(
                {options.in, options.out, encode.goal, options.over_uv, options.reference},
                options.scheme, globals);
        }
        RELIEF_CHECK(check_no_reference(options));
        RELIEF_TRY(const bool subdivision, is_subdivision(options.in, options.scheme));
        if (subdivision || options.remesh)
            return encode_mesh(mesh_verb(options, encode.goal), options.scheme, globals);
        RELIEF_CHECK(check_no_mesh_options(options));
        return encode_quads(options.in, options.out, options.scheme, encode.goal);
    }
    RELIEF_CHECK(check_no_mesh_options(options));
    RELIEF_CHECK(check_no_reference(options));
    RELIEF_TRY(encode.spec, options.scheme.spec());
    encode.effort = static_cast<codec::Effort>(options.effort);
    encode.progress = progress_bar(globals, "encoding");
    encode.profile = options.profile == "fast" ? codec::Profile::Fast : codec::Profile::Dense;
    RELIEF_TRY(const auto source, open_raster(options.in, globals));
    RELIEF_TRY(io::OutputFile sink, io::OutputFile::create(options.out));
    io::FileSpool spool(options.out);
    const auto report = codec::encode_raster(*source, encode, sink, spool);
    if (!report.ok()) return located(report.error(), options.in);
    RELIEF_CHECK(sink.commit());
    Outcome outcome;
    outcome.json = json_of(*report, options.profile, watch.seconds());
    outcome.text = text_of(options, *report, source->description());
    return outcome;
}

}  // namespace

void add_encode(Program& program) {
    auto options = std::make_shared<Encode>();
    CLI::App* verb = add_verb(
        program, "encode",
        "Turn a raster, a mesh or points into a .relief file: analyse, choose coefficients, "
        "code.",
        "  relief encode dem.tif dem.relief --max-error 0.5\n"
        "  relief encode dem.tif dem.relief --rms-error 1 --scheme barycentric --order 2\n"
        "  relief encode dem.tif small.relief --bytes 20000 --json\n"
        "  relief encode model.obj model.relief --max-error 0.01",
        [options, &program] { return run(*options, program.globals); });
    verb->add_option(
            "IN", options->in,
            "a raster of any format GDAL reads, 1 to 4 bands; or a mesh (.obj, .off, .ply, "
            ".stl): the subdivision of a coarser one, or quads over the plane; or points (.xyz, "
            ".csv, .txt), see 'relief fit'")
        ->required();
    verb->add_option("OUT", options->out, "the .relief file")->required();
    options->scheme.add_to(*verb);
    CLI::Option_group* goal =
        verb->add_option_group("Goal", "one of these; without one the file is lossless");
    add_length(*goal, "--max-error", options->max_error,
               "largest error of any sample or vertex, in data units, or for meshes with a d in "
               "diagonals (1e-4d); verified");
    add_length(*goal, "--rms-error", options->rms_error,
               "largest root mean square error, in data units, or diagonals");
    goal->add_option("--keep", options->keep,
                     "only threshold: keep this many coefficients, in per cent of the samples");
    goal->add_option("--bytes", options->bytes, "largest size of the file");
    goal->add_flag("--lossless", options->lossless, "every sample exactly (default)");
    goal->require_option(0, 1);
    verb->add_option("--effort", options->effort,
                     "rasters: 0: weighted selection, 1: and least squares (default), 2: and "
                     "reselection. With --remesh: 0: one remesh, 1: a finer one where the goal "
                     "needs it (default), 2: bases and levels around it too, for the smallest "
                     "file; some ten times as long")
        ->check(CLI::Range(0, 2));
    verb->add_option(
            "--profile", options->profile,
            "of scheme fvs: dense (default), or fast: several times the speed, about 8 % larger")
        ->check(CLI::IsMember({"fast", "dense"}));
    options->reference.add_to(*verb);
    verb->add_flag("--surface", options->surface,
                   "meshes: errors are distances of the surfaces, both ways, and files smaller. "
                   "--max-error then holds for all vertices of both and for 60000 points spread "
                   "evenly over each; --rms-error is that of these points");
    verb->add_flag("--reorder", options->reorder,
                   "meshes: vertices and faces in the order of subdivision, which takes less");
    verb->add_flag("--remesh", options->remesh,
                   "meshes that are no subdivisions of anything: first make one of the same shape; "
                   "errors are distances from IN, both ways: see --surface and 'relief remesh'");
    options->remesh_flags.add_to(*verb);
    std::vector<std::string> lifts;
    lifts.reserve(std::size(multires::kLiftKinds));
    for (const multires::LiftKind kind : multires::kLiftKinds)
        lifts.emplace_back(multires::lift_name(kind));
    verb->add_option("--lift", options->lift,
                     "meshes: how coarse meshes are brought near to the fine ones; default: "
                     "chebyshev")
        ->check(CLI::IsMember(lifts));
    verb->add_option(
        "--alpha", options->alpha,
        "sqrt3: weight of the neighbours in the new place of a vertex, from 0 to below "
        "2/3; default: by valence");
    verb->add_flag("--uv", options->over_uv,
                   "meshes with --scheme powell-sabin: the triangles lie in the plane of their "
                   "texture coordinates, and x, y, z are a smooth surface in space over it");
    verb->add_flag("--repair", options->repair,
                   "meshes: first mend what is no oriented manifold: see 'relief info'");
}

}  // namespace relief::cli
