#include "multires/cubic_level.h"

#include "multires/cubic_rows.h"
#include "relief/core/parallel.h"
#include "relief/core/rows.h"

namespace relief::multires::cubic {

namespace {

/// Pairs of rows and of columns that a tile has: the rows in work then stay in a core's own cache,
/// and what is computed twice at the borders hardly counts.
constexpr std::int64_t kTileRows = 256;
constexpr std::int64_t kTileCols = 1024;

/// Pairs of rows that are lifted together, while the columns of a block stay in the nearest cache.
constexpr std::int64_t kBatch = 8;
constexpr std::int64_t kBlockBytes = 1024;

/// Rows that are kept: those of a batch, and 2 kReach on either side.
constexpr std::int64_t kKept = 32;
static_assert(kKept >= kBatch + 4 * kReach && (kKept & (kKept - 1)) == 0);

/// Room beside a row for its halo; whole cache lines.
constexpr std::int64_t kMargin = 16;
static_assert(kMargin >= 2 * kReach);

template <class T>
Neighbours<T> weighted_neighbours(const Lifting& lifting, Parity parity) {
    Neighbours<T> neighbours;
    for (int k = 0; k < kTaps; ++k)
        neighbours.weight[k] = static_cast<T>(lifting.factor(parity) * kHalfwayTaps[k]);
    return neighbours;
}

/// The first neighbour of member i on its upper side; the one before is the first on the lower.
constexpr std::int64_t upper_neighbour(Parity parity, std::int64_t i) {
    return parity == Parity::Odd ? i + 1 : i;
}

/// The even or the odd columns of some rows, each row with a margin for the mirror on both sides.
/// Column 0 is the first of the tile's pairs.
template <class T>
class Pane {
  public:
    Pane() = default;
    Pane(std::int64_t rows, std::int64_t cols) : grid_(rows, cols + 2 * kMargin) {}
    T* row(std::int64_t r) { return grid_.row(r) + kMargin; }

  private:
    Grid<T> grid_;
};

/// Both parities of something.
template <class Value>
struct Both {
    Value even;
    Value odd;
    Value& operator[](Parity parity) { return parity == Parity::Even ? even : odd; }
};

/// Lifting along one row.
template <class T>
class RowLifting {
  public:
    RowLifting(const Lifting& lifting, const Axis& cols)
        : cols_(cols),
          even_(weighted_neighbours<T>(lifting, Parity::Even)),
          odd_(weighted_neighbours<T>(lifting, Parity::Odd)) {}

    /// Lifts the members of one parity, and of up to `halo` pairs beyond, by their neighbours,
    /// whose margins it fills.
    void run(Parity parity, std::int64_t halo, const T* in, T* neighbours, T* out) {
        fill_mirror(other(parity), halo + kReach, neighbours);
        Neighbours<T>& from = parity == Parity::Even ? even_ : odd_;
        for (int k = 0; k < kTaps; ++k) {
            from.upper[k] = neighbours + upper_neighbour(parity, k);
            from.lower[k] = neighbours + upper_neighbour(parity, -1 - k);
        }
        const Range existing = cols_.existing(parity, halo);
        lift_row(out, in, from, existing.first - cols_.pairs.first,
                 existing.last - cols_.pairs.first);
    }

  private:
    void fill_mirror(Parity parity, std::int64_t halo, T* row) const {
        const auto [first, last] = cols_.pairs;
        const auto fill = [&](std::int64_t j) {
            row[j - first] = row[cols_.mirrored(parity, j) - first];
        };
        for (std::int64_t j = first - halo; j < 0; ++j) fill(j);
        for (std::int64_t j = cols_.count(parity); j < last + halo; ++j) fill(j);
    }

    Axis cols_;
    Neighbours<T> even_;
    Neighbours<T> odd_;
};

/// Calls fn(first, last) for consecutive blocks of columns.
template <class T, class Function>
void for_blocks(Range cols, Function fn) {
    constexpr std::int64_t block = kBlockBytes / static_cast<std::int64_t>(sizeof(T));
    for (std::int64_t first = cols.first; first < cols.last; first += block)
        fn(Range{first, std::min(first + block, cols.last)});
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
          along_rows_(lifting, cols_),
          weights_{weighted_neighbours<T>(lifting, Parity::Even),
                   weighted_neighbours<T>(lifting, Parity::Odd)} {
        const std::int64_t width = cols_.pairs.last - cols_.pairs.first;
        for (const Parity parity : {Parity::Even, Parity::Odd}) {
            split_[parity] = Pane<T>(1, width);
            for (const Parity row : {Parity::Even, Parity::Odd})
                kept_[row][parity] = Pane<T>(kKept, width);
        }
    }

    void run() {
        const Range first_rows = rows_.existing(first_, kReach);
        std::int64_t loaded[2];
        loaded[index(first_)] = first_rows.first;
        loaded[index(second_)] = rows_.existing(second_, 2 * kReach).first;
        Range stepped{first_rows.first, first_rows.first};
        for (std::int64_t i = rows_.pairs.first; i < rows_.pairs.last; i += kBatch) {
            Axis batch = rows_;
            batch.pairs = {i, std::min(i + kBatch, rows_.pairs.last)};
            stepped = {stepped.last, batch.existing(first_, kReach).last};
            load(first_, loaded[index(first_)], stepped.last);
            load(second_, loaded[index(second_)], batch.existing(second_, 2 * kReach).last);
            for (const Parity col : {Parity::Even, Parity::Odd}) {
                const Range wanted = cols_.existing(col, 0);
                for_blocks<T>({0, wanted.last - wanted.first}, [&](Range block) {
                    if (rows_.n > 1) step_first(col, stepped, block);
                    write(col, batch, block);
                });
            }
        }
        finish_streaming();
    }

  private:
    T* kept(Parity row, Parity col, std::int64_t i) { return kept_[row][col].row(i & (kKept - 1)); }

    /// Rows `next` .. last - 1 of a parity, lifted along themselves.
    void load(Parity row, std::int64_t& next, std::int64_t last) {
        for (; next < last; ++next) load_row(row, next);
    }

    void load_row(Parity row, std::int64_t i) {
        const std::int64_t origin = cols_.pairs.first;
        const Range even = cols_.existing(Parity::Even, 2 * kReach);
        const Range odd = cols_.existing(Parity::Odd, 2 * kReach);
        const T* source = fine_.at(2 * i + static_cast<std::int64_t>(row), 2 * even.first);
        T* out_even = split_.even.row(0) + (even.first - origin);
        const std::int64_t pairs = odd.last - even.first;
        row_split(source, pairs, out_even, split_.odd.row(0) + (even.first - origin));
        if (even.last > odd.last) out_even[pairs] = source[2 * pairs];
        T* first = kept(row, first_, i);
        T* second = kept(row, second_, i);
        if (cols_.n == 1) {
            kept(row, Parity::Even, i)[0] = split_.even.row(0)[0];
            return;
        }
        along_rows_.run(first_, kReach, split_[first_].row(0), split_[second_].row(0), first);
        along_rows_.run(second_, 0, split_[second_].row(0), first, second);
    }

    Neighbours<T>& neighbours(Parity row, Parity col, std::int64_t i) {
        Neighbours<T>& from = weights_[row];
        const Parity beside = other(row);
        const std::int64_t upper = upper_neighbour(row, i);
        for (std::int64_t k = 0; k < kTaps; ++k) {
            from.upper[k] = kept(beside, col, rows_.mirrored(beside, upper + k));
            from.lower[k] = kept(beside, col, rows_.mirrored(beside, upper - 1 - k));
        }
        return from;
    }

    void step_first(Parity col, Range rows, Range block) {
        for (std::int64_t i = rows.first; i < rows.last; ++i) {
            T* row = kept(first_, col, i);
            lift_row(row, row, neighbours(first_, col, i), block.first, block.last);
        }
    }

    /// The finished rows of a batch: those of the first step are copied, the others lifted into
    /// their bands.
    void write(Parity col, const Axis& batch, Range block) {
        const auto target = [&](Parity row, std::int64_t i) {
            return bands_[channel(row, col)].at(i, cols_.pairs.first);
        };
        const Range firsts = batch.existing(first_, 0);
        for (std::int64_t i = firsts.first; i < firsts.last; ++i)
            std::copy(kept(first_, col, i) + block.first, kept(first_, col, i) + block.last,
                      target(first_, i) + block.first);
        const Range seconds = batch.existing(second_, 0);
        for (std::int64_t i = seconds.first; i < seconds.last; ++i) {
            const T* row = kept(second_, col, i);
            if (rows_.n > 1)
                lift_row(target(second_, i), row, neighbours(second_, col, i), block.first,
                         block.last);
            else
                std::copy(row + block.first, row + block.last, target(second_, i) + block.first);
        }
    }

    Parity first_;
    Parity second_;
    Axis rows_;
    Axis cols_;
    const Part<const T>& fine_;
    const Bands<T>& bands_;
    RowLifting<T> along_rows_;
    Both<Neighbours<T>> weights_;
    Both<Pane<T>> split_;       ///< the columns of one row
    Both<Both<Pane<T>>> kept_;  ///< by parity of the row, then of the column
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
          weights_{weighted_neighbours<T>(kSynthesis, Parity::Even),
                   weighted_neighbours<T>(kSynthesis, Parity::Odd)},
          merged_(1, 2 * (cols_.pairs.last - cols_.pairs.first)) {
        const std::int64_t width = cols_.pairs.last - cols_.pairs.first;
        for (const Parity parity : {Parity::Even, Parity::Odd}) {
            kept_[parity] = Pane<T>(kKept, width);
            odd_rows_[parity] = Pane<T>(kBatch, width);
            lifted_[parity] = Pane<T>(1, width);
        }
    }

    void run() {
        const Range even_rows = rows_.existing(Parity::Even, kReach);
        Range stepped{even_rows.first, even_rows.first};
        for (std::int64_t i = rows_.pairs.first; i < rows_.pairs.last; i += kBatch) {
            Axis batch = rows_;
            batch.pairs = {i, std::min(i + kBatch, rows_.pairs.last)};
            stepped = {stepped.last, batch.existing(Parity::Even, kReach).last};
            for (const Parity col : {Parity::Even, Parity::Odd}) {
                const Range wanted = cols_.existing(col, halo(col));
                for_blocks<T>(wanted, [&](Range block) {
                    lift_even_rows(col, stepped, block);
                    lift_odd_rows(col, batch.existing(Parity::Odd, 0), block);
                });
            }
            for (std::int64_t r = batch.pairs.first; r < batch.pairs.last; ++r) {
                write(2 * r, kept(Parity::Even, r), kept(Parity::Odd, r));
                write(2 * r + 1, odd_row(Parity::Even, r), odd_row(Parity::Odd, r));
            }
        }
        finish_streaming();
    }

  private:
    static std::int64_t halo(Parity parity) { return parity == Parity::Even ? kReach : 2 * kReach; }
    T* kept(Parity col, std::int64_t i) { return kept_[col].row(i & (kKept - 1)); }
    T* odd_row(Parity col, std::int64_t i) { return odd_rows_[col].row(i % kBatch); }
    [[nodiscard]] const T* band(Parity row, Parity col, std::int64_t i) const {
        return bands_[channel(row, col)].at(i, cols_.pairs.first);
    }

    template <class RowAt>
    Neighbours<T>& neighbours(Parity row, std::int64_t i, RowAt row_at) {
        Neighbours<T>& from = weights_[row];
        const std::int64_t upper = upper_neighbour(row, i);
        for (std::int64_t k = 0; k < kTaps; ++k) {
            from.upper[k] = row_at(rows_.mirrored(other(row), upper + k));
            from.lower[k] = row_at(rows_.mirrored(other(row), upper - 1 - k));
        }
        return from;
    }

    void lift_even_rows(Parity col, Range rows, Range block) {
        const std::int64_t origin = cols_.pairs.first;
        for (std::int64_t i = rows.first; i < rows.last; ++i) {
            const T* row = band(Parity::Even, col, i);
            if (rows_.n == 1) {
                std::copy(row + block.first - origin, row + block.last - origin,
                          kept(col, i) + block.first - origin);
                continue;
            }
            const auto odd = [&](std::int64_t k) { return band(Parity::Odd, col, k); };
            lift_row(kept(col, i), row, neighbours(Parity::Even, i, odd), block.first - origin,
                     block.last - origin);
        }
    }

    void lift_odd_rows(Parity col, Range rows, Range block) {
        const std::int64_t origin = cols_.pairs.first;
        for (std::int64_t i = rows.first; i < rows.last; ++i) {
            const auto even = [&](std::int64_t k) { return kept(col, k); };
            lift_row(odd_row(col, i), band(Parity::Odd, col, i), neighbours(Parity::Odd, i, even),
                     block.first - origin, block.last - origin);
        }
    }

    /// Lifts along a finished row and writes what of it is wanted.
    void write(std::int64_t y, T* even, T* odd) {
        if (y < fine_.row0 || y >= fine_.row0 + fine_.view.rows) return;
        T* lifted_even = even;
        if (cols_.n > 1) {
            lifted_even = lifted_.even.row(0);
            along_rows_.run(Parity::Even, kReach, even, odd, lifted_even);
            along_rows_.run(Parity::Odd, 0, odd, lifted_even, lifted_.odd.row(0));
        }
        const Range evens = cols_.existing(Parity::Even, 0);
        const Range odds = cols_.existing(Parity::Odd, 0);
        const std::int64_t pairs = odds.last - odds.first;
        T* row = merged_.row(0);
        row_merge(lifted_even, lifted_.odd.row(0), pairs, row);
        if (evens.last > odds.last) row[2 * pairs] = lifted_even[pairs];
        const std::int64_t begin = std::max(2 * evens.first, fine_.col0);
        const std::int64_t end = std::min(evens.last + odds.last, fine_.col0 + fine_.view.cols);
        copy_row<T>(row + (begin - 2 * evens.first), end - begin, fine_.at(y, begin), traffic_);
    }

    Axis rows_;
    Axis cols_;
    const Bands<const T>& bands_;
    Traffic traffic_;
    const Part<T>& fine_;
    RowLifting<T> along_rows_;
    Both<Neighbours<T>> weights_;
    Both<Pane<T>> kept_;      ///< even rows by parity of the column
    Both<Pane<T>> odd_rows_;  ///< of a batch
    Both<Pane<T>> lifted_;    ///< one row
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
