#include <fmt/format.h>

#include <algorithm>
#include <climits>

#include "edit_script.h"
#include "level_files.h"
#include "ps_verbs.h"

namespace relief::cli {

namespace {

Result<codec::PsMove> parse_move(const std::string& text, int level) {
    const auto parsed = indexed_numbers(text);
    if (!parsed || (parsed->numbers.size() != 1 && parsed->numbers.size() != 3))
        return Error{ErrorCode::InvalidArgument,
                     "--move of a spline on triangles takes INDEX:DZ[,DX,DY], not '" + text + "'",
                     ""};
    codec::PsMove move{level, parsed->index, 0, parsed->numbers[0], {}};
    if (parsed->numbers.size() == 3) move.tilt = {parsed->numbers[1], parsed->numbers[2]};
    return move;
}

/// {"level": K, "index": N, "delta": [RISE, DX, DY] or RISE}, and "component" of surfaces in space.
Result<codec::PsMove> read_move(const Json& item, const codec::PsFile& file,
                                const std::string& where) {
    const auto level = integer(item, "level");
    const auto index = integer(item, "index");
    const bool has_component = item.is_object() && item.contains("component");
    const auto component = has_component ? integer(item, "component") : 0;
    if (!level || !index || !component)
        return Error{ErrorCode::BadInput,
                     "needs integers \"level\" and \"index\"; \"component\" is one, too", where};
    RELIEF_TRY(const auto delta, delta_of(item, 3, where));
    if (delta.size() == 2)
        return Error{ErrorCode::BadInput, "\"delta\" is a rise, or a rise and two slopes", where};
    const auto as_int = [](std::int64_t number) {
        return static_cast<int>(std::clamp<std::int64_t>(number, -1, INT_MAX));
    };
    codec::PsMove move{
        as_int(*level), static_cast<std::uint64_t>(*index), as_int(*component), delta[0], {}};
    if (delta.size() == 3) move.tilt = {delta[1], delta[2]};
    if (const Status exists = file.check({move}); !exists.ok())
        return located(exists.error(), where);
    return move;
}

Result<std::vector<codec::PsMove>> moves_of(const PsEditVerb& verb, const codec::PsFile& file) {
    if (!verb.moves.empty() && file.components() > 1)
        return Error{ErrorCode::InvalidArgument,
                     "--move is for surfaces of one component; --script says which one moves", ""};
    std::vector<codec::PsMove> moves;
    for (const std::string& text : verb.moves) {
        RELIEF_TRY(const codec::PsMove move, parse_move(text, verb.level));
        moves.push_back(move);
    }
    if (!verb.script.empty()) {
        RELIEF_TRY(const Json script, read_moves(verb.script));
        for (std::size_t k = 0; k < script.size(); ++k) {
            RELIEF_TRY(const codec::PsMove move,
                       read_move(script[k], file, place_of_move(verb.script, k)));
            moves.push_back(move);
        }
    }
    if (moves.empty())
        return Error{ErrorCode::InvalidArgument,
                     "nothing to do; give --level K --move INDEX:DZ[,DX,DY] or --script", ""};
    return moves;
}

}  // namespace

Result<Outcome> edit_ps(const PsEditVerb& verb) {
    RELIEF_TRY(const codec::PsFile file, open_ps(verb.in));
    RELIEF_TRY(const auto moves, moves_of(verb, file));
    RELIEF_TRY(Bytes bytes, with_moves(verb.in, moves, codec::add_ps_moves));
    return write_edited_ps(verb.in, verb.out, std::move(bytes));
}

Result<Outcome> write_edited_ps(const std::string& in, const std::string& out, Bytes edited) {
    RELIEF_TRY(const codec::PsFile file, open_ps(in));
    RELIEF_TRY(const auto result, reopened<codec::PsFile>(in, std::move(edited)));
    RELIEF_TRY(const codec::PsSurface before, located(file.surface(0), in));
    RELIEF_TRY(const codec::PsSurface after, located(result.file.surface(0), in));
    RELIEF_CHECK(io::write_file_atomically(out, result.bytes));

    const mesh::Triangulation& mesh = after.space.mesh;
    Touched<2> touched;
    for (mesh::Index v = 0; v < mesh.vertex_count(); ++v) {
        bool same = true;
        for (std::size_t m = 0; m < after.components.size(); ++m)
            same = same && before.components[m][v] == after.components[m][v];
        if (same) continue;
        const Vec2 place = mesh.origin + mesh.vertex(v);
        touched.add({place.x, place.y});
    }
    Outcome outcome;
    outcome.json = edit_json(file, result, touched);
    outcome.text = fmt::format("{}: {} control triangles moved, {} of level 0 touched\n", out,
                               moves_added(file, result), grouped(touched.count()));
    return outcome;
}

}  // namespace relief::cli
