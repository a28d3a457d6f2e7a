#include <fmt/format.h>

#include <cstdio>
#include <new>

#include "command.h"
#include "relief/core/parallel.h"

namespace {

using relief::ErrorCode;
using relief::cli::Outcome;
using relief::cli::Program;

constexpr int kDone = 0;
constexpr int kBadData = 1;
constexpr int kWrongUsage = 2;

void print(const Program& program, const Outcome& outcome) {
    if (program.globals.json)
        fmt::print("{}\n", outcome.json.dump(-1, ' ', false, relief::cli::Json::error_handler_t::replace));
    else if (outcome.text_is_data || !program.globals.quiet)
        fmt::print("{}", outcome.text);
}

int run(Program& program) {
    relief::set_thread_count(program.globals.threads);
    const auto outcome = program.chosen();
    if (!outcome.ok()) {
        fmt::print(stderr, "relief {}: {}\n", program.verb, outcome.error().text());
        return outcome.error().code == ErrorCode::InvalidArgument ? kWrongUsage : kBadData;
    }
    print(program, *outcome);
    if (std::fflush(stdout) == 0) return kDone;
    fmt::print(stderr, "relief {}: standard output can not be written\n", program.verb);
    return kBadData;
}

}  // namespace

int main(int argc, char** argv) {
    Program program;
    CLI::App& app = program.app;
    app.description("relief: surfaces as multiresolution splines. Encode, decode, compare, evaluate, edit and draw.");
    app.name("relief");
    app.set_version_flag("--version", "relief " RELIEF_VERSION);
    app.require_subcommand(1);
    app.footer("'relief VERB --help' explains a verb. Exit status: 0 done, 1 bad data or file, 2 wrong usage.");
    relief::cli::add_encode(program);
    relief::cli::add_decode(program);
    relief::cli::add_info(program);
    relief::cli::add_compare(program);
    relief::cli::add_eval(program);
    relief::cli::add_edit(program);
    relief::cli::add_render(program);
    relief::cli::add_sample(program);
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& success) {
        return app.exit(success);
    } catch (const CLI::ParseError& error) {
        fmt::print(stderr, "relief: {}; see 'relief --help'\n", error.what());
        return kWrongUsage;
    }
    relief::cli::stop_on_interrupt();
    try {
        return run(program);
    } catch (const std::bad_alloc&) {
        fmt::print(stderr, "relief {}: not enough memory; cut the raster into parts\n", program.verb);
        return kBadData;
    }
}
