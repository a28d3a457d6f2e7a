#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "codec/embedded_coder.h"
#include "codec/magnitude.h"

namespace relief::codec {

/// What is known of a magnitude, in eighths of the plane being coded: 0; 11 for 1, for most that
/// have just become significant are small; m + 1/2 for larger ones; at most 255.
inline std::uint8_t known_magnitude(std::uint32_t m) {
    const std::uint32_t known = m < 2 ? 11 * m : 8 * std::min(m, 31U) + 4;
    return static_cast<std::uint8_t>(known);
}

/// Zeros around a grid of rows x cols: kRim cells on each side, on the right behind whole blocks of
/// 64.
template <class T>
class RimmedGrid {
  public:
    static constexpr std::int64_t kRim = 2;

    RimmedGrid() = default;
    RimmedGrid(std::int64_t rows, std::int64_t cols)
        : cells_(rows + 2 * kRim, (cols + 63) / 64 * 64 + 2 * kRim, T{0}) {}

    T* row(std::int64_t r) { return cells_.row(r + kRim) + kRim; }
    [[nodiscard]] const T* row(std::int64_t r) const { return cells_.row(r + kRim) + kRim; }
    [[nodiscard]] GridView<T> cells() { return cells_.view(); }

  private:
    Grid<T> cells_;
};

/// What the coder of a stream knows of a band. The bands of a level share a frame: equal indices
/// are equal lattice points.
struct EmbeddedBand {
    /// A coefficient of another band of the level, which tells about the one at the same index.
    struct Tap {
        const EmbeddedBand* band;
        std::int64_t row;
        std::int64_t col;
        int weight;
    };

    StreamBand source;
    LatticeBox frame;   ///< its origin is even
    std::int64_t row0;  ///< of source.box in the frame
    std::int64_t col0;
    int planes = 0;                        ///< magnitudes are below 2^planes
    RimmedGrid<std::uint8_t> known;        ///< known_magnitude
    RimmedGrid<std::int8_t> sign;          ///< -1 or 1 where known is not 0
    Grid<std::uint64_t> significant;       ///< one bit a column: known is not 0
    Grid<std::uint64_t> visited;           ///< one bit a column: coded in pass 1 of this plane
    RimmedGrid<std::uint8_t> above;        ///< known_magnitude of the parent, on half the frame
    const EmbeddedBand* parent = nullptr;  ///< in this stream, or
    const ParentBand* outer_parent = nullptr;
    std::vector<Tap> siblings;                 ///< for magnitudes
    const EmbeddedBand* signed_siblings[2]{};  ///< for signs

    EmbeddedBand(const StreamBand& band, const LatticeBox& level_frame)
        : source(band),
          frame(level_frame),
          row0(band.box.row0 - frame.row0),
          col0(band.box.col0 - frame.col0),
          known(frame.rows, frame.cols),
          sign(frame.rows, frame.cols),
          significant(frame.rows, words(), 0),
          visited(frame.rows, words(), 0),
          above((frame.rows + 1) / 2, (frame.cols + 1) / 2) {}

    [[nodiscard]] std::int64_t words() const { return (frame.cols + 63) / 64; }

    /// Which of the columns 64 w .. 64 w + 63 of the frame the band has.
    [[nodiscard]] std::uint64_t columns(std::int64_t w) const {
        const std::int64_t end = col0 + source.box.cols;
        return lowest_bits(end - 64 * w) & ~lowest_bits(col0 - 64 * w);
    }

    /// Steps down from plane p + 1.
    void begin_plane(int p) {
        const GridView<std::uint8_t> cells = known.cells();
        for (std::int64_t r = 0; r < cells.rows; ++r) {
            std::uint8_t* row = cells.row(r);
            for (std::int64_t c = 0; c < cells.cols; ++c)
                row[c] = static_cast<std::uint8_t>(std::min(2 * row[c], 255));
        }
        for (std::int64_t r = 0; r < visited.rows(); ++r) std::fill_n(visited.row(r), words(), 0);
        if (parent)
            look_up(parent->frame,
                    [this](std::int64_t r, std::int64_t c) { return parent->known.row(r)[c]; });
        else if (outer_parent)
            look_up(outer_parent->box, [this, p](std::int64_t r, std::int64_t c) {
                return known_magnitude(magnitude_of(outer_parent->values(r, c)) >> p);
            });
    }

  private:
    static std::uint64_t lowest_bits(std::int64_t count) {
        return count >= 64 ? ~std::uint64_t{0}
                           : (std::uint64_t{1} << std::max<std::int64_t>(count, 0)) - 1;
    }

    /// Fills `above` and the ring around it from the points of `box`.
    template <class Known>
    void look_up(const LatticeBox& box, Known known_at) {
        const std::int64_t top = frame.row0 / 2;
        const std::int64_t left = frame.col0 / 2;
        const std::int64_t bottom = top + (frame.rows + 1) / 2;
        const std::int64_t right = left + (frame.cols + 1) / 2;
        const std::int64_t row_end = std::min(bottom + 1, box.row0 + box.rows);
        const std::int64_t col_end = std::min(right + 1, box.col0 + box.cols);
        for (std::int64_t i = std::max(top - 1, box.row0); i < row_end; ++i)
            for (std::int64_t j = std::max(left - 1, box.col0); j < col_end; ++j)
                above.row(i - top)[j - left] = known_at(i - box.row0, j - box.col0);
    }
};

}  // namespace relief::codec
