#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "codec/edits.h"
#include "relief/codec/container.h"
#include "relief/codec/raster_codec.h"

/// What files have in common that keep a surface as a base and one chunk for each refinement of it:
/// quadrangulations, Powell-Sabin splines, meshes.
namespace relief::codec {

/// The numbers of chunks: edits, base, the levels from the coarsest, and `trailing` ones which the
/// finest level needs too.
struct LevelChunks {
    static constexpr std::size_t kBase = kEditsChunk + 1;
    static constexpr std::size_t kFirstLevel = kBase + 1;
    int levels = 0;
    std::size_t trailing = 1;

    /// How often the base is refined at a level, and the other way round.
    [[nodiscard]] int refined(int level) const { return levels - level; }
    /// The chunk of the base refined so many times, 0 .. levels.
    [[nodiscard]] static std::size_t of_refined(int refined) {
        return kFirstLevel + static_cast<std::size_t>(refined);
    }
    [[nodiscard]] std::size_t of_level(int level) const { return of_refined(refined(level)); }
    [[nodiscard]] std::size_t last() const { return of_refined(levels) + trailing; }
    /// The last chunk that a level needs.
    [[nodiscard]] std::size_t last_of(int level) const {
        return level == 0 ? last() : of_level(level);
    }
    [[nodiscard]] std::size_t count() const { return last() + 1; }
};

/// The finest level that is complete; the coarsest one if none is.
[[nodiscard]] int finest_level(const ContainerReader& file, const LevelChunks& chunks);
/// How many first bytes of the file a level needs.
[[nodiscard]] std::uint64_t bytes_for(const ContainerReader& file, const LevelChunks& chunks,
                                      int level);

/// What chunks are called.
struct ChunkNames {
    const char* base;
    const char* coarsest;
    const char* finer;
    std::vector<const char*> trailing;
};
/// All chunks, in the order of the file.
[[nodiscard]] std::vector<ChunkSummary> summaries(const ContainerReader& file,
                                                  const LevelChunks& chunks,
                                                  const ChunkNames& names);

[[nodiscard]] inline Error bad_file(std::string what, std::string where) {
    return {ErrorCode::BadFile, std::move(what), std::move(where)};
}
[[nodiscard]] inline Error bad_argument(std::string what) {
    return {ErrorCode::InvalidArgument, std::move(what), ""};
}
/// What is wrong with data that came from a file is wrong with the file.
template <class T>
[[nodiscard]] Result<T> of_file(Result<T> result, const char* where) {
    if (result.ok()) return result;
    return bad_file(result.error().text() + "; the file is damaged", where);
}

/// The directory has as many chunks as the header calls for. Errors: BadFile.
[[nodiscard]] Status check_count(const ContainerReader& file, const LevelChunks& chunks);
/// The chunks up to `last`, which the coarsest level needs, are there. Errors: BadFile.
[[nodiscard]] Status check_coarsest(const ContainerReader& file, std::size_t last);
/// Whether the file can hold so many elements: the coder of numbers needs more than a third of a
/// thousandth of a bit for each.
[[nodiscard]] bool is_plausible(const ContainerReader& file, std::uint64_t count);
/// Errors: BadFile for more elements, such as "vertices", than that.
[[nodiscard]] Status check_plausible(const ContainerReader& file, std::uint64_t count,
                                     const char* elements);
/// The file has such a level. Errors: InvalidArgument.
[[nodiscard]] Status check_level(const LevelChunks& chunks, int level);
/// All that a level needs is there. Errors: BadFile saying how many bytes it takes.
[[nodiscard]] Status check_complete(const ContainerReader& file, const LevelChunks& chunks,
                                    int level);
/// A move of a vertex of a level with so many of them. Errors: InvalidArgument for other vertices,
/// and for numbers that are not at most 1e150.
[[nodiscard]] Status check_move(int level, std::uint64_t vertex, std::uint64_t vertices,
                                std::span<const double> numbers);

}  // namespace relief::codec
