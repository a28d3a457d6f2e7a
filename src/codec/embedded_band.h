#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/band_plane.h"
#include "codec/embedded_coder.h"

namespace relief::codec {

/// Known magnitudes, in eighths of the plane being coded: 0, 11 for 1 (most magnitudes of one bit
/// are small), m + 1/2 for a larger m, at most 255.
inline std::uint8_t known_magnitude(std::uint32_t m) {
    return m < 2
               ? static_cast<std::uint8_t>(11 * m)
               : static_cast<std::uint8_t>(std::min<std::uint32_t>(8 * std::min(m, 32U) + 4, 255));
}

/// The same magnitude in eighths of the next plane.
inline std::uint8_t doubled(std::uint8_t known) {
    return static_cast<std::uint8_t>(std::min(2 * known, 255));
}

/// Cells of rows x cols with a rim of zeros: rows -kRim .. rows + kRim - 1, columns -kRim .. and as
/// many behind the last block of 64.
template <class T>
class RimmedGrid {
  public:
    static constexpr std::int64_t kRim = 2;

    RimmedGrid() = default;
    RimmedGrid(std::int64_t rows, std::int64_t cols)
        : cells_(rows + 2 * kRim, (cols + 63) / 64 * 64 + 2 * kRim, T{0}) {}

    T* row(std::int64_t r) { return cells_.row(r + kRim) + kRim; }
    [[nodiscard]] const T* row(std::int64_t r) const { return cells_.row(r + kRim) + kRim; }
    [[nodiscard]] GridView<T> all() { return cells_.view(); }

  private:
    Grid<T> cells_;
};

/// What the coder of a stream knows of a band. All bands of a level share a frame, so that equal
/// indices are equal lattice points.
struct EmbeddedBand {
    StreamBand source;
    LatticeBox frame;       ///< even origin
    std::int64_t row0 = 0;  ///< of source.box in the frame
    std::int64_t col0 = 0;
    int planes = 0;                   ///< magnitudes are below 2^planes
    std::uint32_t kind = 0;           ///< of statistics
    RimmedGrid<std::uint8_t> known;   ///< known_magnitude
    RimmedGrid<std::int8_t> sign;     ///< of values that are known not to be 0
    Grid<std::uint64_t> significant;  ///< one bit a column: known is not 0
    Grid<std::uint64_t> visited;      ///< coded in this plane
    RimmedGrid<std::uint8_t> parent;  ///< known_magnitude of the level above, half the frame
    const EmbeddedBand* parent_band = nullptr;  ///< of this stream, or
    ParentBand parent_values;                   ///< of another; or neither
    std::array<const EmbeddedBand*, 2> siblings{};

    EmbeddedBand(const StreamBand& band, const LatticeBox& level_frame)
        : source(band),
          frame(level_frame),
          row0(band.box.row0 - level_frame.row0),
          col0(band.box.col0 - level_frame.col0),
          kind(static_cast<std::uint32_t>(std::min(band.channel, 3))),
          known(frame.rows, frame.cols),
          sign(frame.rows, frame.cols),
          significant(frame.rows, words(), 0),
          visited(frame.rows, words(), 0),
          parent((frame.rows + 1) / 2, (frame.cols + 1) / 2) {}

    [[nodiscard]] std::int64_t words() const { return (frame.cols + 63) / 64; }

    /// The columns of the band among the 64 from 64 w on, one bit each.
    [[nodiscard]] std::uint64_t columns(std::int64_t w) const {
        const std::int64_t begin = std::clamp<std::int64_t>(col0 - 64 * w, 0, 64);
        const std::int64_t end = std::clamp<std::int64_t>(col0 + source.box.cols - 64 * w, 0, 64);
        return below(end) & ~below(begin);
    }

    /// From plane p + 1 to plane p.
    void begin_plane(int p) {
        const GridView<std::uint8_t> cells = known.all();
        for (std::int64_t r = 0; r < cells.rows; ++r) {
            std::uint8_t* row = cells.row(r);
            for (std::int64_t c = 0; c < cells.cols; ++c) row[c] = doubled(row[c]);
        }
        for (std::int64_t r = 0; r < visited.rows(); ++r) std::fill_n(visited.row(r), words(), 0);
        if (parent_band) copy_parent();
        if (parent_values.values.data) read_parent(p);
    }

  private:
    static std::uint64_t below(std::int64_t bit) {
        return bit == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bit) - 1;
    }

    template <class Known>
    void fill_parent(const LatticeBox& box, Known known_at) {
        const std::int64_t first_row = frame.row0 >> 1;
        const std::int64_t first_col = frame.col0 >> 1;
        const std::int64_t row_end =
            std::min(box.row0 + box.rows, first_row + (frame.rows + 1) / 2 + 1);
        const std::int64_t col_end =
            std::min(box.col0 + box.cols, first_col + (frame.cols + 1) / 2 + 1);
        for (std::int64_t i = std::max(box.row0, first_row - 1); i < row_end; ++i)
            for (std::int64_t j = std::max(box.col0, first_col - 1); j < col_end; ++j)
                parent.row(i - first_row)[j - first_col] = known_at(i, j);
    }

    void read_parent(int p) {
        const LatticeBox& box = parent_values.box;
        fill_parent(box, [&](std::int64_t i, std::int64_t j) {
            return known_magnitude(magnitude_of(parent_values.values(i - box.row0, j - box.col0)) >>
                                   p);
        });
    }

    void copy_parent() {
        const LatticeBox& other = parent_band->frame;
        fill_parent(other, [&](std::int64_t i, std::int64_t j) {
            return parent_band->known.row(i - other.row0)[j - other.col0];
        });
    }
};

}  // namespace relief::codec
