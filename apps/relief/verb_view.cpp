#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "browser.h"
#include "command.h"
#include "server.h"
#include "view_files.h"

namespace relief::cli {

namespace {

struct View {
    std::string in;
    std::string save;
    std::uint16_t port = 0;
    bool no_browser = false;
};

/// "dem.tif" -> "dem-edited.relief", beside it.
std::string edited_name(const std::string& in) {
    const std::filesystem::path path(in);
    return (path.parent_path() / path.stem()).string() + "-edited.relief";
}

void announce(const std::string& url, const View& options, const Globals& globals) {
    const std::string text =
        globals.json ? Json{{"url", url}}.dump() + "\n"
                     : fmt::format("{}\nends when the page is closed, or with Ctrl-C\n", url);
    if (globals.json || !globals.quiet) std::fputs(text.c_str(), stdout);
    std::fflush(stdout);
    if (!options.no_browser && !open_browser(url) && !globals.quiet)
        std::fputs("no browser can be started; open the address yourself\n", stderr);
}

Result<Outcome> run(const View& options, const Globals& globals) {
    RELIEF_TRY(editor::Document document,
               open_document(options.in, progress_bar(globals, "opening")));
    document.save = options.save.empty() ? edited_name(options.in) : options.save;
    RELIEF_CHECK(editor::serve(
        std::move(document),
        {.port = options.port,
         .files = {.open = open_dropped, .decode = export_level},
         .listening = [&](const std::string& url) { announce(url, options, globals); }}));
    Outcome outcome;
    outcome.said = true;
    return outcome;
}

}  // namespace

void add_view(Program& program) {
    auto options = std::make_shared<View>();
    CLI::App* verb =
        add_verb(program, "view",
                 "Show and edit a surface in the browser, at any level. Serves this computer only.",
                 "  relief view dem.relief\n"
                 "  relief view dem.tif --save valley.relief\n"
                 "  relief view model.obj --port 8000 --no-browser",
                 [options, &program] { return run(*options, program.globals); });
    verb->add_option("IN", options->in,
                     "a .relief file, or a raster, mesh or points, which are encoded in memory "
                     "without loss")
        ->required();
    verb->add_option("--save", options->save,
                     "what the editor saves to; default: IN with -edited.relief in place of its "
                     "extension");
    verb->add_option("--port", options->port, "of 127.0.0.1; default: any that is free");
    verb->add_flag("--no-browser", options->no_browser,
                   "only print the address; with --json as {\"url\": ..} at once");
}

}  // namespace relief::cli
