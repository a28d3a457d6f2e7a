#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <climits>
#include <cmath>

#include "edit_script.h"
#include "ps_verbs.h"
#include "relief/io/file.h"

namespace relief::cli {

namespace {

/// The number before a colon and the one to three after it.
Result<codec::PsMove> parse_move(const std::string& text, int level) {
    const Error wrong{ErrorCode::InvalidArgument,
                      "--move of a spline on triangles takes INDEX:DZ[,DX,DY], not '" + text + "'",
                      ""};
    const char* const end = text.data() + text.size();
    codec::PsMove move;
    move.level = level;
    auto [at, error] = std::from_chars(text.data(), end, move.vertex);
    if (error != std::errc() || at == end || *at != ':') return wrong;
    std::array<double, 3> numbers{};
    std::size_t count = 0;
    do {
        if (count == numbers.size()) return wrong;
        const auto number = std::from_chars(at + 1, end, numbers[count++]);
        if (number.ec != std::errc()) return wrong;
        at = number.ptr;
    } while (at != end && *at == ',');
    if (at != end || count == 2) return wrong;
    move.rise = numbers[0];
    move.tilt = {numbers[1], numbers[2]};
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
    RELIEF_TRY(Bytes bytes, io::read_file(verb.in));
    const auto edited = codec::add_ps_moves(std::move(bytes), moves);
    if (!edited.ok()) return located(edited.error(), verb.in);
    const auto after_file = codec::PsFile::open(*edited);
    if (!after_file.ok()) return located(after_file.error(), verb.in);
    const auto before = file.surface(0);
    if (!before.ok()) return located(before.error(), verb.in);
    const auto after = after_file->surface(0);
    if (!after.ok()) return located(after.error(), verb.in);
    RELIEF_CHECK(io::write_file_atomically(verb.out, *edited));

    const mesh::Triangulation& mesh = after->space.mesh;
    std::int64_t touched = 0;
    Vec2 low{INFINITY, INFINITY};
    Vec2 high{-INFINITY, -INFINITY};
    for (mesh::Index v = 0; v < mesh.vertex_count(); ++v) {
        const auto same = [&](std::size_t m) {
            return before->components[m][v] == after->components[m][v];
        };
        bool moved = false;
        for (std::size_t m = 0; m < after->components.size(); ++m) moved |= !same(m);
        if (!moved) continue;
        ++touched;
        const Vec2 place = mesh.origin + mesh.vertex(v);
        low = {std::min(low.x, place.x), std::min(low.y, place.y)};
        high = {std::max(high.x, place.x), std::max(high.y, place.y)};
    }
    Outcome outcome;
    outcome.json =
        Json{{"moved", moves.size()},
             {"touched", touched},
             {"bounds", touched == 0 ? Json(nullptr) : Json::array({low.x, low.y, high.x, high.y})},
             {"edits", after_file->moves().size()},
             {"bytes", edited->size()}};
    outcome.text = fmt::format("{}: {} control triangles moved, {} of level 0 touched\n", verb.out,
                               moves.size(), grouped(touched));
    return outcome;
}

}  // namespace relief::cli
