#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "command.h"
#include "relief/io/file.h"

/// What verbs do alike with .relief files that hold a surface level by level. File is
/// codec::QuadFile, codec::PsFile or codec::MeshFile.
namespace relief::cli {

/// A .relief file of such a content. False for anything else, also if it is damaged.
[[nodiscard]] bool holds(const std::string& path, std::string_view content);

/// Opens a .relief file or its first `max_bytes` bytes.
template <class File>
[[nodiscard]] Result<File> open_file(const std::string& path,
                                     std::optional<std::uint64_t> max_bytes = {}) {
    RELIEF_TRY(auto source, io::open_source(path));
    return located(File::open(std::move(source),
                              max_bytes.value_or(std::numeric_limits<std::uint64_t>::max())),
                   path);
}

/// The vertices that each level adds; they are called name_of(level).
template <class File, class NameOf>
[[nodiscard]] Json bands_json(const File& file, NameOf name_of) {
    Json bands = Json::array();
    std::uint64_t coarser = 0;
    for (int level = file.levels(); level >= 0; --level) {
        const std::uint64_t vertices = file.counts(level).vertices;
        bands.push_back(
            Json{{"name", name_of(level)}, {"level", level}, {"vertices", vertices - coarser}});
        coarser = vertices;
    }
    return bands;
}

/// What the faces of a file are called, and which of its counts they are.
template <class Counts>
struct FaceCount {
    const char* name;
    std::uint64_t Counts::*count;
};

template <class File, class Counts>
[[nodiscard]] Json levels_json(const File& file, const FaceCount<Counts>& faces) {
    Json levels = Json::array();
    for (int level = 0; level <= file.levels(); ++level) {
        const Counts counts = file.counts(level);
        Json& json = levels.emplace_back(Json{{"level", level},
                                              {"vertices", counts.vertices},
                                              {faces.name, counts.*faces.count},
                                              {"bytes", file.bytes_for(level)},
                                              {"bound", json_number(file.bound(level))}});
        if constexpr (requires { file.surface_bound(level); })
            json["surface_bound"] = json_number(file.surface_bound(level));
    }
    return levels;
}

/// What a kind of file says in `info --json` beside what all say.
struct Description {
    std::string_view content;
    Json scheme;
    Json order;
    Json more;
    Json bands;
    Json levels;
};

/// `sound`: its checksums hold.
template <class File>
[[nodiscard]] Json info_json(const File& file, const Description& about, bool sound) {
    Json json{{"format", "relief"},
              {"content", about.content},
              {"version", file.version()},
              {"scheme", about.scheme},
              {"order", about.order},
              {"levels", file.levels()},
              {"crs", ""}};
    json.update(about.more);
    json.update(Json{{"bands", about.bands},
                     {"level_list", about.levels},
                     {"chunks", chunks_json(file)},
                     {"bytes", file.size()},
                     {"max_error", json_number(file.max_error())},
                     {"rms_error", json_number(file.rms_error())},
                     {"bound", json_number(file.bound(0))}});
    if constexpr (requires { file.surface_bound(0); })
        json["surface_bound"] = json_number(file.surface_bound(0));
    json.update(Json{{"edits", file.moves().size()}, {"extent", nullptr}});
    if constexpr (requires { file.extent(); }) json["extent"] = file.extent();
    json["checksums_ok"] = sound;
    return json;
}

/// The first line of `info`.
template <class File>
[[nodiscard]] std::string head_text(const std::string& path, const File& file, bool sound) {
    return fmt::format("{}: relief version {}, {} bytes, checksums {}\n", path, file.version(),
                       grouped(static_cast<std::int64_t>(file.size())),
                       sound ? "hold" : "DO NOT HOLD");
}
/// "edited by 2 moves".
[[nodiscard]] std::string edits_text(std::size_t moves);
/// A line for each of levels_json.
[[nodiscard]] std::string levels_text(const Json& levels, const char* faces);

/// The index before a colon and the numbers after it, between commas; none if `text` is not that.
struct IndexedNumbers {
    std::uint64_t index = 0;
    std::vector<double> numbers;
};
[[nodiscard]] std::optional<IndexedNumbers> indexed_numbers(const std::string& text);

/// How --move describes moves of a kind of files.
struct MoveForm {
    const char* of;    ///< "a mesh"
    const char* form;  ///< "INDEX:DZ"
};
/// set(move, numbers) -> bool: whether there are as many numbers as the move takes. Errors:
/// InvalidArgument for other texts, or for none.
template <class Move, class Set>
[[nodiscard]] Result<std::vector<Move>> parse_moves(const std::vector<std::string>& texts,
                                                    int level, const MoveForm& form, Set set) {
    if (texts.empty())
        return Error{ErrorCode::InvalidArgument,
                     fmt::format("nothing to do; give --level K --move {}", form.form), ""};
    std::vector<Move> moves;
    for (const std::string& text : texts) {
        const auto parsed = indexed_numbers(text);
        Move& move = moves.emplace_back();
        if (!parsed || !set(move, parsed->numbers))
            return Error{ErrorCode::InvalidArgument,
                         fmt::format("--move of {} takes {}, not '{}'", form.of, form.form, text),
                         ""};
        move.level = level;
        move.vertex = parsed->index;
    }
    return moves;
}

/// A file with more moves.
template <class File>
struct Edited {
    Bytes bytes;
    File file;
};
template <class File>
[[nodiscard]] Result<Edited<File>> reopened(const std::string& path, Bytes bytes) {
    RELIEF_TRY(File file, located(File::open(bytes), path));
    return Edited<File>{std::move(bytes), std::move(file)};
}

/// A file with more moves: add(bytes, moves) -> Result<Bytes>.
template <class Move, class Add>
[[nodiscard]] Result<Bytes> with_moves(const std::string& path, const std::vector<Move>& moves,
                                       Add add) {
    RELIEF_TRY(Bytes bytes, io::read_file(path));
    return located(add(std::move(bytes), moves), path);
}

/// What `edit` touched, and where it lies: the least coordinates of all, and the largest.
template <std::size_t Dimension>
class Touched {
  public:
    Touched() {
        low_.fill(std::numeric_limits<double>::infinity());
        high_.fill(-std::numeric_limits<double>::infinity());
    }
    void add(const std::array<double, Dimension>& place) {
        ++count_;
        for (std::size_t k = 0; k < Dimension; ++k) {
            low_[k] = std::min(low_[k], place[k]);
            high_[k] = std::max(high_[k], place[k]);
        }
    }
    [[nodiscard]] std::int64_t count() const { return count_; }
    /// null: nothing was touched.
    [[nodiscard]] Json bounds() const {
        if (count_ == 0) return nullptr;
        Json bounds = Json::array();
        for (const double x : low_) bounds.push_back(x);
        for (const double x : high_) bounds.push_back(x);
        return bounds;
    }

  private:
    std::int64_t count_ = 0;
    std::array<double, Dimension> low_{};
    std::array<double, Dimension> high_{};
};

/// How many moves an edited file has more than the one before.
template <class File>
[[nodiscard]] std::size_t moves_added(const File& before, const Edited<File>& edited) {
    return edited.file.moves().size() - before.moves().size();
}

template <class File, std::size_t Dimension>
[[nodiscard]] Json edit_json(const File& before, const Edited<File>& edited,
                             const Touched<Dimension>& touched) {
    return Json{{"moved", moves_added(before, edited)},
                {"touched", touched.count()},
                {"bounds", touched.bounds()},
                {"edits", edited.file.moves().size()},
                {"bytes", edited.bytes.size()}};
}

}  // namespace relief::cli
