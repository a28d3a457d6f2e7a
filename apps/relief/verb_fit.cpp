#include "command.h"
#include "ps_verbs.h"

namespace relief::cli {

namespace {

struct Fit {
    FitVerb verb;
    std::optional<double> max_error, rms_error, bytes;
    bool lossless = false;
};

std::optional<codec::Goal> goal_of(const Fit& options) {
    using Kind = codec::Goal::Kind;
    if (options.max_error) return codec::Goal{Kind::MaxError, *options.max_error};
    if (options.rms_error) return codec::Goal{Kind::RmsError, *options.rms_error};
    if (options.bytes) return codec::Goal{Kind::Bytes, *options.bytes};
    if (options.lossless) return codec::Goal{Kind::Lossless, 0};
    return {};
}

}  // namespace

void add_fit(Program& program) {
    auto options = std::make_shared<Fit>();
    CLI::App* verb = add_verb(
        program, "fit",
        "Turn scattered points into a smooth (C1) surface: through all of them, within a bound, or "
        "by least squares on fewer vertices.",
        "  relief fit survey.xyz survey.relief\n"
        "  relief fit lidar.csv ground.relief --max-error 0.2\n"
        "  relief fit noisy.csv smooth.relief --vertices 500\n"
        "  relief fit soundings.csv bed.relief --mesh shore.obj --levels 1 --columns lon,lat,depth",
        [options, &program] {
            options->verb.goal = goal_of(*options);
            return fit_points(options->verb, program.globals);
        });
    FitVerb& fit = options->verb;
    verb->add_option("POINTS", fit.in, "a file of points: .xyz, .csv or .txt, one point a line")
        ->required();
    verb->add_option("OUT", fit.out, "the .relief file")->required();
    CLI::Option_group* goal = verb->add_option_group(
        "Goal",
        "one of these; without one least squares are coded to a thousandth of their error, "
        "everything else is lossless");
    goal->add_option(
        "--max-error", options->max_error,
        "largest error of any point, in data units; verified. Vertices are added where "
        "points need them");
    goal->add_option("--rms-error", options->rms_error,
                     "largest root mean square error of the points, in data units");
    goal->add_option("--bytes", options->bytes, "largest size of the file");
    goal->add_flag("--lossless", options->lossless, "keep every bit of the spline");
    goal->require_option(0, 1);
    verb->add_option("--vertices", fit.vertices,
                     "least squares on about so many vertices, spread over the points; with "
                     "--max-error: at most so many, and points beyond the bound are counted");
    verb->add_option("--mesh", fit.mesh,
                     "least squares on the triangles of this mesh, seen from above");
    verb->add_option("--levels", fit.levels,
                     "least squares: refine the triangles so often, each into nine; the file has "
                     "these levels")
        ->check(CLI::Range(0, 12));
    verb->add_option("--smoothing", fit.smoothing,
                     "least squares: weight of the energy, without a unit; default: by cross "
                     "validation, with --max-error 1e-10");
    verb->add_option("--energy", fit.energy,
                     "least squares: what smoothing makes small: plate (default), the bending "
                     "energy, which planes do not have, or jumps, those of second derivatives from "
                     "piece to piece, which quadratics do not have")
        ->check(CLI::IsMember({"plate", "jumps"}));
    verb->add_option(
            "--gradients", fit.gradients,
            "interpolation: rule for the slopes at the points (default adaptive; quadratic is "
            "for smooth data only)")
        ->type_name("TEXT:{adaptive,quadratic,plane,zero}");
    verb->add_option("--columns", fit.columns, kColumnsHelp);
    fit.reference.add_to(*verb);
}

}  // namespace relief::cli
