#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "codec/quad_header.h"
#include "codec/quad_mesh_coding.h"
#include "relief/codec/container.h"
#include "relief/codec/quad_codec.h"

/// What encoder and decoder of files of quadrangulations share.
namespace relief::codec {

/// The numbers of chunks: edits, mesh, the levels from the coarsest, numbering.
struct QuadChunks {
    static constexpr std::size_t kEdits = 0;
    static constexpr std::size_t kMesh = 1;
    static constexpr std::size_t kFirstLevel = 2;
    int levels = 0;

    /// `refined`: how often the base was refined, 0 .. levels.
    [[nodiscard]] static std::size_t level(int refined) {
        return kFirstLevel + static_cast<std::size_t>(refined);
    }
    [[nodiscard]] std::size_t numbering() const { return level(levels) + 1; }
    [[nodiscard]] std::size_t count() const { return numbering() + 1; }
};

[[nodiscard]] inline PlaceDigits digits_of(const QuadHeader& header) {
    return {header.x_digits, header.y_digits};
}

/// A file without edits whose chunks are `levels`, with their surface bounds.
[[nodiscard]] Result<Bytes> write_quad_file(const QuadHeader& header, const PlaneMesh& base,
                                            const std::vector<Bytes>& levels,
                                            const std::vector<double>& bounds,
                                            const Bytes& numbering);

/// Whether a file of some size can hold so many vertices: the coder of numbers needs more than a
/// third of a thousandth of a bit for each.
[[nodiscard]] bool is_plausible(std::uint64_t vertices, std::uint64_t file_size);

[[nodiscard]] Bytes write_quad_moves(const std::vector<QuadMove>& moves);
/// Errors: BadFile.
[[nodiscard]] Result<std::vector<QuadMove>> read_quad_moves(std::span<const std::uint8_t> bytes);

}  // namespace relief::codec
