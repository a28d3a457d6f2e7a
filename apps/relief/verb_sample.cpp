#include <fmt/format.h>

#include <algorithm>

#include "command.h"
#include "relief/io/raster.h"
#include "relief/io/synthetic.h"

namespace relief::cli {

namespace {

struct Sample {
    std::string name;
    std::string out;
    io::SyntheticOptions surface;
};

std::string known_names() {
    std::string known;
    for (const std::string_view name : io::synthetic_names())
        known += (known.empty() ? "" : ", ") + std::string(name);
    return known;
}

Result<Outcome> run(const Sample& options, const Globals& globals) {
    // "terrain" is what people ask for; ridged noise is what it is.
    const std::string name = options.name == "terrain" ? "ridged" : options.name;
    RELIEF_TRY(const Raster raster, io::synthetic(name, options.surface));
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
    CLI::App* verb = add_verb(program, "sample",
                              "Write a synthetic surface to try things on: " + known_names() + ".",
                              "  relief sample ridged mountains.tif --size 1025 --seed 7\n"
                              "  relief sample franke franke.tif --size 257",
                              [options, &program] { return run(*options, program.globals); });
    verb->add_option("NAME", options->name, known_names() + " (terrain is ridged)")->required();
    verb->add_option("OUT", options->out, "the raster; its extension names the format")->required();
    verb->add_option("--size", options->surface.size, "samples a side (default 513)");
    verb->add_option("--seed", options->surface.seed, "which terrain (ridged)");
}

}  // namespace relief::cli
