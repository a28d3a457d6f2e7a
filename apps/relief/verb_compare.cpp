#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "command.h"
#include "mesh_verbs.h"
#include "ps_verbs.h"
#include "quad_verbs.h"
#include "relief/codec/measure.h"
#include "relief/io/file_kind.h"

namespace relief::cli {

namespace {

struct Compare {
    std::string a;
    std::string b;
    bool surface = false;
    std::optional<std::string> scheme;
    std::optional<int> order;
    std::optional<int> levels;
    std::string columns;
};

/// What the metadata of a decoded raster say of its origin; other programs' may say anything.
std::optional<multires::SchemeSpec> scheme_in(const Raster& raster) {
    const auto item = [&](std::string_view key) {
        const auto found = std::find_if(raster.metadata.begin(), raster.metadata.end(),
                                        [&](const auto& m) { return m.first == key; });
        return found == raster.metadata.end() ? std::string_view()
                                              : std::string_view(found->second);
    };
    const auto number = [](std::string_view text, int& value) {
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        return error == std::errc() && end == text.data() + text.size();
    };
    constexpr std::string_view between = " order ";
    const std::string_view name = item("RELIEF_SCHEME");
    const std::size_t space = name.find(between);
    if (space == std::string_view::npos) return {};
    multires::SchemeSpec spec;
    const auto id = multires::scheme_from_name(name.substr(0, space));
    if (!id.ok() || !number(name.substr(space + between.size()), spec.order) ||
        !number(item("RELIEF_LEVELS"), spec.levels))
        return {};
    spec.id = *id;
    if (spec.id == multires::SchemeId::Fvs) return spec;
    if (!multires::layout(spec, raster.rows, raster.cols, 1).ok()) return {};
    return spec;
}

/// Whose coarsest reconstruction is the base of energy_percent: what the options say, what B is or
/// says of its origin, the default scheme with the three levels of the source paper.
Result<multires::SchemeSpec> energy_scheme(const Compare& options, const Raster& b) {
    multires::SchemeSpec spec;
    spec.levels = 3;
    if (io::recognise(options.b) == io::FileKind::Relief) {
        RELIEF_TRY(const codec::RasterFile file, open_relief(options.b));
        spec = file.spec();
    } else if (const auto origin = scheme_in(b)) {
        spec = *origin;
    }
    if (options.scheme) {
        RELIEF_TRY(spec.id, multires::scheme_from_name(*options.scheme));
    }
    if (options.order) spec.order = *options.order;
    if (options.levels) spec.levels = *options.levels;
    return spec;
}

double diagonal_of(const Raster& raster, double range) {
    double width = static_cast<double>(raster.cols);
    double height = static_cast<double>(raster.rows);
    if (raster.geo.transform) {
        const auto& t = *raster.geo.transform;
        width *= std::hypot(t[1], t[4]);
        height *= std::hypot(t[2], t[5]);
    }
    return std::sqrt(width * width + height * height + range * range);
}

Result<Outcome> run(const Compare& options, const Globals& globals) {
    if (is_mesh(options.a) || is_mesh(options.b))
        return compare_meshes(options.a, options.b, options.surface);
    if (options.surface)
        return Error{ErrorCode::InvalidArgument,
                     "--surface compares meshes; rasters are compared sample by sample", ""};
    if (is_points(options.a) || is_points(options.b) || holds_ps(options.a) || holds_ps(options.b))
        return compare_ps(options.a, options.b, options.columns);
    RELIEF_TRY(const Raster a, read_any_raster(options.a, globals));
    RELIEF_TRY(const Raster b, read_any_raster(options.b, globals));
    auto measured = codec::measure(a, b);
    if (!measured.ok()) {
        Error located = measured.error();
        located.where = options.a + " and " + options.b;
        return located;
    }
    const codec::Measure& m = *measured;
    RELIEF_TRY(multires::SchemeSpec spec, energy_scheme(options, b));
    auto energy = codec::detail_energy(a, spec);
    if (!energy.ok() && !options.levels) {
        spec.levels = -1;
        energy = codec::detail_energy(a, spec);
    }
    if (!energy.ok()) return energy.error();
    const double square = m.mean_square * static_cast<double>(m.samples);
    const double percent = *energy > 0 ? 100 * square / *energy : 0;
    const std::string unit = a.unit.empty() ? "" : " " + a.unit;
    Outcome outcome;
    outcome.json = Json{{"samples", m.samples},
                        {"max_error", m.max_error},
                        {"rms_error", m.rms_error},
                        {"mean_square", m.mean_square},
                        {"psnr_db", json_number(m.psnr_db)},
                        {"energy_percent", percent},
                        {"diagonal", diagonal_of(a, m.range)},
                        {"worst", Json{{"row", m.worst_row}, {"col", m.worst_col}}},
                        {"mask_differs", m.mask_differs}};
    outcome.text = fmt::format(
        "{} samples: max error {}{} at row {}, column {}; rms error {}{}; PSNR {} dB; error energy "
        "{:.4g} %\n",
        grouped(m.samples), shown(m.max_error), unit, m.worst_row, m.worst_col, shown(m.rms_error),
        unit, std::isfinite(m.psnr_db) ? fmt::format("{:.2f}", m.psnr_db) : "infinite", percent);
    if (m.mask_differs > 0)
        outcome.text +=
            fmt::format("{} samples are a hole in one of them only\n", grouped(m.mask_differs));
    return outcome;
}

}  // namespace

void add_compare(Program& program) {
    auto options = std::make_shared<Compare>();
    CLI::App* verb = add_verb(
        program, "compare",
        "Measure how far B is from the reference A, sample by sample, vertex by vertex or "
        "at points.",
        "  relief compare dem.tif decoded.tif\n  relief compare dem.tif dem.relief --json\n"
        "  relief compare survey.xyz survey.relief",
        [options, &program] { return run(*options, program.globals); });
    verb->add_option("A", options->a, "the reference: a raster, a mesh, points or a .relief file")
        ->required();
    verb->add_option("B", options->b, "what is compared to it")->required();
    verb->add_flag("--surface", options->surface, "distance between surfaces (meshes)");
    verb->add_option(
        "--scheme", options->scheme,
        "scheme whose coarsest level is the base of energy_percent; default: that of B, else box");
    verb->add_option("--order", options->order, "its order");
    verb->add_option("--levels", options->levels, "its levels; default: those of B, else 3");
    verb->add_option("--columns", options->columns, kColumnsHelp);
}

}  // namespace relief::cli
