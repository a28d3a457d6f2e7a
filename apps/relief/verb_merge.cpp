#include <fmt/format.h>

#include "command.h"
#include "relief/codec/raster_shards.h"
#include "relief/io/file.h"

namespace relief::cli {

namespace {

/// The shards, then the file that they make.
struct Merge {
    std::vector<std::string> paths;
};

/// Errors name shards by their place in the list.
Error with_names(Error error, const std::vector<std::string>& names) {
    for (std::size_t k = names.size(); k-- > 0;) {
        const std::string place = "shard " + std::to_string(k + 1);
        if (error.where.starts_with(place)) {
            error.where = names[k] + error.where.substr(place.size());
            break;
        }
    }
    return error;
}

Result<Outcome> run(const Merge& options) {
    const Stopwatch watch;
    const std::string& out = options.paths.back();
    const std::vector<std::string> names(options.paths.begin(), options.paths.end() - 1);
    std::vector<std::shared_ptr<const ByteSource>> shards;
    for (const std::string& name : names) {
        RELIEF_TRY(auto shard, io::open_source(name));
        shards.push_back(std::move(shard));
    }
    RELIEF_TRY(io::OutputFile sink, io::OutputFile::create(out));
    const auto report = codec::merge_shards(shards, sink);
    if (!report.ok()) return with_names(report.error(), names);
    RELIEF_CHECK(sink.commit());
    Outcome outcome;
    outcome.json =
        Json{{"rows", report->rows},           {"cols", report->cols},
             {"samples", report->samples},     {"tiles", report->tiles},
             {"bytes", report->bytes},         {"bits_per_sample", report->bits_per_sample},
             {"max_error", report->max_error}, {"rms_error", report->rms_error},
             {"seconds", watch.seconds()}};
    outcome.text = fmt::format(
        "{}: {} x {} samples in {} tiles of {} shards -> {} bytes, {:.4g} bits a sample\n"
        "max error {}, rms error {}\n",
        out, report->cols, report->rows, grouped(report->tiles), names.size(),
        grouped(static_cast<std::int64_t>(report->bytes)), report->bits_per_sample,
        shown(report->max_error), shown(report->rms_error));
    return outcome;
}

}  // namespace

void add_merge(Program& program) {
    auto options = std::make_shared<Merge>();
    CLI::App* verb = add_verb(
        program, "merge",
        "Join the shards of a raster that several processes encoded, without coding it anew: the "
        "file is the one that 'relief encode --scheme fvs' makes.",
        "  relief merge plan.shard north.shard south.shard dem.relief",
        [options] { return run(*options); });
    verb->add_option("SHARD", options->paths,
                     "the plan and all shards made by it, in any order; the last name, OUT, is the "
                     ".relief file")
        ->required()
        ->expected(2, 1 << 20)
        ->type_name("SHARD... OUT");
}

}  // namespace relief::cli
