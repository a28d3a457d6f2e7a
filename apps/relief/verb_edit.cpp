#include <fmt/format.h>

#include <cmath>
#include <sstream>

#include "command.h"
#include "relief/io/file.h"

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
Result<multires::Move> parse_move(const std::string& text, int level, const multires::PyramidLayout& layout) {
    const Error wrong{ErrorCode::InvalidArgument, "--move takes INDEX:DX[,DY,DZ], not '" + text + "'", ""};
    std::string spaced = text;
    std::replace_if(spaced.begin(), spaced.end(), [](char c) { return c == ':' || c == ','; }, ' ');
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
                     fmt::format("'{}' moves {} components, the surface has {}", text, count, layout.components), ""};
    const LatticeBox box = multires::scaling_box(layout, level);
    if (index < 0 || index >= box.count())
        return Error{ErrorCode::InvalidArgument,
                     fmt::format("index {} does not exist at level {}; the control net has {} x {}, indices 0 to {}", index,
                                 level, box.cols, box.rows, box.count() - 1),
                     ""};
    move.row = box.row0 + index / box.cols;
    move.col = box.col0 + index % box.cols;
    return move;
}

/// A list, or {"moves": list}, of {"level": K, "index": N or "row": I, "col": J, "delta": number or list}.
Result<std::vector<multires::Move>> read_script(const std::string& path, const multires::PyramidLayout& layout) {
    RELIEF_TRY(const auto bytes, io::read_file(path));
    Json script = Json::parse(bytes.begin(), bytes.end(), nullptr, false);
    if (script.is_object() && script.contains("moves")) script = Json(script["moves"]);
    if (!script.is_array())
        return Error{ErrorCode::BadInput, "is not JSON with a list of moves", path};
    std::vector<multires::Move> moves;
    for (const Json& item : script) {
        const auto where = fmt::format("{}, move {}", path, moves.size() + 1);
        const auto integer = [&](const char* key) { return item.is_object() && item.contains(key) && item[key].is_number_integer(); };
        const bool by_index = integer("index");
        if (!integer("level") || !(by_index || (integer("row") && integer("col"))) || !item.contains("delta"))
            return Error{ErrorCode::BadInput, "needs \"level\", \"index\" (or \"row\" and \"col\") and \"delta\"", where};
        multires::Move move;
        move.level = item["level"].get<int>();
        if (move.level < 0 || move.level > layout.levels())
            return Error{ErrorCode::InvalidArgument, multires::check_move(layout, move).error().message, where};
        const LatticeBox box = multires::scaling_box(layout, move.level);
        if (by_index) {
            const auto index = item["index"].get<std::int64_t>();
            move.row = index < 0 ? INT64_MAX : box.row0 + index / box.cols;
            move.col = index < 0 ? INT64_MAX : box.col0 + index % box.cols;
        } else {
            move.row = item["row"].get<std::int64_t>();
            move.col = item["col"].get<std::int64_t>();
        }
        const Json delta = item["delta"].is_array() ? item["delta"] : Json::array({item["delta"]});
        if (delta.empty() || delta.size() > static_cast<std::size_t>(layout.components))
            return Error{ErrorCode::BadInput, "\"delta\" has not 1 to " + std::to_string(layout.components) + " numbers", where};
        for (std::size_t k = 0; k < delta.size(); ++k) {
            if (!delta[k].is_number()) return Error{ErrorCode::BadInput, "\"delta\" is not a number", where};
            move.delta[k] = delta[k].get<double>();
        }
        moves.push_back(move);
    }
    return moves;
}

Result<Outcome> run(const Edit& options) {
    RELIEF_TRY(const auto bytes, io::read_file(options.in));
    RELIEF_TRY(const codec::RasterFile file, open_relief(options.in));
    const auto& layout = file.layout();
    std::vector<multires::Move> moves;
    if (!options.moves.empty()) {
        if (!options.level) return Error{ErrorCode::InvalidArgument, "--move needs --level K", ""};
        if (*options.level > layout.levels())
            return Error{ErrorCode::InvalidArgument,
                         fmt::format("there is no level {}; the file has levels 0 to {}", *options.level, layout.levels()), ""};
        for (const std::string& text : options.moves) {
            RELIEF_TRY(const auto move, parse_move(text, *options.level, layout));
            moves.push_back(move);
        }
    }
    if (!options.script.empty()) {
        RELIEF_TRY(const auto more, read_script(options.script, layout));
        moves.insert(moves.end(), more.begin(), more.end());
    }
    if (moves.empty()) return Error{ErrorCode::InvalidArgument, "nothing to do; give --move or --script", ""};
    RELIEF_TRY(const auto edited, codec::add_moves(bytes, moves));
    RELIEF_CHECK(io::write_file_atomically(options.out, edited));

    const auto field = multires::samples_of(layout, multires::displacement<double>(layout, moves, 0), 0);
    std::int64_t touched = 0;
    for (std::int64_t r = 0; r < layout.rows; ++r)
        for (std::int64_t c = 0; c < layout.cols; ++c)
            touched += std::any_of(field.begin(), field.end(), [&](const auto& plane) { return plane(r, c) != 0; });
    const LatticeBox box = multires::touched_box(layout, moves);
    Outcome outcome;
    outcome.json = Json{{"moved", moves.size()},
                        {"touched", touched},
                        {"bounds", Json{{"col", box.col0}, {"row", box.row0}, {"width", box.cols}, {"height", box.rows}}},
                        {"edits", file.moves().size() + moves.size()},
                        {"bytes", edited.size()}};
    outcome.text = fmt::format("{}: {} control coefficients moved, {} samples touched in columns {} to {}, rows {} to {}\n",
                               options.out, moves.size(), grouped(touched), box.col0, box.col0 + box.cols - 1, box.row0,
                               box.row0 + box.rows - 1);
    return outcome;
}

}  // namespace

void add_edit(Program& program) {
    auto options = std::make_shared<Edit>();
    CLI::App* verb = add_verb(program, "edit",
                              "Move control coefficients of any level; the details follow. The moves are kept as a layer of "
                              "the file: the coded data stays as it is.",
                              "  relief edit dem.relief hill.relief --level 3 --move 1250:80\n"
                              "  relief edit face.relief face2.relief --level 2 --move 310:0,0,4.5 --move 311:0,0,4\n"
                              "  relief edit dem.relief out.relief --script moves.json\n"
                              "INDEX counts the control net of the level row by row; 'relief info' gives its size.",
                              [options] { return run(*options); });
    verb->add_option("IN", options->in, "the .relief file")->required();
    verb->add_option("OUT", options->out, "the edited .relief file")->required();
    verb->add_option("--level", options->level, "level of the control net; 0 is the finest")->check(CLI::Range(0, 64));
    verb->add_option("--move", options->moves, "INDEX:DX[,DY,DZ], in data units; repeatable")
        ->take_all()
        ->allow_extra_args(false);
    verb->add_option("--script", options->script,
                     "JSON: [{\"level\": 3, \"row\": 10, \"col\": 12, \"delta\": [80]}, ...]; \"index\" instead of row and col");
}

}  // namespace relief::cli
