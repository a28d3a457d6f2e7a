#include "codec/level_chunks.h"

#include <algorithm>
#include <cmath>

namespace relief::codec {

namespace {

constexpr std::uint64_t kAlwaysPlausible = std::uint64_t{1} << 22;
constexpr std::uint64_t kElementsPerByte = std::uint64_t{1} << 15;
constexpr double kLargestMove = 1e150;

}  // namespace

int finest_level(const ContainerReader& file, const LevelChunks& chunks) {
    int level = 0;
    while (level < chunks.levels && !file.complete(chunks.last_of(level))) ++level;
    return level;
}

std::uint64_t bytes_for(const ContainerReader& file, const LevelChunks& chunks, int level) {
    const ChunkInfo& chunk = file.chunks()[chunks.last_of(level)];
    return chunk.offset + chunk.length;
}

std::vector<ChunkSummary> summaries(const ContainerReader& file, const LevelChunks& chunks,
                                    const ChunkNames& names) {
    std::vector<ChunkSummary> list;
    const auto add = [&](const char* kind, int level) {
        const ChunkInfo& chunk = file.chunks()[list.size()];
        list.push_back({kind, level, 1, chunk.length, chunk.bound});
    };
    add("edits", 0);
    add(names.base, chunks.levels);
    add(names.coarsest, chunks.levels);
    for (int level = chunks.levels - 1; level >= 0; --level) add(names.finer, level);
    for (const char* name : names.trailing) add(name, 0);
    return list;
}

Status check_count(const ContainerReader& file, const LevelChunks& chunks) {
    if (file.chunks().size() == chunks.count()) return {};
    return bad_file("the header calls for " + std::to_string(chunks.count()) +
                        " chunks, the file has " + std::to_string(file.chunks().size()),
                    "directory");
}

Status check_coarsest(const ContainerReader& file, std::size_t last) {
    if (file.complete(last)) return {};
    return bad_file("not even the coarsest level is there; read more bytes",
                    "byte " + std::to_string(file.visible_size()));
}

bool is_plausible(const ContainerReader& file, std::uint64_t count) {
    return count <= kAlwaysPlausible || count / kElementsPerByte <= file.complete_size();
}

Status check_plausible(const ContainerReader& file, std::uint64_t count, const char* elements) {
    if (is_plausible(file, count)) return {};
    return bad_file(
        "claims " + std::to_string(count) + " " + elements + ", for which the file is too small",
        "header");
}

Status check_level(const LevelChunks& chunks, int level) {
    if (level >= 0 && level <= chunks.levels) return {};
    return bad_argument("there is no level " + std::to_string(level) +
                        "; the file has levels 0 to " + std::to_string(chunks.levels));
}

Status check_complete(const ContainerReader& file, const LevelChunks& chunks, int level) {
    if (level >= finest_level(file, chunks)) return {};
    return bad_file("level " + std::to_string(level) + " needs the first " +
                        std::to_string(bytes_for(file, chunks, level)) +
                        " bytes of the file; read more, or a coarser level",
                    "byte " + std::to_string(file.visible_size()));
}

Status check_move(int level, std::uint64_t vertex, std::uint64_t vertices,
                  std::span<const double> numbers) {
    if (vertex >= vertices)
        return bad_argument("vertex " + std::to_string(vertex) + " does not exist at level " +
                            std::to_string(level) + "; it has vertices 0 to " +
                            std::to_string(vertices - 1));
    const bool in_range = std::all_of(numbers.begin(), numbers.end(),
                                      [](double d) { return std::abs(d) <= kLargestMove; });
    return in_range ? Status() : bad_argument("a move must be of numbers of at most 1e150");
}

}  // namespace relief::codec
