#include <fmt/format.h>

#include <algorithm>
#include <climits>
#include <sstream>

#include "edit_script.h"
#include "mesh_verbs.h"
#include "ps_verbs.h"
#include "quad_verbs.h"
#include "relief/core/json.h"
#include "relief/edit/session.h"
#include "relief/io/file.h"
#include "relief/io/raster.h"

namespace relief::cli {

namespace {

struct Edit {
    std::string in;
    std::string out;
    std::optional<int> level;
    std::vector<std::string> moves;
    std::string script;
};

/// "INDEX:DX[,DY,DZ]", INDEX row-major in the control net of the level.
Result<multires::Move> parse_move(const std::string& text, int level,
                                  const multires::PyramidLayout& layout) {
    const Error wrong{ErrorCode::InvalidArgument,
                      "--move takes INDEX:DX[,DY,DZ], not '" + text + "'", ""};
    std::string spaced = text;
    std::replace_if(
        spaced.begin(), spaced.end(), [](char c) { return c == ':' || c == ','; }, ' ');
    std::istringstream fields(spaced);
    fields.imbue(std::locale::classic());
    std::int64_t index = 0;
    if (text.find(':') == std::string::npos || !(fields >> index)) return wrong;
    multires::Move move;
    move.level = level;
    int count = 0;
    while (count < 4 && fields >> move.delta[static_cast<std::size_t>(count)]) ++count;
    if (count == 0 || !fields.eof()) return wrong;
    if (count > layout.components)
        return Error{ErrorCode::InvalidArgument,
                     fmt::format("'{}' moves {} components, the surface has {}", text, count,
                                 layout.components),
                     ""};
    const LatticeBox box = multires::scaling_box(layout, level);
    if (index < 0 || index >= box.count())
        return Error{
            ErrorCode::InvalidArgument,
            fmt::format(
                "index {} does not exist at level {}; the control net has {} x {}, indices 0 to {}",
                index, level, box.cols, box.rows, box.count() - 1),
            ""};
    move.row = box.row0 + index / box.cols;
    move.col = box.col0 + index % box.cols;
    return move;
}

Result<multires::Move> read_move(const Json& item, const multires::PyramidLayout& layout,
                                 const std::string& where) {
    const auto wrong = [&](std::string what) {
        return Error{ErrorCode::BadInput, std::move(what), where};
    };
    const auto level = integer(item, "level");
    const auto index = integer(item, "index");
    const auto row = integer(item, "row");
    const auto col = integer(item, "col");
    if (!level || !(index || (row && col)) || !item.contains("delta"))
        return wrong("needs \"level\", \"index\" (or \"row\" and \"col\") and \"delta\"");
    multires::Move move;
    move.level = static_cast<int>(std::clamp<std::int64_t>(*level, -1, INT_MAX));
    if (move.level < 0 || move.level > layout.levels())
        return located(multires::check_move(layout, move).error(), where);
    const LatticeBox box = multires::scaling_box(layout, move.level);
    move.row = index ? (*index < 0 ? INT64_MAX : box.row0 + *index / box.cols) : *row;
    move.col = index ? box.col0 + *index % box.cols : *col;
    if (auto exists = multires::check_move(layout, move); !exists.ok())
        return located(exists.error(), where);

    RELIEF_TRY(const auto delta,
               delta_of(item, static_cast<std::size_t>(layout.components), where));
    std::copy(delta.begin(), delta.end(), move.delta.begin());
    return move;
}

/// Of {"level": K, "index": N or "row": I, "col": J, "delta": number or list}.
Result<std::vector<multires::Move>> read_script(const std::string& path,
                                                const multires::PyramidLayout& layout) {
    RELIEF_TRY(const Json list, read_moves(path));
    std::vector<multires::Move> moves;
    for (std::size_t k = 0; k < list.size(); ++k) {
        RELIEF_TRY(const auto move, read_move(list[k], layout, place_of_move(path, k)));
        moves.push_back(move);
    }
    return moves;
}

Result<std::vector<multires::Move>> moves_of(const Edit& options,
                                             const multires::PyramidLayout& layout) {
    std::vector<multires::Move> moves;
    if (!options.moves.empty() && !options.level)
        return Error{ErrorCode::InvalidArgument, "--move needs --level K", ""};
    if (options.level.value_or(0) > layout.levels())
        return Error{ErrorCode::InvalidArgument,
                     fmt::format("there is no level {}; the file has levels 0 to {}",
                                 *options.level, layout.levels()),
                     ""};
    for (const std::string& text : options.moves) {
        RELIEF_TRY(const auto move, parse_move(text, *options.level, layout));
        moves.push_back(move);
    }
    if (!options.script.empty()) {
        RELIEF_TRY(const auto more, read_script(options.script, layout));
        moves.insert(moves.end(), more.begin(), more.end());
    }
    if (moves.empty())
        return Error{ErrorCode::InvalidArgument, "nothing to do; give --move or --script", ""};
    return moves;
}

/// A box of the finest lattice in rows and columns of the raster.
LatticeBox without_margin(const LatticeBox& box, codec::LatticeMargin margin) {
    const std::int64_t row0 = std::max(box.row0, margin.rows);
    const std::int64_t col0 = std::max(box.col0, margin.cols);
    return {row0 - margin.rows, col0 - margin.cols, box.row0 + box.rows - row0,
            box.col0 + box.cols - col0};
}

/// Says what moves of a raster did. `file`: before them; `bytes`: of the file with them.
Outcome raster_outcome(const std::string& out, const codec::RasterFile& file,
                       const std::vector<multires::Move>& moves, std::uint64_t bytes) {
    const auto& layout = file.layout();
    const auto field =
        multires::samples_of(layout, multires::displacement<double>(layout, moves, 0), 0);
    std::int64_t touched = 0;
    const codec::LatticeMargin margin = file.margin();
    for (std::int64_t r = margin.rows; r < layout.rows; ++r)
        for (std::int64_t c = margin.cols; c < layout.cols; ++c)
            touched += std::any_of(field.begin(), field.end(),
                                   [&](const auto& plane) { return plane(r, c) != 0; });
    const LatticeBox box = without_margin(multires::touched_box(layout, moves), margin);
    Outcome outcome;
    outcome.json = Json{
        {"moved", moves.size()},
        {"touched", touched},
        {"bounds",
         Json{{"col", box.col0}, {"row", box.row0}, {"width", box.cols}, {"height", box.rows}}},
        {"edits", file.moves().size() + moves.size()},
        {"bytes", bytes}};
    outcome.text = fmt::format(
        "{}: {} control coefficients moved, {} samples touched in columns {} to {}, rows {} to "
        "{}\n",
        out, moves.size(), grouped(touched), box.col0, box.col0 + box.cols - 1, box.row0,
        box.row0 + box.rows - 1);
    return outcome;
}

/// Counts what passes.
class CountingSink final : public ByteSink {
  public:
    explicit CountingSink(ByteSink& to) : to_(to) {}
    Status write(std::span<const std::uint8_t> bytes) override {
        bytes_ += bytes.size();
        return to_.write(bytes);
    }
    [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

  private:
    ByteSink& to_;
    std::uint64_t bytes_ = 0;
};

Result<Outcome> edit_raster(const Edit& options) {
    RELIEF_TRY(const auto source, io::open_source(options.in));
    const auto file = codec::RasterFile::open(source);
    if (!file.ok()) return located(file.error(), options.in);
    RELIEF_TRY(const auto moves, moves_of(options, file->layout()));
    RELIEF_TRY(io::OutputFile out, io::OutputFile::create(options.out));
    CountingSink edited(out);
    if (const Status status = codec::add_moves(source, moves, edited); !status.ok())
        return located(status.error(), options.in);
    RELIEF_CHECK(out.commit());
    return raster_outcome(options.out, *file, moves, edited.bytes());
}

/// Meshes are edited vertex by vertex.
Result<Outcome> edit_any_mesh(const Edit& options) {
    if (!options.moves.empty() && !options.level)
        return Error{ErrorCode::InvalidArgument, "--move needs --level K", ""};
    const int level = options.level.value_or(0);
    if (holds_ps(options.in))
        return edit_ps({options.in, options.out, level, options.moves, options.script});
    if (!options.script.empty())
        return Error{ErrorCode::BadInput,
                     "lists of moves are for rasters and splines on triangles; give commands: "
                     R"([{"do": "move", "level": 0, "points": [7], "delta": 1}])",
                     options.script};
    if (holds_mesh(options.in)) return edit_mesh(options.in, options.out, level, options.moves);
    return edit_quads(options.in, options.out, level, options.moves);
}

using Script = nlohmann::json;

/// Commands of the editor rather than moves.
bool holds_commands(const Script& script) {
    if (script.is_object()) return script.contains("commands");
    return script.is_array() && !script.empty() && script[0].is_object() &&
           script[0].contains("do");
}

/// What a session sees of a raster besides its file.
Result<edit::OpenOptions> session_options(const std::shared_ptr<const ByteSource>& source) {
    RELIEF_TRY(const codec::RasterFile file, codec::RasterFile::open(source));
    const auto cell = io::cell_size_in_unit(file.description());
    if (!cell) return edit::OpenOptions{};
    return edit::OpenOptions{std::array{cell->x, cell->y}};
}

Result<Bytes> replayed(const std::shared_ptr<const ByteSource>& source, bool raster,
                       const Edit& options, const Script& script) {
    edit::OpenOptions open;
    if (raster) {
        auto found = session_options(source);
        if (!found.ok()) return located(found.error(), options.in);
        open = *found;
    }
    auto session = edit::Session::open(source, open);
    if (!session.ok()) return located(session.error(), options.in);
    if (const Status status = session->replay(script); !status.ok())
        return located(status.error(), options.script);
    return session->file();
}

Result<Outcome> write_edited_raster(const Edit& options,
                                    const std::shared_ptr<const ByteSource>& source,
                                    const Bytes& edited) {
    RELIEF_TRY(const codec::RasterFile before, codec::RasterFile::open(source));
    RELIEF_TRY(const codec::RasterFile after, codec::RasterFile::open(edited));
    const auto& all = after.moves();
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(before.moves().size());
    const Outcome outcome = raster_outcome(options.out, before, {first, all.end()}, edited.size());
    RELIEF_CHECK(io::write_file_atomically(options.out, edited));
    return outcome;
}

/// Runs the commands of a script in a session, as the editor does.
Result<Outcome> run_commands(const Edit& options, const Script& script) {
    if (!options.moves.empty())
        return Error{ErrorCode::InvalidArgument,
                     "--move and a script of commands can not be given together; put the moves "
                     "into the script",
                     ""};
    const bool ps = holds_ps(options.in);
    const bool mesh = holds_mesh(options.in);
    const bool quads = holds_quads(options.in);
    RELIEF_TRY(const auto source, io::open_source(options.in));
    RELIEF_TRY(Bytes edited, replayed(source, !ps && !mesh && !quads, options, script));
    if (ps) return write_edited_ps(options.in, options.out, std::move(edited));
    if (mesh) return write_edited_mesh(options.in, options.out, std::move(edited));
    if (quads) return write_edited_quads(options.in, options.out, std::move(edited));
    return write_edited_raster(options, source, edited);
}

Result<Outcome> run(const Edit& options) {
    if (!options.script.empty()) {
        RELIEF_TRY(const auto bytes, io::read_file(options.script));
        const Script script = parse_json<Script>(bytes);
        if (holds_commands(script)) return run_commands(options, script);
    }
    if (holds_quads(options.in) || holds_mesh(options.in) || holds_ps(options.in))
        return edit_any_mesh(options);
    return edit_raster(options);
}

}  // namespace

Result<Json> read_moves(const std::string& path) {
    RELIEF_TRY(const auto bytes, io::read_file(path));
    Json script = parse_json<Json>(bytes);
    if (script.is_object() && script.contains("moves")) script = Json(script["moves"]);
    if (script.is_array()) return script;
    return Error{ErrorCode::BadInput, "is not JSON with a list of moves or commands", path};
}

std::string place_of_move(const std::string& path, std::size_t move) {
    return fmt::format("{}, move {}", path, move + 1);
}

std::optional<std::int64_t> integer(const Json& item, const char* key) {
    const auto found = item.is_object() ? item.find(key) : item.end();
    if (found == item.end() || !found->is_number_integer()) return {};
    if (found->is_number_unsigned() && found->get<std::uint64_t>() > INT64_MAX) return INT64_MAX;
    return found->get<std::int64_t>();
}

Result<std::vector<double>> delta_of(const Json& item, std::size_t most, const std::string& where) {
    const auto found = item.is_object() ? item.find("delta") : item.end();
    if (found == item.end()) return Error{ErrorCode::BadInput, "needs \"delta\"", where};
    const Json numbers = found->is_array() ? *found : Json::array({*found});
    if (numbers.empty() || numbers.size() > most)
        return Error{ErrorCode::BadInput, fmt::format("\"delta\" has not 1 to {} numbers", most),
                     where};
    std::vector<double> delta;
    for (const Json& number : numbers) {
        if (!number.is_number())
            return Error{ErrorCode::BadInput, "\"delta\" is not a number", where};
        delta.push_back(number.get<double>());
    }
    return delta;
}

void add_edit(Program& program) {
    auto options = std::make_shared<Edit>();
    CLI::App* verb = add_verb(
        program, "edit",
        "Move control coefficients of any level; the details follow. The moves are kept as a layer "
        "of "
        "the file: the coded data stays as it is.",
        "  relief edit dem.relief hill.relief --level 3 --move 1250:80\n"
        "  relief edit face.relief face2.relief --level 2 --move 310:0,0,4.5 --move 311:0,0,4\n"
        "  relief edit dem.relief out.relief --script moves.json\n"
        "INDEX counts the control net of the level row by row; 'relief info' gives its size. In a "
        "file of a mesh it is a vertex as 'relief decode --level K' numbers them, and DX its rise; "
        "on triangles DX,DY,DZ are the rise of its control triangle and the slopes that tilt it.",
        [options] { return run(*options); });
    verb->add_option("IN", options->in, "the .relief file")->required();
    verb->add_option("OUT", options->out, "the edited .relief file")->required();
    verb->add_option("--level", options->level, "level of the control net; 0 is the finest")
        ->check(CLI::Range(0, 64));
    verb->add_option("--move", options->moves, "INDEX:DX[,DY,DZ], in data units; repeatable")
        ->take_all()
        ->allow_extra_args(false);
    verb->add_option(
        "--script", options->script,
        "JSON: a list of the editor's commands, as 'relief view' saves them (docs/protocol.md): "
        "[{\"do\": \"move\", \"level\": 3, \"points\": [310], \"delta\": 80}, ...]; or of moves. "
        "Rasters: [{\"level\": 3, \"row\": 10, \"col\": 12, \"delta\": [80]}, ...], \"index\" "
        "instead of row and col; splines on triangles: index, delta [DZ, DX, DY], and "
        "\"component\" of surfaces in space");
}

}  // namespace relief::cli
