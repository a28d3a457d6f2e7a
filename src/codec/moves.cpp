#include "codec/moves.h"

#include <algorithm>
#include <cmath>

#include "codec/edits.h"

namespace relief::codec {

using multires::Move;

namespace {

constexpr std::uint64_t kMoveBytes = 4 + 2 * 8 + 4 * 8;
constexpr double kLargestMove = 1e300;

}  // namespace

bool is_displacement(const Move& move) {
    return std::all_of(move.delta.begin(), move.delta.end(),
                       [](double d) { return std::abs(d) <= kLargestMove; });
}

Bytes write_moves(const std::vector<Move>& moves) {
    ByteWriter out;
    out.u64(moves.size());
    for (const Move& move : moves) {
        out.u32(static_cast<std::uint32_t>(move.level));
        out.i64(move.row);
        out.i64(move.col);
        for (const double delta : move.delta) out.f64(delta);
    }
    return out.take();
}

Result<std::vector<Move>> read_moves(std::span<const std::uint8_t> bytes,
                                     const multires::PyramidLayout& layout) {
    ByteReader in(bytes);
    const std::uint64_t count = in.u64();
    if (in.failed() || in.rest().size() % kMoveBytes != 0 || count != in.rest().size() / kMoveBytes)
        return damaged_edits();
    std::vector<Move> moves(count);
    for (Move& move : moves) {
        move.level = read_move_level(in);
        move.row = in.i64();
        move.col = in.i64();
        for (double& delta : move.delta) delta = in.f64();
        if (!is_displacement(move) || !multires::check_move(layout, move).ok())
            return damaged_edits();
    }
    return moves;
}

}  // namespace relief::codec
