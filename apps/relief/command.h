#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "relief/codec/raster_codec.h"
#include "relief/core/raster.h"
#include "relief/core/result.h"
#include "relief/core/stream.h"

/// What all verbs of the command line program share.
namespace relief::cli {

using Json = nlohmann::ordered_json;

/// Options before or after the verb.
struct Globals {
    bool json = false;
    bool quiet = false;
    bool verbose = false;
    int threads = 0;
};

/// What a verb has to say: as JSON for programs, as text for people. Text that is data (CSV) is
/// printed with -q too.
struct Outcome {
    Json json = Json::object();
    std::string text;
    bool text_is_data = false;
    bool said = false;  ///< the verb printed it already, while it ran
};

using Run = std::function<Result<Outcome>()>;

/// A program with verbs; each verb's file adds itself.
struct Program {
    CLI::App app;
    Globals globals;
    Run chosen;
    std::string verb;
};

/// Adds a verb with its description, an example for --help, and the common options; `run` is called
/// after parsing.
CLI::App* add_verb(Program& program, const std::string& name, const std::string& description,
                   const std::string& examples, Run run);

/// An option for a length, which may have a d behind it: so many diagonals.
void add_length(CLI::App& options, const std::string& name, std::optional<double>& length,
                bool& of_diagonal, const std::string& description);

void add_encode(Program& program);
void add_decode(Program& program);
void add_info(Program& program);
void add_compare(Program& program);
void add_eval(Program& program);
void add_edit(Program& program);
void add_render(Program& program);
void add_sample(Program& program);
void add_subdivide(Program& program);
void add_remesh(Program& program);
void add_fit(Program& program);
void add_shard(Program& program);
void add_merge(Program& program);
void add_view(Program& program);

/// A bar on standard error, on a terminal only, unless quiet; cancels on Ctrl-C.
[[nodiscard]] Progress progress_bar(const Globals& globals, std::string what);
/// Ctrl-C and termination ask the running verb to stop, so that it leaves nothing behind.
void stop_on_interrupt();

/// Numbers for people: about 6 significant digits.
[[nodiscard]] std::string shown(double value);
/// 1234567 -> "1 234 567".
[[nodiscard]] std::string grouped(std::int64_t value);
/// JSON has no NaN or infinity: null.
[[nodiscard]] Json json_number(double value);
[[nodiscard]] Json json_number(const std::optional<double>& value);

/// The chunks of a file, as `info` lists them. Requires: what a File's `chunks()` gives has kind,
/// level, bytes, count and max_error.
template <class File>
[[nodiscard]] Json chunks_json(const File& file) {
    Json chunks = Json::array();
    for (const auto& chunk : file.chunks())
        chunks.push_back(Json{{"kind", chunk.kind},
                              {"level", chunk.level},
                              {"bytes", chunk.bytes},
                              {"count", chunk.count},
                              {"max_error", json_number(chunk.max_error)}});
    return chunks;
}

/// What every encoder reports of sizes and errors.
template <class Report>
[[nodiscard]] Json rate_json(const Report& report) {
    return Json{{"samples", report.samples},
                {"coefficients", report.coefficients},
                {"kept", report.kept},
                {"bytes", report.bytes},
                {"bits_per_sample", report.bits_per_sample},
                {"max_error", report.max_error},
                {"rms_error", report.rms_error},
                {"energy_percent", report.energy_percent},
                {"bound", report.bound}};
}

/// Seconds since construction.
class Stopwatch {
  public:
    Stopwatch();
    [[nodiscard]] double seconds() const;

  private:
    double start_;
};

/// Options that choose a scheme.
struct SchemeOptions {
    std::string scheme;  ///< empty: what is best for the goal
    int order = 2;
    int levels = -1;
    std::string family = "compact";
    int dual = 0;
    std::string map = "interpolate";
    bool exact = false;

    void add_to(CLI::App& app);
    /// None: no scheme was named. Options of schemes without a scheme are those of box.
    [[nodiscard]] Result<std::optional<multires::SchemeSpec>> spec() const;

    friend bool operator==(const SchemeOptions&, const SchemeOptions&) = default;
};

/// The same error, saying which file it is about.
[[nodiscard]] Error located(Error error, const std::string& path);
template <class T>
[[nodiscard]] Result<T> located(Result<T> result, const std::string& path) {
    if (result.ok()) return result;
    return located(result.error(), path);
}

/// Opens a .relief file or its first `max_bytes` bytes.
[[nodiscard]] Result<codec::RasterFile> open_relief(const std::string& path,
                                                    std::optional<std::uint64_t> max_bytes = {});

/// A raster of any kind, read in windows: .relief files are decoded. Errors: as read_any_raster.
[[nodiscard]] Result<std::unique_ptr<RasterSource>> open_raster(const std::string& path,
                                                                const Globals& globals);

/// Reads a raster of any kind: .relief files are decoded. Meshes and points are refused with the
/// reason.
[[nodiscard]] Result<Raster> read_any_raster(const std::string& path, const Globals& globals);

}  // namespace relief::cli
