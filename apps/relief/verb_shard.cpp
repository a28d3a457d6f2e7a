#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <sstream>
#include <string_view>

#include "command.h"
#include "relief/codec/raster_shards.h"
#include "relief/io/file.h"

namespace relief::cli {

namespace {

struct Shard {
    std::string in;
    std::string out;
    std::string plan;   ///< empty: make the plan
    std::string tiles;  ///< empty: all that the plan lacks
    std::optional<double> max_error;
    std::string profile = "dense";
};

using Tiles = std::vector<std::int64_t>;

/// A number that fills the text; -1: it does not.
std::int64_t number_of(std::string_view text) {
    std::int64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc() && end == text.data() + text.size() ? number : -1;
}

/// "0-5,9".
Result<Tiles> tiles_of(const std::string& text, const codec::RasterPlan& plan) {
    if (text.empty()) return plan.missing_tiles();
    const std::int64_t count = plan.tile_rows() * plan.tile_cols();
    Tiles tiles;
    std::istringstream ranges(text);
    for (std::string range; std::getline(ranges, range, ',');) {
        const std::size_t dash = range.find('-');
        const std::int64_t first = number_of(range.substr(0, dash));
        const std::int64_t last =
            dash == std::string::npos ? first : number_of(range.substr(dash + 1));
        if (first < 0 || last < first || last >= count)
            return Error{ErrorCode::InvalidArgument,
                         fmt::format("--tiles takes numbers and ranges from 0 to {}, as 0-5,9, not "
                                     "'{}'",
                                     count - 1, text),
                         ""};
        for (std::int64_t tile = first; tile <= last; ++tile) tiles.push_back(tile);
    }
    return tiles;
}

Result<Outcome> write_shard(const Shard& options, const Bytes& bytes, const codec::RasterPlan& plan,
                            const Tiles& tiles, const Stopwatch& watch) {
    RELIEF_CHECK(io::write_file_atomically(options.out, bytes));
    const std::int64_t all = plan.tile_rows() * plan.tile_cols();
    Outcome outcome;
    outcome.json = Json{{"tile_rows", plan.tile_rows()},
                        {"tile_cols", plan.tile_cols()},
                        {"tiles", tiles},
                        {"missing", plan.missing_tiles()},
                        {"bytes", bytes.size()},
                        {"seconds", watch.seconds()}};
    outcome.text = fmt::format("{}: {} of {} x {} tiles, {} bytes\n", options.out, tiles.size(),
                               plan.tile_rows(), plan.tile_cols(),
                               grouped(static_cast<std::int64_t>(bytes.size())));
    if (options.plan.empty())
        outcome.text +=
            fmt::format("{} of {} tiles are left for shards\n", plan.missing_tiles().size(), all);
    return outcome;
}

Result<Outcome> make_plan(const Shard& options, const RasterSource& source,
                          const Globals& globals) {
    const Stopwatch watch;
    codec::EncodeOptions encode;
    encode.goal = options.max_error ? codec::Goal{codec::Goal::Kind::MaxError, *options.max_error}
                                    : codec::Goal{codec::Goal::Kind::Lossless, 0};
    encode.profile = options.profile == "fast" ? codec::Profile::Fast : codec::Profile::Dense;
    encode.progress = progress_bar(globals, "planning");
    MemorySink sink;
    if (const Status status = codec::plan_raster(source, encode, sink); !status.ok())
        return located(status.error(), options.in);
    const Bytes bytes = sink.take();
    RELIEF_TRY(const auto plan, codec::RasterPlan::open(std::make_shared<MemorySource>(bytes)));
    Tiles held;
    const Tiles& missing = plan.missing_tiles();
    for (std::int64_t tile = 0; tile < plan.tile_rows() * plan.tile_cols(); ++tile)
        if (!std::binary_search(missing.begin(), missing.end(), tile)) held.push_back(tile);
    return write_shard(options, bytes, plan, held, watch);
}

Result<Outcome> run(const Shard& options, const Globals& globals) {
    const Stopwatch watch;
    RELIEF_TRY(const auto source, open_raster(options.in, globals));
    if (options.plan.empty()) {
        if (!options.tiles.empty())
            return Error{ErrorCode::InvalidArgument, "--tiles needs --plan FILE", ""};
        return make_plan(options, *source, globals);
    }
    if (options.max_error || options.profile != "dense")
        return Error{ErrorCode::InvalidArgument,
                     "the plan says the goal and the profile; leave them out", ""};
    RELIEF_TRY(auto bytes, io::open_source(options.plan));
    const auto plan = located(codec::RasterPlan::open(std::move(bytes)), options.plan);
    if (!plan.ok()) return plan.error();
    RELIEF_TRY(const Tiles tiles, tiles_of(options.tiles, *plan));
    MemorySink sink;
    const Status status =
        codec::encode_shard(*plan, *source, tiles, progress_bar(globals, "encoding"), sink);
    if (!status.ok()) return located(status.error(), options.in);
    return write_shard(options, sink.take(), *plan, tiles, watch);
}

}  // namespace

void add_shard(Program& program) {
    auto options = std::make_shared<Shard>();
    CLI::App* verb = add_verb(
        program, "shard",
        "Encode a part of a raster, for several processes or computers that share the work: first "
        "a plan, then shards with its tiles, which 'relief merge' joins to the file that 'relief "
        "encode --scheme fvs' makes.",
        "  relief shard dem.tif plan.shard --max-error 0.5\n"
        "  relief shard dem.tif north.shard --plan plan.shard --tiles 0-49\n"
        "  relief shard dem.tif south.shard --plan plan.shard --tiles 50-99\n"
        "  relief merge plan.shard north.shard south.shard dem.relief",
        [options, &program] { return run(*options, program.globals); });
    verb->add_option("IN", options->in, "the raster: the same for the plan and all shards")
        ->required();
    verb->add_option("OUT", options->out, "the shard")->required();
    verb->add_option("--max-error", options->max_error,
                     "of the plan: largest error of any sample, in data units; without it the file "
                     "is lossless");
    verb->add_option("--profile", options->profile, "of the plan: dense (default) or fast")
        ->check(CLI::IsMember({"fast", "dense"}));
    verb->add_option("--plan", options->plan, "the plan of which this is a shard");
    verb->add_option("--tiles", options->tiles,
                     "numbers of tiles, row by row, as 0-5,9; default: all that the plan lacks");
}

}  // namespace relief::cli
