#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "codec/bytes.h"
#include "relief/codec/container.h"

/// The chunk of edits, which is the first one of every file. docs/format.md, "Edits chunk".
namespace relief::codec {

inline constexpr std::size_t kEditsChunk = 0;

[[nodiscard]] inline Error damaged_edits() {
    return {ErrorCode::BadFile, "the edits are damaged", "edits chunk"};
}

/// Levels beyond any that there are stay so.
[[nodiscard]] inline int read_move_level(ByteReader& in) {
    return static_cast<int>(std::min<std::uint32_t>(in.u32(), 1000));
}

/// Moves of `size` bytes each, as `read(in, move)` reads them. Errors: BadFile.
template <class Move, class Read>
[[nodiscard]] Result<std::vector<Move>> read_records(std::span<const std::uint8_t> bytes,
                                                     std::size_t size, Read read) {
    if (bytes.size() % size != 0) return damaged_edits();
    ByteReader in(bytes);
    std::vector<Move> moves(bytes.size() / size);
    for (Move& move : moves) read(in, move);
    return moves;
}

/// The file with another chunk of edits. Errors: those of its chunks and of the sink.
[[nodiscard]] Status write_with_edits(const ContainerReader& file, const Bytes& edits,
                                      ByteSink& sink);
[[nodiscard]] Result<Bytes> with_edits(const ContainerReader& file, const Bytes& edits);

}  // namespace relief::codec
