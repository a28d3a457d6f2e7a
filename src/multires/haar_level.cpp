#include "multires/haar_level.h"

#include <algorithm>

#include "multires/haar_rows.h"
#include "multires/strips.h"
#include "relief/core/parallel.h"

namespace relief::multires::barycentric {

namespace {

/// Columns at the left end that run apart: a whole cache line, so that the rows behind stay
/// aligned.
template <class T>
constexpr std::int64_t kLine = 64 / std::int64_t(sizeof(T));

template <class T>
class HaarAnalysis {
  public:
    HaarAnalysis(T scale, const RowSource<T>& fine, const std::array<Channel<T>, 8>& channels)
        : scale_(scale),
          fine_(fine),
          channels_(channels),
          rows_(fine.box().rows),
          cols_(channels[0].box.cols),
          inner_begin_(std::min(kLine<T>, cols_)),
          inner_end_(std::max(inner_begin_, fine.box().cols / 2)),
          details_(streamed_if_large<T>(fine.box().count())),
          filled_(3, 2 * cols_ + 1) {}

    void run(std::int64_t i) {
        if (i == 0 || 2 * i + 1 >= rows_) return run_filled(i, 0, cols_);
        run_filled(i, 0, inner_begin_);
        const std::int64_t col = 2 * inner_begin_ - 1;
        run_columns({fine_.at(2 * i - 1, col), fine_.at(2 * i, col), fine_.at(2 * i + 1, col)}, i,
                    inner_begin_, inner_end_);
        run_filled(i, inner_end_, cols_);
    }

  private:
    void run_filled(std::int64_t i, std::int64_t begin, std::int64_t end) {
        for (std::int64_t k = 0; k < 3; ++k)
            fine_.fill(2 * i - 1 + k, 2 * begin - 1, 2 * (end - begin) + 1, filled_.row(k));
        run_columns({filled_.row(0), filled_.row(1), filled_.row(2)}, i, begin, end);
    }

    void run_columns(const std::array<const T*, 3>& fine, std::int64_t i, std::int64_t begin,
                     std::int64_t end) {
        std::array<T*, 8> out;
        for (std::size_t c = 0; c < 8; ++c) out[c] = channels_[c].view.row(i) + begin;
        haar_analysis_row(scale_, fine, end - begin, out, details_);
    }

    T scale_;
    const RowSource<T>& fine_;
    const std::array<Channel<T>, 8>& channels_;
    std::int64_t rows_;
    std::int64_t cols_;
    std::int64_t inner_begin_;  ///< coefficients of inner columns read stored columns only
    std::int64_t inner_end_;
    Traffic details_;
    Grid<T> filled_;
};

/// fine(2i, 2j) = f000(i, j) + f111(i, j), fine(2i, 2j + 1) = f010(i, j) + f101(i, j + 1), fine(2i
/// + 1, 2j) = f100(i, j) + f011(i + 1, j), fine(2i + 1, 2j + 1) = f110(i, j) + f001(i + 1, j + 1):
/// f_lmn are the points of coarse (i, j) at 2(i, j) + l e1 + m e2 + n e3.
template <class T>
class HaarSynthesis {
  public:
    HaarSynthesis(T scale, const std::array<Channel<const T>, 8>& channels, GridView<T> fine)
        : scale_(scale),
          channels_(channels),
          fine_(fine),
          traffic_(streamed_if_large<T>(fine.count())),
          cols_(channels[0].box.cols),
          points_{Grid<T>(8, cols_), Grid<T>(8, cols_)},
          merged_(1, fine.cols + 1) {}

    /// Fine rows 2 first .. 2 last - 1.
    void run(std::int64_t first, std::int64_t last) {
        form_points(first);
        for (std::int64_t i = first; i < last; ++i) {
            const Grid<T>& here = points_[i % 2];
            const std::array<const T*, 2> odd = {here.row(2), here.row(5) + 1};
            write({here.row(0), here.row(7)}, odd, 2 * i);
            if (2 * i + 1 == fine_.rows) break;
            form_points(i + 1);
            const Grid<T>& next = points_[(i + 1) % 2];
            write({here.row(4), next.row(3)}, {here.row(6), next.row(1) + 1}, 2 * i + 1);
        }
        finish_streaming();
    }

  private:
    void form_points(std::int64_t i) {
        std::array<const T*, 8> in;
        std::array<T*, 8> out;
        for (std::size_t k = 0; k < 8; ++k) {
            in[k] = channels_[k].view.row(i);
            out[k] = points_[i % 2].row(std::int64_t(k));
        }
        haar_points_row(scale_, in, cols_, out);
    }

    void write(const std::array<const T*, 2>& even, const std::array<const T*, 2>& odd,
               std::int64_t row) {
        const std::int64_t pairs = fine_.cols / 2;
        T* out = traffic_ == Traffic::Streamed ? merged_.row(0) : fine_.row(row);
        merge_sums_row(even, odd, pairs, out);
        if (fine_.cols % 2 == 1) out[2 * pairs] = even[0][pairs] + even[1][pairs];
        if (traffic_ == Traffic::Streamed) copy_row(out, fine_.cols, fine_.row(row), traffic_);
    }

    T scale_;
    const std::array<Channel<const T>, 8>& channels_;
    GridView<T> fine_;
    Traffic traffic_;
    std::int64_t cols_;
    std::array<Grid<T>, 2> points_;  ///< of an even and an odd coarse row; row 4 l + 2 m + n
    Grid<T> merged_;
};

}  // namespace

bool is_haar(const Sequence& low, const Sequence& high) {
    if (low.first != 0 || high.first != 0 || low.taps.size() != 2 || high.taps.size() != 2)
        return false;
    const double weight = low.taps[0];
    return low.taps[1] == weight && high.taps[0] == weight && high.taps[1] == -weight;
}

template <class T>
void analyse_haar_level(T scale, const RowSource<T>& fine,
                        const std::array<Channel<T>, 8>& channels) {
    const std::int64_t rows = channels[0].box.rows;
    parallel_for(0, rows, strip_rows(rows), [&](std::int64_t first, std::int64_t last) {
        HaarAnalysis<T> strip(scale, fine, channels);
        for (std::int64_t i = first; i < last; ++i) strip.run(i);
        finish_streaming();
    });
}

template <class T>
void synthesise_haar_level(T scale, const std::array<Channel<const T>, 8>& channels,
                           GridView<T> fine) {
    const std::int64_t rows = (fine.rows + 1) / 2;
    parallel_for(0, rows, strip_rows(rows), [&](std::int64_t first, std::int64_t last) {
        HaarSynthesis<T>(scale, channels, fine).run(first, last);
    });
}

#define RELIEF_INSTANTIATE(T)                                                                   \
    template void analyse_haar_level(T, const RowSource<T>&, const std::array<Channel<T>, 8>&); \
    template void synthesise_haar_level(T, const std::array<Channel<const T>, 8>&, GridView<T>);
RELIEF_INSTANTIATE(float)
RELIEF_INSTANTIATE(double)
#undef RELIEF_INSTANTIATE

}  // namespace relief::multires::barycentric
