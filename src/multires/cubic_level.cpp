#include "multires/cubic_level.h"

#include "multires/cubic_rows.h"
#include "relief/core/parallel.h"
#include "relief/core/rows.h"

namespace relief::multires::cubic {

namespace {

/// Pairs of rows and of columns that a tile has: the rows in work then stay in a core's own cache,
/// and what is computed twice at the borders hardly counts.
constexpr std::int64_t kTileRows = 256;
constexpr std::int64_t kTileCols = 2048;

/// Pairs of rows that are lifted together, while the columns of a block stay in the nearest cache.
constexpr std::int64_t kBatch = 8;
constexpr std::int64_t kBlockBytes = 1024;

/// Pairs of rows that are kept: those of a batch, and 2 kReach on either side.
constexpr std::int64_t kKept = 32;
static_assert(kKept >= kBatch + 4 * kReach);

/// Room beside a row for its halo, in whole cache lines.
constexpr std::int64_t kMargin = 16;
static_assert(kMargin >= 2 * kReach);

/// Some rows, each with its even and its odd columns apart and margins around both for halo and
/// mirror. Column 0 is the first of the tile's pairs.
template <class T>
class SplitRows {
  public:
    SplitRows(std::int64_t rows, std::int64_t pairs)
        : width_((pairs + 3 * kMargin - 1) / kMargin * kMargin), grid_(rows, 2 * width_) {}
    T* row(std::int64_t r, Parity col) {
        return grid_.row(r) + (col == Parity::Even ? 0 : width_) + kMargin;
    }

  private:
    std::int64_t width_;
    Grid<T> grid_;
};

/// The neighbours that a step reads, by parity of the members that it changes.
template <class T>
class Steps {
  public:
    explicit Steps(const Lifting& lifting) {
        for (const Parity parity : {Parity::Even, Parity::Odd})
            for (int k = 0; k < kTaps; ++k)
                neighbours_[index(parity)].weight[k] =
                    static_cast<T>(lifting.factor(parity) * kHalfwayTaps[k]);
    }

    /// Those of member i; at(k) is where member k of the other parity stands.
    template <class At>
    const Neighbours<T>& of(Parity parity, std::int64_t i, At at) {
        Neighbours<T>& from = neighbours_[index(parity)];
        const std::int64_t upper = parity == Parity::Odd ? i + 1 : i;
        for (std::int64_t k = 0; k < kTaps; ++k) {
            from.lower[k] = at(upper - 1 - k);
            from.upper[k] = at(upper + k);
        }
        return from;
    }

  private:
    Neighbours<T> neighbours_[2];
};

/// Lifting along one row.
template <class T>
class RowLifting {
  public:
    RowLifting(const Lifting& lifting, const Axis& cols) : cols_(cols), steps_(lifting) {}

    /// Lifts the members of one parity, and of up to `halo` pairs beyond, by their neighbours,
    /// whose margins it fills.
    void run(Parity parity, std::int64_t halo, const T* in, T* neighbours, T* out) {
        fill_mirror(other(parity), halo + kReach, neighbours);
        const auto& from = steps_.of(parity, 0, [&](std::int64_t k) { return neighbours + k; });
        const Range range = cols_.existing(parity, halo);
        lift_row(out, in, from, range.first - cols_.pairs.first, range.last - cols_.pairs.first);
    }

  private:
    void fill_mirror(Parity parity, std::int64_t halo, T* row) const {
        const std::int64_t first = cols_.pairs.first;
        const std::int64_t last = cols_.pairs.last;
        const auto fill = [&](std::int64_t j) {
            row[j - first] = row[cols_.mirrored(parity, j) - first];
        };
        for (std::int64_t j = first - halo; j < 0; ++j) fill(j);
        for (std::int64_t j = cols_.count(parity); j < last + halo; ++j) fill(j);
    }

    Axis cols_;
    Steps<T> steps_;
};

/// Calls fn(first, last) for consecutive blocks of columns.
template <class T, class Function>
void for_blocks(Range cols, Function fn) {
    constexpr std::int64_t block = kBlockBytes / static_cast<std::int64_t>(sizeof(T));
    for (std::int64_t first = cols.first; first < cols.last; first += block)
        fn(Range{first, std::min(first + block, cols.last)});
}

/// Consecutive batches of the pairs of an axis.
template <class Function>
void for_batches(const Axis& axis, Function fn) {
    for (std::int64_t i = axis.pairs.first; i < axis.pairs.last; i += kBatch)
        fn(Axis{axis.n, {i, std::min(i + kBatch, axis.pairs.last)}});
}

/// A tile of split_level.
template <class T>
class Splitting {
  public:
    Splitting(const Lifting& lifting, const Window& tile, const Part<const T>& fine,
              const Bands<T>& bands)
        : first_(lifting.first),
          second_(other(first_)),
          rows_(tile.rows),
          cols_(tile.cols),
          fine_(fine),
          bands_(bands),
          traffic_(streamed_if_large<T>(bands[0].view.count())),
          along_rows_(lifting, cols_),
          steps_(lifting),
          split_(1, cols_.pairs.last - cols_.pairs.first),
          kept_(2 * kKept, cols_.pairs.last - cols_.pairs.first) {}

    void run() {
        std::int64_t first_rows = rows_.existing(first_, kReach).first;
        std::int64_t second_rows = rows_.existing(second_, 2 * kReach).first;
        for_batches(rows_, [&](const Axis& batch) {
            const Range stepped{first_rows, batch.existing(first_, kReach).last};
            for (; first_rows < stepped.last; ++first_rows) load(first_, first_rows);
            for (; second_rows < batch.existing(second_, 2 * kReach).last; ++second_rows)
                load(second_, second_rows);
            for (const Parity col : {Parity::Even, Parity::Odd})
                for_blocks<T>(cols_.existing(col, 0), [&](Range block) {
                    lift(first_, stepped, col, block);
                    lift(second_, batch.existing(second_, 0), col, block);
                    write(first_, batch.existing(first_, 0), col, block);
                    write(second_, batch.existing(second_, 0), col, block);
                });
        });
        finish_streaming();
    }

  private:
    T* kept(Parity row, std::int64_t i, Parity col) {
        return kept_.row((2 * i + static_cast<std::int64_t>(row)) % (2 * kKept), col);
    }

    /// Reads a row and lifts along it.
    void load(Parity row, std::int64_t i) {
        const Range even = cols_.existing(Parity::Even, 2 * kReach);
        const Range odd = cols_.existing(Parity::Odd, 2 * kReach);
        const T* source = fine_.at(2 * i + static_cast<std::int64_t>(row), 2 * even.first);
        const std::int64_t first = even.first - cols_.pairs.first;
        const std::int64_t pairs = odd.last - even.first;
        if (cols_.n == 1) {
            kept(row, i, Parity::Even)[0] = source[0];
            return;
        }
        T* split_even = split_.row(0, Parity::Even) + first;
        row_split(source, pairs, split_even, split_.row(0, Parity::Odd) + first);
        if (even.last > odd.last) split_even[pairs] = source[2 * pairs];
        T* lifted = kept(row, i, first_);
        along_rows_.run(first_, kReach, split_.row(0, first_), split_.row(0, second_), lifted);
        along_rows_.run(second_, 0, split_.row(0, second_), lifted, kept(row, i, second_));
    }

    void lift(Parity row, Range rows, Parity col, Range block) {
        if (rows_.n == 1) return;
        const std::int64_t origin = cols_.pairs.first;
        for (std::int64_t i = rows.first; i < rows.last; ++i) {
            const auto& from = steps_.of(row, i, [&](std::int64_t k) {
                return kept(other(row), rows_.mirrored(other(row), k), col);
            });
            T* lifted = kept(row, i, col);
            lift_row(lifted, lifted, from, block.first - origin, block.last - origin);
        }
    }

    void write(Parity row, Range rows, Parity col, Range block) {
        for (std::int64_t i = rows.first; i < rows.last; ++i)
            copy_row<T>(kept(row, i, col) + (block.first - cols_.pairs.first),
                        block.last - block.first, bands_[channel(row, col)].at(i, block.first),
                        traffic_);
    }

    Parity first_;
    Parity second_;
    Axis rows_;
    Axis cols_;
    const Part<const T>& fine_;
    const Bands<T>& bands_;
    Traffic traffic_;
    RowLifting<T> along_rows_;
    Steps<T> steps_;
    SplitRows<T> split_;
    SplitRows<T> kept_;
};

/// A tile of merge_level.
template <class T>
class Merging {
  public:
    Merging(const Window& tile, const Bands<const T>& bands, Traffic traffic, const Part<T>& fine)
        : rows_(tile.rows),
          cols_(tile.cols),
          bands_(bands),
          traffic_(traffic),
          fine_(fine),
          along_rows_(kSynthesis, cols_),
          steps_(kSynthesis),
          even_rows_(kKept, cols_.pairs.last - cols_.pairs.first),
          odd_rows_(kBatch, cols_.pairs.last - cols_.pairs.first),
          lifted_(1, cols_.pairs.last - cols_.pairs.first),
          merged_(1, 2 * (cols_.pairs.last - cols_.pairs.first)) {}

    void run() {
        std::int64_t next = rows_.existing(Parity::Even, kReach).first;
        for_batches(rows_, [&](const Axis& batch) {
            const Range even_rows{next, batch.existing(Parity::Even, kReach).last};
            const Range odd_rows = batch.existing(Parity::Odd, 0);
            next = even_rows.last;
            for (const Parity col : {Parity::Even, Parity::Odd})
                for_blocks<T>(wanted(col), [&](Range block) {
                    lift_even_rows(even_rows, col, block);
                    lift_odd_rows(odd_rows, col, block);
                });
            for (std::int64_t i = batch.pairs.first; i < batch.pairs.last; ++i) {
                write(2 * i, even_rows_, i % kKept);
                write(2 * i + 1, odd_rows_, i % kBatch);
            }
        });
        finish_streaming();
    }

  private:
    /// Columns whose rows are needed to lift along them.
    [[nodiscard]] Range wanted(Parity col) const {
        return cols_.existing(col, col == Parity::Even ? kReach : 2 * kReach);
    }
    [[nodiscard]] const T* band(Parity row, std::int64_t i, Parity col) const {
        return bands_[channel(row, col)].at(i, cols_.pairs.first);
    }

    void lift_even_rows(Range rows, Parity col, Range block) {
        const std::int64_t first = block.first - cols_.pairs.first;
        const std::int64_t last = block.last - cols_.pairs.first;
        for (std::int64_t i = rows.first; i < rows.last; ++i) {
            const T* row = band(Parity::Even, i, col);
            T* lifted = even_rows_.row(i % kKept, col);
            if (rows_.n == 1) {
                std::copy(row + first, row + last, lifted + first);
                continue;
            }
            const auto& from = steps_.of(Parity::Even, i, [&](std::int64_t k) {
                return band(Parity::Odd, rows_.mirrored(Parity::Odd, k), col);
            });
            lift_row(lifted, row, from, first, last);
        }
    }

    void lift_odd_rows(Range rows, Parity col, Range block) {
        const std::int64_t first = block.first - cols_.pairs.first;
        const std::int64_t last = block.last - cols_.pairs.first;
        for (std::int64_t i = rows.first; i < rows.last; ++i) {
            const auto& from = steps_.of(Parity::Odd, i, [&](std::int64_t k) {
                return even_rows_.row(rows_.mirrored(Parity::Even, k) % kKept, col);
            });
            lift_row(odd_rows_.row(i % kBatch, col), band(Parity::Odd, i, col), from, first, last);
        }
    }

    /// Lifts along a row and writes what of it is wanted.
    void write(std::int64_t y, SplitRows<T>& rows, std::int64_t r) {
        if (y < fine_.row0 || y >= fine_.row0 + fine_.view.rows) return;
        T* even = rows.row(r, Parity::Even);
        T* odd = rows.row(r, Parity::Odd);
        if (cols_.n > 1) {
            T* lifted_even = lifted_.row(0, Parity::Even);
            T* lifted_odd = lifted_.row(0, Parity::Odd);
            along_rows_.run(Parity::Even, kReach, even, odd, lifted_even);
            along_rows_.run(Parity::Odd, 0, odd, lifted_even, lifted_odd);
            even = lifted_even;
            odd = lifted_odd;
        }
        const Range evens = cols_.existing(Parity::Even, 0);
        const Range odds = cols_.existing(Parity::Odd, 0);
        const std::int64_t pairs = odds.last - odds.first;
        T* samples = merged_.row(0);
        row_merge(even, odd, pairs, samples);
        if (evens.last > odds.last) samples[2 * pairs] = even[pairs];
        const std::int64_t first = std::max(2 * evens.first, fine_.col0);
        const std::int64_t last = std::min(evens.last + odds.last, fine_.col0 + fine_.view.cols);
        copy_row<T>(samples + (first - 2 * evens.first), last - first, fine_.at(y, first),
                    traffic_);
    }

    Axis rows_;
    Axis cols_;
    const Bands<const T>& bands_;
    Traffic traffic_;
    const Part<T>& fine_;
    RowLifting<T> along_rows_;
    Steps<T> steps_;
    SplitRows<T> even_rows_;
    SplitRows<T> odd_rows_;  ///< of a batch
    SplitRows<T> lifted_;
    Grid<T> merged_;
};

/// Calls fn(tile) for the tiles of a window, in parallel.
template <class Function>
void for_tiles(const Window& window, Function fn) {
    const auto cut = [](const Axis& axis, std::int64_t size, std::int64_t k) {
        const std::int64_t first = axis.pairs.first + k * size;
        return Axis{axis.n, {first, std::min(first + size, axis.pairs.last)}};
    };
    const auto count = [](const Range& range, std::int64_t size) {
        return (range.last - range.first + size - 1) / size;
    };
    const std::int64_t across = count(window.cols.pairs, kTileCols);
    const std::int64_t tiles = count(window.rows.pairs, kTileRows) * across;
    parallel_for(0, tiles, 1, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t k = first; k < last; ++k)
            fn(Window{cut(window.rows, kTileRows, k / across),
                      cut(window.cols, kTileCols, k % across)});
    });
}

}  // namespace

template <class T>
void split_level(const Lifting& lifting, const Window& window, const Part<const T>& fine,
                 const Bands<T>& bands) {
    for_tiles(window, [&](const Window& tile) { Splitting<T>(lifting, tile, fine, bands).run(); });
}

template <class T>
void merge_level(const Window& window, const Bands<const T>& bands, Traffic traffic,
                 const Part<T>& fine) {
    for_tiles(window, [&](const Window& tile) { Merging<T>(tile, bands, traffic, fine).run(); });
}

#define RELIEF_INSTANTIATE(T)                                                      \
    template void split_level(const Lifting&, const Window&, const Part<const T>&, \
                              const Bands<T>&);                                    \
    template void merge_level(const Window&, const Bands<const T>&, Traffic, const Part<T>&);
RELIEF_INSTANTIATE(float)
RELIEF_INSTANTIATE(double)
#undef RELIEF_INSTANTIATE

}  // namespace relief::multires::cubic
