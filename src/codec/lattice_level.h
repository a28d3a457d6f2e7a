#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "relief/core/buffer.h"
#include "relief/core/grid.h"
#include "relief/core/result.h"

/// What the closed loop codes: one level of the interpolating lattice of one tile, in integers.
/// Source: codec-closed-loop, sections 2, 3 and 6; docs/codec.md.
namespace relief::codec {

/// A grid with kMargin cells on every side, and room behind each row for vector loads to run over.
template <class T>
class MarginGrid {
  public:
    static constexpr std::int64_t kMargin = 4;

    MarginGrid() = default;
    /// All zero.
    MarginGrid(std::int64_t rows, std::int64_t cols)
        : cells_(rows + 2 * kMargin, cols + 2 * kMargin + kSlack, T{}), rows_(rows), cols_(cols) {}
    /// Zero margins around cells that are NOT initialised.
    [[nodiscard]] static MarginGrid uninitialised(std::int64_t rows, std::int64_t cols) {
        MarginGrid grid;
        grid.cells_ = Grid<T>(rows + 2 * kMargin, cols + 2 * kMargin + kSlack);
        grid.rows_ = rows;
        grid.cols_ = cols;
        const std::int64_t stride = grid.stride();
        std::fill_n(grid.cells_.row(0), kMargin * stride + kMargin, T{});
        for (std::int64_t r = 0; r < rows; ++r)  // behind one row and before the next
            std::fill_n(grid.row(r) + cols, stride - cols, T{});
        std::fill_n(grid.row(rows), kMargin * stride - kMargin, T{});
        return grid;
    }

    [[nodiscard]] std::int64_t rows() const { return rows_; }
    [[nodiscard]] std::int64_t cols() const { return cols_; }
    [[nodiscard]] std::int64_t stride() const { return cells_.stride(); }
    /// Column 0 of row r, -kMargin <= r < rows + kMargin.
    T* row(std::int64_t r) { return cells_.row(r + kMargin) + kMargin; }
    [[nodiscard]] const T* row(std::int64_t r) const { return cells_.row(r + kMargin) + kMargin; }
    T& operator()(std::int64_t r, std::int64_t c) { return row(r)[c]; }
    const T& operator()(std::int64_t r, std::int64_t c) const { return row(r)[c]; }

  private:
    static constexpr std::int64_t kSlack = 64;  // elements: the widest vector of 32-bit numbers
    Grid<T> cells_;
    std::int64_t rows_ = 0;
    std::int64_t cols_ = 0;
};

/// The sides where a tile ends with the raster: margins there continue the tile by odd reflection.
/// Margins of the other sides are interpolated from the coarser level, which the neighbours share.
struct Borders {
    bool north = true;
    bool south = true;
    bool west = true;
    bool east = true;
};

/// One level of a tile. "EE" samples (even row, even column) are those of the coarser level, "D"
/// (odd, odd) and "E" (odd row + column) are coded here, D first.
struct LatticeLevel {
    int level = 0;  ///< of the raster: samples are 2^level apart
    Borders borders;
    MarginGrid<std::int32_t> values;     ///< decoded
    MarginGrid<std::int16_t> quotients;  ///< q of the decoded samples, at most 30000 in magnitude
    MarginGrid<std::uint8_t> valid;      ///< 1 sample, 0 hole (nothing is coded); 0 in margins
    bool all_valid = true;               ///< no holes among the samples
    std::int32_t step = 1;               ///< odd; |value - source| <= (step - 1) / 2
    /// Low bits of quotients that profile dense writes as they are. It models the rest, which
    /// `quotients` holds.
    int raw_bits = 0;
    std::int32_t lowest = 0;  ///< of all sources, as predictions are clamped
    std::int32_t highest = 0;

    [[nodiscard]] std::int64_t rows() const { return values.rows(); }
    [[nodiscard]] std::int64_t cols() const { return values.cols(); }
};

/// Makes the margins on raster borders, to 3 cells out, of a level that is decoded.
void reflect_borders(LatticeLevel& level);

/// The next finer level, rows x cols = at most twice the coarse one: EE samples and quotients
/// copied, EE margins filled, all other samples and the mask NOT initialised. Mask and step are
/// left for the caller. `coarse` must be decoded; its margins on raster borders are made here,
/// those on other sides must be there (refine and fill_edge_margins make them). Requires:
/// coarse.rows() = ceil(rows / 2), and so for columns.
[[nodiscard]] LatticeLevel refine(LatticeLevel& coarse, std::int64_t rows, std::int64_t cols);

/// What a point of a margin is, of its four nearest neighbours.
[[nodiscard]] inline std::int32_t margin_mean(std::int32_t a, std::int32_t b, std::int32_t c,
                                              std::int32_t d) {
    return static_cast<std::int32_t>((std::int64_t{a} + b + c + d + 2) >> 2);
}

/// After the D samples are decoded: the D points of the margins, to 3 cells out, as means of their
/// diagonal neighbours.
void fill_diagonal_margins(LatticeLevel& level);

/// After the E samples are decoded: the E points of the margins, to 2 cells out, as means of their
/// four neighbours.
void fill_edge_margins(LatticeLevel& level);

/// Entropy coder and predictor of levels of one tile, from coarse to fine; what it learns on one
/// level it uses on the next. Encoding leaves in `level` exactly what decoding gives.
class LevelCodec {
  public:
    LevelCodec() = default;
    LevelCodec(const LevelCodec&) = default;
    LevelCodec& operator=(const LevelCodec&) = delete;
    virtual ~LevelCodec() = default;

    /// Appends the D and E samples of `level` to `out`. `source`: the level's samples; holes may
    /// hold anything. |source| < 2^29, between lowest and highest where valid. Returns whether the
    /// bytes, decoded again, give the symbols of which the values of `level` are made.
    [[nodiscard]] virtual bool encode(LatticeLevel& level, GridView<const std::int32_t> source,
                                      std::vector<std::uint8_t>& out) = 0;

    /// Errors: BadFile for bytes that no encoder writes; the level is of no use then. Never reads
    /// past `bytes`.
    [[nodiscard]] virtual Status decode(LatticeLevel& level,
                                        std::span<const std::uint8_t> bytes) = 0;

    /// A codec for a tile inside this one's, which starts with what this one has learnt.
    [[nodiscard]] virtual std::unique_ptr<LevelCodec> descendant() const = 0;
};

[[nodiscard]] std::unique_ptr<LevelCodec> make_dense_codec();
[[nodiscard]] std::unique_ptr<LevelCodec> make_fast_codec();

}  // namespace relief::codec
