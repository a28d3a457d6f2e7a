#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "command.h"
#include "relief/io/file_kind.h"
#include "relief/io/mesh.h"
#include "relief/io/points.h"
#include "relief/io/raster.h"
#include "relief/io/synthetic.h"
#include "relief/io/synthetic_mesh.h"

namespace relief::cli {

namespace {

struct Sample {
    std::string name;
    std::string out;
    io::SyntheticOptions surface;
};

std::string joined(const std::vector<std::string_view>& names, const char* between) {
    std::string all;
    for (const std::string_view name : names)
        all += (all.empty() ? "" : between) + std::string(name);
    return all;
}

/// What NAME may be; some names are those of a raster and of a mesh.
std::vector<std::string_view> known_names() {
    std::vector<std::string_view> known = io::synthetic_names();
    for (const std::string_view name : io::synthetic_mesh_names())
        if (std::find(known.begin(), known.end(), name) == known.end()) known.push_back(name);
    known.emplace_back("terrain");
    return known;
}

Result<Outcome> run_mesh(const Sample& options) {
    RELIEF_TRY(const PolygonMesh mesh, io::synthetic_mesh(options.name, options.surface.size));
    RELIEF_TRY(const auto missing, io::write_mesh(options.out, mesh));
    Outcome outcome;
    outcome.json = Json{{"samples", mesh.vertices.size()}, {"faces", mesh.polygon_count()}};
    outcome.text = fmt::format("{}: {} vertices and {} faces of a {}\n", options.out,
                               mesh.vertices.size(), mesh.polygon_count(), options.name);
    return outcome;
}

/// The valid samples as points.
Result<Outcome> write_points(const std::string& path, const Raster& raster) {
    const std::array<double, 6> t =
        raster.geo.transform.value_or(std::array<double, 6>{-0.5, 1, 0, -0.5, 0, 1});
    std::array<std::vector<double>, 3> columns;
    for (std::int64_t r = 0; r < raster.rows; ++r)
        for (std::int64_t c = 0; c < raster.cols; ++c) {
            if (!raster.valid(r, c)) continue;
            const double col = static_cast<double>(c) + 0.5;
            const double row = static_cast<double>(r) + 0.5;
            columns[0].push_back(t[0] + t[1] * col + t[2] * row);
            columns[1].push_back(t[3] + t[4] * col + t[5] * row);
            columns[2].push_back(raster.planes.back()(r, c));
        }
    const std::array<io::CsvColumn, 3> table = {
        {{"x", columns[0]}, {"y", columns[1]}, {"z", columns[2]}}};
    RELIEF_CHECK(io::write_csv(path, table));
    Outcome outcome;
    outcome.json = Json{{"samples", columns[0].size()}};
    outcome.text =
        fmt::format("{}: {} points\n", path, grouped(static_cast<std::int64_t>(columns[0].size())));
    return outcome;
}

Result<Outcome> run(const Sample& options, const Globals& globals) {
    // "terrain" is what people ask for; ridged noise is what it is.
    const std::string name = options.name == "terrain" ? "ridged" : options.name;
    if (io::names_mesh(options.out)) return run_mesh(options);
    RELIEF_TRY(const Raster raster, io::synthetic(name, options.surface));
    if (io::names_points(options.out)) return write_points(options.out, raster);
    RELIEF_CHECK(
        io::write_raster(options.out, raster, {.progress = progress_bar(globals, "writing")}));
    Outcome outcome;
    outcome.json = Json{{"samples", raster.rows * raster.cols},
                        {"rows", raster.rows},
                        {"cols", raster.cols},
                        {"components", raster.planes.size()}};
    outcome.text =
        fmt::format("{}: {} x {} samples of {}\n", options.out, raster.cols, raster.rows, name);
    return outcome;
}

}  // namespace

void add_sample(Program& program) {
    auto options = std::make_shared<Sample>();
    CLI::App* verb = add_verb(
        program, "sample",
        "Write a synthetic surface to try things on: " + joined(io::synthetic_names(), ", ") + ".",
        "  relief sample ridged mountains.tif --size 1025 --seed 7\n"
        "  relief sample franke franke.tif --size 257\n"
        "  relief sample icosahedron icosahedron.obj\n"
        "  relief sample franke franke.csv --size 33",
        [options, &program] { return run(*options, program.globals); });
    verb->add_option(
            "NAME", options->name,
            "a raster: " + joined(io::synthetic_names(), ", ") +
                " (terrain is ridged); or a mesh: " + joined(io::synthetic_mesh_names(), ", "))
        ->required()
        ->type_name("TEXT:{" + joined(known_names(), ",") + "}");
    verb->add_option("OUT", options->out,
                     "the raster, mesh or points (.xyz, .csv); its extension names the format")
        ->required();
    verb->add_option("--size", options->surface.size, "samples a side (default 513)");
    verb->add_option("--seed", options->surface.seed, "which terrain (ridged)");
}

}  // namespace relief::cli
