#include "multires/barycentric_tiles.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "multires/haar_level.h"
#include "multires/row_copy.h"
#include "relief/core/parallel.h"
#include "relief/core/rows.h"

namespace relief::multires::barycentric {

namespace {

/// Coarse rows and columns of a tile: wide enough that halos cost a few per cent, small enough that
/// all rings of rows stay in a core's own second-level cache.
constexpr std::int64_t kTileRows = 128;
constexpr std::int64_t kTileCols = 512;

/// Columns of a strip and rows at once of divide_by_symbol.
constexpr std::int64_t kDivisionCols = 1024;
constexpr int kDivisionRows = 8;

std::int64_t floor_half(std::int64_t n) {
    return n >> 1;
}
std::int64_t ceil_half(std::int64_t n) {
    return (n + 1) >> 1;
}
int parity(std::int64_t n) {
    return static_cast<int>(n & 1);
}

/// low and high as taps of T over their common reach.
template <class T>
struct FilterPair {
    FilterPair(const Sequence& low, const Sequence& high)
        : first{low.first, high.first},
          lo(std::min(low.first, high.first)),
          hi(std::max(low.last(), high.last())) {
        taps[0].assign(low.taps.begin(), low.taps.end());
        taps[1].assign(high.taps.begin(), high.taps.end());
    }
    [[nodiscard]] int begin(int which) const { return first[which]; }
    [[nodiscard]] int end(int which) const {
        return first[which] + static_cast<int>(taps[which].size());
    }
    [[nodiscard]] T at(int which, int n) const {
        return taps[which][static_cast<std::size_t>(n - first[which])];
    }
    [[nodiscard]] int depth() const { return hi - lo + 1; }

    std::array<std::vector<T>, 2> taps;
    std::array<int, 2> first;
    int lo;
    int hi;
};

/// A ring of rows addressed by their lattice row; `lanes` rows of `width` elements each belong to
/// one lattice row.
template <class T>
class RowRing {
  public:
    RowRing(int depth, int lanes, std::int64_t width)
        : depth_(depth),
          lanes_(lanes),
          width_(width + 16),
          rows_(static_cast<std::size_t>(depth * lanes * width_)) {}
    T* row(std::int64_t r, int lane) {
        const std::int64_t slot = (r % depth_ + depth_) % depth_;
        return rows_.data() + (slot * lanes_ + lane) * width_;
    }

  private:
    std::int64_t depth_;
    std::int64_t lanes_;
    std::int64_t width_;
    Buffer<T> rows_;
};

/// Taps gathered before one pass over a row.
template <class T>
struct TapList {
    std::vector<RowTap<T>> taps;

    void add(const T* row, T weight) { taps.push_back({row, weight}); }
    /// out = sum of the taps; zero without taps.
    void run(T* out, std::int64_t n) {
        if (taps.empty())
            std::fill_n(out, n, T(0));
        else
            row_fir(out, n, taps.data(), static_cast<int>(taps.size()));
        taps.clear();
    }
};

template <class T>
class AnalysisTile {
  public:
    AnalysisTile(const FilterPair<T>& filters, T scale, const RowSource<T>& fine,
                 const std::array<Channel<T>, 8>& channels, const LatticeBox& tile)
        : f_(filters),
          scale_(scale),
          fine_(fine),
          channels_(channels),
          tile_(tile),
          h0_(tile.col0 - floor_half(f_.hi + 1)),
          nh_(tile.cols + floor_half(f_.hi + 1) - ceil_half(f_.lo)),
          e0_(h0_ + floor_half(f_.lo)),
          ne_(nh_ + floor_half(f_.hi + 1) - floor_half(f_.lo)),
          input_(f_.depth(), 2, ne_),
          t_(f_.depth(), 4, nh_),
          s_(1, 4, ne_),
          line_(static_cast<std::size_t>(2 * ne_)),
          details_(streamed_if_large<T>(fine.box().count())) {}

    void run() {
        const std::int64_t first = 2 * tile_.row0 - f_.hi;
        const std::int64_t last = 2 * (tile_.row0 + tile_.rows - 1) - f_.lo;
        for (std::int64_t r = first + f_.lo; r < first + f_.hi; ++r) load(r);
        for (std::int64_t r = first; r <= last; ++r) {
            load(r + f_.hi);
            filter_e1(r);
            filter_e2(r);
            const std::int64_t twice = r + f_.lo;
            if (parity(twice) == 0 && twice >= 2 * tile_.row0) filter_e3(twice / 2);
        }
        finish_streaming();
    }

  private:
    void load(std::int64_t r) {
        const LatticeBox& stored = fine_.box();
        const bool inside = stored.contains(r, 2 * e0_) && stored.contains(r, 2 * (e0_ + ne_) - 1);
        if (!inside) fine_.fill(r, 2 * e0_, 2 * ne_, line_.data());
        const T* row = inside ? fine_.at(r, 2 * e0_) : line_.data();
        row_split(row, ne_, input_.row(r, 0), input_.row(r, 1));
    }

    /// s_X(r) = sum X(n) fine(r + n), even and odd columns apart: lanes 2 X + parity.
    void filter_e1(std::int64_t r) {
        for (int x = 0; x < 2; ++x)
            for (int odd = 0; odd < 2; ++odd) {
                for (int n = f_.begin(x); n < f_.end(x); ++n)
                    list_.add(input_.row(r + n, odd), f_.at(x, n));
                list_.run(s_.row(0, 2 * x + odd), ne_);
            }
    }

    /// t_XY(r) at the columns of r's parity, column 2 h + parity(r): lanes 2 X + Y.
    void filter_e2(std::int64_t r) {
        for (int xy = 0; xy < 4; ++xy) {
            const int x = xy >> 1;
            const int y = xy & 1;
            for (int n = f_.begin(y); n < f_.end(y); ++n) {
                const int column = parity(r) + n;
                list_.add(s_.row(0, 2 * x + parity(column)) + (h0_ - e0_) + floor_half(column),
                          f_.at(y, n));
            }
            list_.run(t_.row(r, xy), nh_);
        }
    }

    void filter_e3(std::int64_t row) {
        for (int c = 0; c < 8; ++c) {
            const Channel<T>& channel = channels_[static_cast<std::size_t>(c)];
            const LatticeBox& box = channel.box;
            const std::int64_t begin = std::max(tile_.col0, box.col0);
            const std::int64_t end = std::min(tile_.col0 + tile_.cols, box.col0 + box.cols);
            if (row < box.row0 || row >= box.row0 + box.rows || begin >= end) continue;
            const auto letters = channel_letters(c);
            const int xy = 2 * static_cast<int>(letters[0]) + static_cast<int>(letters[1]);
            const int z = static_cast<int>(letters[2]);
            for (int n = f_.begin(z); n < f_.end(z); ++n) {
                const std::int64_t r = 2 * row - n;
                list_.add(t_.row(r, xy) + (begin - h0_) - floor_half(n + parity(r)),
                          scale_ * f_.at(z, n));
            }
            T* out = channel.view.row(row - box.row0) + (begin - box.col0);
            const bool streamed = c > 0 && details_ == Traffic::Streamed;
            list_.run(streamed ? line_.data() : out, end - begin);
            if (streamed) copy_row(line_.data(), end - begin, out, Traffic::Streamed);
        }
    }

    const FilterPair<T>& f_;
    T scale_;
    const RowSource<T>& fine_;
    const std::array<Channel<T>, 8>& channels_;
    LatticeBox tile_;
    std::int64_t h0_, nh_;  ///< half-density columns of t
    std::int64_t e0_, ne_;  ///< column pairs of the input
    RowRing<T> input_, t_, s_;
    Buffer<T> line_;
    Traffic details_;  ///< of channels 1 .. 7; the next level reads channel 0
    TapList<T> list_;
};

template <class T>
class SynthesisTile {
  public:
    /// pairs: rows of the fine box, and column pairs (2k, 2k + 1).
    SynthesisTile(const FilterPair<T>& filters, T scale,
                  const std::array<Channel<const T>, 8>& channels, const LatticeBox& pairs,
                  const LatticeBox& box, GridView<T> fine)
        : f_(filters),
          scale_(scale),
          channels_(channels),
          pairs_(pairs),
          box_(box),
          fine_(fine),
          h0_(pairs.col0 - floor_half(f_.hi + 1)),
          nh_(pairs.cols + floor_half(f_.hi + 1) + floor_half(1 - f_.lo)),
          c0_(h0_ + ceil_half(f_.lo)),
          nc_(nh_ + floor_half(f_.hi + 1) - ceil_half(f_.lo)),
          padded_(f_.depth() / 2 + 2, 8, nc_),
          padded_row_(static_cast<std::size_t>(8 * (f_.depth() / 2 + 2)), kNoRow),
          u_(1, 4, nh_),
          v_(f_.depth(), 4, pairs.cols),
          halves_(1, 2, pairs.cols),
          line_(static_cast<std::size_t>(2 * pairs.cols)),
          traffic_(streamed_if_large<T>(box.count())) {}

    void run() {
        const std::int64_t last = pairs_.row0 + pairs_.rows - 1;
        for (std::int64_t r = pairs_.row0 - f_.hi; r <= last - f_.lo; ++r) {
            merge_e3(r);
            merge_e2(r);
            if (r + f_.lo >= pairs_.row0) merge_e1(r + f_.lo);
        }
        finish_streaming();
    }

  private:
    static constexpr std::int64_t kNoRow = INT64_MIN;

    /// Row x of a channel from column c0_ on, padded with zeros where the band ends; null when the
    /// row does not exist.
    const T* coarse_row(int c, std::int64_t x) {
        const Channel<const T>& channel = channels_[static_cast<std::size_t>(c)];
        const LatticeBox& box = channel.box;
        if (x < box.row0 || x >= box.row0 + box.rows) return nullptr;
        const T* row = channel.view.row(x - box.row0);
        if (c0_ >= box.col0 && c0_ + nc_ <= box.col0 + box.cols) return row + (c0_ - box.col0);
        T* copy = padded_.row(x, c);
        const std::int64_t slots = f_.depth() / 2 + 2;
        std::int64_t& held =
            padded_row_[static_cast<std::size_t>(((x % slots) + slots) % slots * 8 + c)];
        if (held == x) return copy;
        held = x;
        const std::int64_t begin = std::clamp<std::int64_t>(box.col0 - c0_, 0, nc_);
        const std::int64_t end = std::clamp<std::int64_t>(box.col0 + box.cols - c0_, begin, nc_);
        std::fill_n(copy, begin, T(0));
        std::copy_n(row + (c0_ + begin - box.col0), end - begin, copy + begin);
        std::fill_n(copy + end, nc_ - end, T(0));
        return copy;
    }

    /// u_XY(r) at columns 2 h + parity(r), from both Z.
    void merge_e3(std::int64_t r) {
        for (int xy = 0; xy < 4; ++xy) {
            for (int c = 0; c < 8; ++c) {
                const auto letters = channel_letters(c);
                if (2 * static_cast<int>(letters[0]) + static_cast<int>(letters[1]) != xy) continue;
                const int z = static_cast<int>(letters[2]);
                for (int n = f_.begin(z); n < f_.end(z); ++n) {
                    if (parity(r + n) != 0) continue;
                    const T* row = coarse_row(c, floor_half(r + n));
                    if (row) list_.add(row + (h0_ - c0_) + floor_half(n + parity(r)), f_.at(z, n));
                }
            }
            list_.run(u_.row(0, xy), nh_);
        }
    }

    /// v_X(r) at even and odd columns: lanes 2 X + parity.
    void merge_e2(std::int64_t r) {
        for (int x = 0; x < 2; ++x)
            for (int odd = 0; odd < 2; ++odd) {
                for (int y = 0; y < 2; ++y)
                    for (int n = f_.begin(y); n < f_.end(y); ++n) {
                        const std::int64_t twice = odd - n - parity(r);
                        if (parity(twice) != 0) continue;
                        list_.add(u_.row(0, 2 * x + y) + (pairs_.col0 - h0_) + floor_half(twice),
                                  f_.at(y, n));
                    }
                list_.run(v_.row(r, 2 * x + odd), pairs_.cols);
            }
    }

    void merge_e1(std::int64_t r) {
        for (int odd = 0; odd < 2; ++odd) {
            for (int x = 0; x < 2; ++x)
                for (int n = f_.begin(x); n < f_.end(x); ++n)
                    list_.add(v_.row(r - n, 2 * x + odd), scale_ * f_.at(x, n));
            list_.run(halves_.row(0, odd), pairs_.cols);
        }
        T* row = fine_.row(r - box_.row0);
        const std::int64_t begin = 2 * pairs_.col0 - box_.col0;
        const bool inside = begin >= 0 && begin + 2 * pairs_.cols <= box_.cols;
        if (inside && traffic_ == Traffic::Cached)
            return row_merge(halves_.row(0, 0), halves_.row(0, 1), pairs_.cols, row + begin);
        row_merge(halves_.row(0, 0), halves_.row(0, 1), pairs_.cols, line_.data());
        const std::int64_t skip = std::max<std::int64_t>(0, -begin);
        const std::int64_t end = std::min(2 * pairs_.cols, box_.cols - begin);
        copy_row(line_.data() + skip, end - skip, row + begin + skip, traffic_);
    }

    const FilterPair<T>& f_;
    T scale_;
    const std::array<Channel<const T>, 8>& channels_;
    LatticeBox pairs_, box_;
    GridView<T> fine_;
    std::int64_t h0_, nh_;  ///< half-density columns of u
    std::int64_t c0_, nc_;  ///< coarse columns that reach the tile
    RowRing<T> padded_;
    std::vector<std::int64_t> padded_row_;
    RowRing<T> u_, v_, halves_;
    Buffer<T> line_;
    Traffic traffic_;
    TapList<T> list_;
};

/// Calls fn(tile) for the tiles of `whole`, in parallel; borders depend on `whole` only.
template <class Function>
void for_each_tile(const LatticeBox& whole, std::int64_t tile_rows, std::int64_t tile_cols,
                   Function&& fn) {
    const std::int64_t down = (whole.rows + tile_rows - 1) / tile_rows;
    const std::int64_t across = (whole.cols + tile_cols - 1) / tile_cols;
    parallel_for(0, down * across, 1, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t t = first; t < last; ++t) {
            const std::int64_t row = t / across * tile_rows;
            const std::int64_t col = t % across * tile_cols;
            fn(LatticeBox{whole.row0 + row, whole.col0 + col, std::min(tile_rows, whole.rows - row),
                          std::min(tile_cols, whole.cols - col)});
        }
    });
}

/// Reflection index and weight of the extension: c(k) = 2 c(edge) - c(mirror) outside [0, n).
struct Extended {
    std::int64_t mirror;
    std::int64_t edge;  ///< -1: inside, the value is c(mirror)
};
Extended extend(std::int64_t k, std::int64_t n) {
    if (k < 0) return {std::min(-k, n - 1), 0};
    if (k > n - 1) return {std::max<std::int64_t>(2 * (n - 1) - k, 0), n - 1};
    return {k, -1};
}

/// grid(r, c) += pole * grid(r - 2, c - shift) down all rows, then the same upwards. Even and odd
/// rows do not meet, nor do columns where nothing is shifted.
template <class T>
void divide_along_rows(T pole, std::int64_t shift, GridView<T> grid) {
    const std::int64_t n = grid.cols - shift;
    if (n <= 0) return;
    const std::int64_t width = shift == 0 ? kDivisionCols : n;
    const std::int64_t across = (n + width - 1) / width;
    parallel_for(0, 2 * across, 1, [&](std::int64_t task, std::int64_t) {
        const std::int64_t first = task % 2;
        const std::int64_t col = task / 2 * width;
        const std::int64_t count = std::min(width, n - col);
        for (std::int64_t r = first + 2; r < grid.rows; r += 2) {
            const RowTap<T> tap{grid.row(r - 2) + col, pole};
            row_fir_add(grid.row(r) + col + shift, count, &tap, 1);
        }
        const std::int64_t last = grid.rows - 1 - (grid.rows - 1 - first) % 2;
        for (std::int64_t r = last - 2; r >= first; r -= 2) {
            const RowTap<T> tap{grid.row(r + 2) + col + shift, pole};
            row_fir_add(grid.row(r) + col, count, &tap, 1);
        }
    });
}

/// row(c) += pole * row(c - 2) from left to right, then row(c) += pole * row(c + 2) back, for kRows
/// rows at once: each step of one row waits for the step before, so that a processor has time for
/// several rows.
template <int kRows, class T>
void divide_along_columns(T pole, std::int64_t first, GridView<T> grid) {
    std::array<T*, kRows> rows;
    for (int k = 0; k < kRows; ++k) rows[static_cast<std::size_t>(k)] = grid.row(first + k);
    const auto sweep = [&](std::int64_t begin, std::int64_t end, std::int64_t step) {
        std::array<T, kRows> older{};
        std::array<T, kRows> newer{};
        for (std::int64_t c = begin; c != end; c += step)
            for (std::size_t k = 0; k < kRows; ++k) {
                const T value = rows[k][c] + pole * older[k];
                rows[k][c] = value;
                older[k] = newer[k];
                newer[k] = value;
            }
    };
    sweep(0, grid.cols, 1);
    sweep(grid.cols - 1, -1, -1);
}

}  // namespace

template <class T>
void ExtendedRows<T>::fill(std::int64_t row, std::int64_t col0, std::int64_t n, T* out) const {
    const Extended source = extend(row - box_.row0, box_.rows);
    const T* mirror = grid_.row(source.mirror);
    const T* edge = source.edge < 0 ? nullptr : grid_.row(source.edge);
    const auto value = [&](std::int64_t c) {
        return edge ? T(2) * edge[c] - mirror[c] : mirror[c];
    };
    const std::int64_t first = col0 - box_.col0;
    const std::int64_t inner_begin = std::clamp<std::int64_t>(-first, 0, n);
    const std::int64_t inner_end = std::clamp<std::int64_t>(box_.cols - first, inner_begin, n);
    const auto outside = [&](std::int64_t k) {
        const Extended column = extend(first + k, box_.cols);
        out[k] = T(2) * value(column.edge) - value(column.mirror);
    };
    for (std::int64_t k = 0; k < inner_begin; ++k) outside(k);
    if (edge)
        for (std::int64_t k = inner_begin; k < inner_end; ++k) out[k] = value(first + k);
    else
        std::copy(mirror + first + inner_begin, mirror + first + inner_end, out + inner_begin);
    for (std::int64_t k = inner_end; k < n; ++k) outside(k);
}

template <class T>
void ZeroRows<T>::fill(std::int64_t row, std::int64_t col0, std::int64_t n, T* out) const {
    const std::int64_t r = row - box_.row0;
    if (r < 0 || r >= box_.rows) {
        std::fill_n(out, n, T(0));
        return;
    }
    const std::int64_t first = col0 - box_.col0;
    const std::int64_t begin = std::clamp<std::int64_t>(-first, 0, n);
    const std::int64_t end = std::clamp<std::int64_t>(box_.cols - first, begin, n);
    std::fill_n(out, begin, T(0));
    std::copy(grid_.row(r) + first + begin, grid_.row(r) + first + end, out + begin);
    std::fill_n(out + end, n - end, T(0));
}

template <class T>
void analyse_level(const Sequence& low, const Sequence& high, double scale,
                   const RowSource<T>& fine, const std::array<Channel<T>, 8>& channels) {
    if (is_haar(low, high))
        return analyse_haar_level(static_cast<T>(scale * std::pow(low.taps[0], 3)), fine, channels);
    const FilterPair<T> filters(low, high);
    LatticeBox all = channels[0].box;
    for (const Channel<T>& channel : channels) {
        const std::int64_t row_end =
            std::max(all.row0 + all.rows, channel.box.row0 + channel.box.rows);
        const std::int64_t col_end =
            std::max(all.col0 + all.cols, channel.box.col0 + channel.box.cols);
        all.row0 = std::min(all.row0, channel.box.row0);
        all.col0 = std::min(all.col0, channel.box.col0);
        all.rows = row_end - all.row0;
        all.cols = col_end - all.col0;
    }
    for_each_tile(all, kTileRows, kTileCols, [&](const LatticeBox& tile) {
        AnalysisTile<T>(filters, static_cast<T>(scale), fine, channels, tile).run();
    });
}

template <class T>
void synthesise_level(const Sequence& low, const Sequence& high, double scale,
                      const std::array<Channel<const T>, 8>& channels, const LatticeBox& box,
                      GridView<T> fine) {
    if (is_haar(low, high))
        return synthesise_haar_level(static_cast<T>(scale * std::pow(low.taps[0], 3)), channels,
                                     fine);
    const FilterPair<T> filters(low, high);
    const std::int64_t first = floor_half(box.col0);
    const LatticeBox pairs{box.row0, first, box.rows,
                           floor_half(box.col0 + box.cols - 1) - first + 1};
    for_each_tile(pairs, 2 * kTileRows, kTileCols, [&](const LatticeBox& tile) {
        SynthesisTile<T>(filters, static_cast<T>(scale), channels, tile, box, fine).run();
    });
}

template <class T>
void divide_by_symbol(const std::vector<double>& poles, double gain, GridView<T> grid) {
    for (const double pole_value : poles) {
        const T pole = static_cast<T>(pole_value);
        divide_along_rows(pole, 0, grid);
        divide_along_rows(pole, 2, grid);
        parallel_for(0, grid.rows, kDivisionRows, [&](std::int64_t first, std::int64_t last) {
            if (last - first == kDivisionRows)
                return divide_along_columns<kDivisionRows>(pole, first, grid);
            for (std::int64_t r = first; r < last; ++r) divide_along_columns<1>(pole, r, grid);
        });
    }
    const T factor = static_cast<T>(1 / (gain * gain * gain));
    parallel_for(0, grid.rows, 64, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t r = first; r < last; ++r) {
            const RowTap<T> scaled{grid.row(r), factor};
            row_fir(grid.row(r), grid.cols, &scaled, 1);
        }
    });
}

#define RELIEF_INSTANTIATE(T)                                                                  \
    template class ExtendedRows<T>;                                                            \
    template class ZeroRows<T>;                                                                \
    template void analyse_level(const Sequence&, const Sequence&, double, const RowSource<T>&, \
                                const std::array<Channel<T>, 8>&);                             \
    template void synthesise_level(const Sequence&, const Sequence&, double,                   \
                                   const std::array<Channel<const T>, 8>&, const LatticeBox&,  \
                                   GridView<T>);                                               \
    template void divide_by_symbol(const std::vector<double>&, double, GridView<T>);
RELIEF_INSTANTIATE(float)
RELIEF_INSTANTIATE(double)
#undef RELIEF_INSTANTIATE

}  // namespace relief::multires::barycentric
