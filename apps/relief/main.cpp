#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <new>
#include <string_view>

#include "command.h"
#include "describe.h"
#include "relief/core/parallel.h"

namespace {

using relief::ErrorCode;
using relief::cli::Outcome;
using relief::cli::Program;

constexpr int kDone = 0;
constexpr int kBadData = 1;
constexpr int kWrongUsage = 2;

/// Standard streams may be closed or full: no exception for that, and false on standard output.
bool put(std::FILE* stream, std::string_view text) {
    return std::fwrite(text.data(), 1, text.size(), stream) == text.size() &&
           std::fflush(stream) == 0;
}

/// One line on standard error; what libraries say may have more.
int fail(int status, const std::string& who, std::string message) {
    std::replace(message.begin(), message.end(), '\n', ' ');
    put(stderr, fmt::format("{}: {}\n", who, message));
    return status;
}

bool print(const Program& program, const Outcome& outcome) {
    if (outcome.said) return true;
    if (program.globals.json)
        return put(
            stdout,
            outcome.json.dump(-1, ' ', false, relief::cli::Json::error_handler_t::replace) + "\n");
    return (!outcome.text_is_data && program.globals.quiet) || put(stdout, outcome.text);
}

int run(Program& program) {
    relief::set_thread_count(program.globals.threads);
    const std::string who = "relief " + program.verb;
    const auto outcome = program.chosen();
    if (!outcome.ok())
        return fail(outcome.error().code == ErrorCode::InvalidArgument ? kWrongUsage : kBadData,
                    who, outcome.error().text());
    if (print(program, *outcome)) return kDone;
    return fail(kBadData, who,
                "standard output: can not be written; free some space or write elsewhere");
}

/// What was asked, as far as it was understood: "relief encode".
std::string called(const CLI::App& app) {
    const auto verbs = app.get_subcommands();
    return verbs.empty() ? app.get_name() : app.get_name() + " " + verbs.front()->get_name();
}

}  // namespace

int main(int argc, char** argv) {
    Program program;
    CLI::App& app = program.app;
    app.description(
        "relief: surfaces as multiresolution splines. Encode, decode, compare, evaluate, edit and "
        "draw.");
    app.name("relief");
    app.set_version_flag("--version", "relief " RELIEF_VERSION);
    app.require_subcommand(1);
    app.footer(
        "'relief VERB --help' explains a verb. Exit status: 0 done, 1 bad data or file, 2 wrong "
        "usage.");
    relief::cli::add_encode(program);
    relief::cli::add_decode(program);
    relief::cli::add_info(program);
    relief::cli::add_compare(program);
    relief::cli::add_eval(program);
    relief::cli::add_edit(program);
    relief::cli::add_render(program);
    relief::cli::add_sample(program);
    relief::cli::add_subdivide(program);
    relief::cli::add_remesh(program);
    relief::cli::add_fit(program);
    relief::cli::add_shard(program);
    relief::cli::add_merge(program);
#if RELIEF_HAS_EDITOR
    relief::cli::add_view(program);
#endif
    app.add_flag_callback(
           "--describe",
           [&app] { throw CLI::CallForVersion(relief::cli::described(app).dump(), 0); })
        ->group("");  // not for people: tools/make_man and others read it
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& success) {
        return app.exit(success);
    } catch (const CLI::ParseError& error) {
        const std::string who = called(app);
        if (who == app.get_name() && argc > 1 && argv[1][0] != '-')
            return fail(kWrongUsage, who,
                        fmt::format("there is no verb '{}'; see '{} --help'", argv[1], who));
        return fail(kWrongUsage, who, fmt::format("{}; see '{} --help'", error.what(), who));
    }
    relief::cli::stop_on_interrupt();
    std::signal(SIGXFSZ,
                SIG_IGN);  // a file that may not grow is an error of the write, not a death
    try {
        return run(program);
    } catch (const std::bad_alloc&) {
        return fail(kBadData, "relief " + program.verb,
                    "not enough memory; cut the raster into parts");
    }
}
