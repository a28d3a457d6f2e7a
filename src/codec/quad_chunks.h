#pragma once

#include <optional>
#include <span>
#include <vector>

#include "codec/level_chunks.h"
#include "codec/quad_header.h"
#include "codec/quad_mesh_coding.h"
#include "relief/codec/container.h"
#include "relief/codec/quad_codec.h"

/// What encoder and decoder of files of quadrangulations share.
namespace relief::codec {

/// The numbers of chunks: after the finest level stands the numbering.
struct QuadChunks : LevelChunks {
    explicit QuadChunks(int level_count) : LevelChunks{level_count, 1} {}

    [[nodiscard]] std::size_t numbering() const { return last(); }
};

[[nodiscard]] inline PlaceDigits digits_of(const QuadHeader& header) {
    return {header.x_digits, header.y_digits};
}

/// A file without edits whose chunks are `levels`, with their surface bounds.
[[nodiscard]] Result<Bytes> write_quad_file(const QuadHeader& header, const PlaneMesh& base,
                                            const std::vector<Bytes>& levels,
                                            const std::vector<double>& bounds,
                                            const Bytes& numbering);

[[nodiscard]] Bytes write_quad_moves(const std::vector<QuadMove>& moves);
/// Errors: BadFile.
[[nodiscard]] Result<std::vector<QuadMove>> read_quad_moves(std::span<const std::uint8_t> bytes);

}  // namespace relief::codec
