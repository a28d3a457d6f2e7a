#include "relief/multires/fvs_grid_transform.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "multires/fvs_rules.h"
#include "relief/core/parallel.h"
#include "relief/core/rows.h"

namespace relief::multires::fvs {

namespace {

/// Blocks of rows of about 2^18 elements: smaller grids run in the calling thread.
std::int64_t grain_of(std::int64_t cols) {
    return std::max<std::int64_t>(1, (std::int64_t{1} << 18) / std::max<std::int64_t>(1, cols));
}

/// Elements of parity p among n.
constexpr std::int64_t of_parity(std::int64_t n, int p) {
    return (n + 1 - p) / 2;
}

/// The arrays that the even and odd elements of the rows of one parity of a fine array stand in.
template <class T>
struct RowPhases {
    GridView<T> even;
    GridView<T> odd;
};

/// By plane and parity of the row: coarse data and details are phases of the fine data.
template <class T>
using Phases = std::array<std::array<RowPhases<T>, 2>, spline::kFvsPlanes>;

template <class T>
Phases<T> phases_of(const FvsGridView<T>& coarse, const DetailViews<T>& details) {
    Phases<T> phases;
    const auto place = [&](int plane, int row, int col, const GridView<T>& view) {
        RowPhases<T>& pair = phases[std::size_t(plane)][std::size_t(row)];
        (col == 0 ? pair.even : pair.odd) = view;
    };
    for (std::size_t p = 0; p < spline::kFvsPlanes; ++p)
        place(kCoarsePlaces[p].plane, kCoarsePlaces[p].row, kCoarsePlaces[p].col, coarse.planes[p]);
    for (std::size_t k = 0; k < kDetailKinds; ++k)
        place(kDetailPlaces[k].plane, kDetailPlaces[k].row, kDetailPlaces[k].col, details[k]);
    return phases;
}

/// Runs step(fine row, n, even row, odd row) for all rows of all fine arrays.
template <class T, class U, class Step>
void for_phase_rows(const FvsGridView<T>& fine, const Phases<U>& phases, Step step) {
    for (std::size_t p = 0; p < spline::kFvsPlanes; ++p) {
        const GridView<T>& plane = fine.planes[p];
        parallel_for(
            0, plane.rows, grain_of(plane.cols), [&](std::int64_t first, std::int64_t last) {
                for (std::int64_t r = first; r < last; ++r) {
                    const RowPhases<U>& pair = phases[p][std::size_t(r % 2)];
                    step(plane.row(r), plane.cols, pair.even.row(r / 2), pair.odd.row(r / 2));
                }
            });
    }
}

template <class T>
void split(const FvsGridView<const T>& fine, const FvsGridView<T>& coarse,
           const DetailViews<T>& details) {
    const auto step = [](const T* row, std::int64_t n, T* even, T* odd) {
        row_split(row, n / 2, even, odd);
        if (n % 2 == 1) even[n / 2] = row[n - 1];
    };
    for_phase_rows(fine, phases_of(coarse, details), step);
}

template <class T>
void merge_row(T* row, std::int64_t n, const T* even, const T* odd) {
    row_merge(even, odd, n / 2, row);
    if (n % 2 == 1) row[n - 1] = even[n / 2];
}

template <class T>
void merge(const FvsGridView<const T>& coarse, const DetailViews<const T>& details,
           const FvsGridView<T>& fine) {
    for_phase_rows(fine, phases_of(coarse, details), merge_row<T>);
}

/// Fine data continued by one line: odd reflection of values in the last line, first along x.
template <class T>
T continued(const FvsGridView<const T>& fine, int plane, std::int64_t r, std::int64_t c) {
    const std::int64_t last_row = fine.ny(), last_col = fine.nx();
    if (r > last_row) {
        const T mirror = continued(fine, plane, last_row - 1, c);
        return plane == spline::kFvsFy ? mirror
                                       : T(2) * continued(fine, plane, last_row, c) - mirror;
    }
    if (c > last_col) {
        const T mirror = fine[plane](r, last_col - 1);
        return plane == spline::kFvsFx ? mirror : T(2) * fine[plane](r, last_col) - mirror;
    }
    return fine[plane](r, c);
}

/// The coarse data that stand on a line beyond the fine ones.
template <class T>
void continue_coarse(const FvsGridView<const T>& fine, const FvsGridView<T>& coarse) {
    for (std::size_t p = 0; p < spline::kFvsPlanes; ++p) {
        const CoarsePlace& place = kCoarsePlaces[p];
        const GridView<T>& plane = coarse.planes[p];
        const std::int64_t rows = of_parity(fine[place.plane].rows, place.row);
        const std::int64_t cols = of_parity(fine[place.plane].cols, place.col);
        for (std::int64_t r = 0; r < plane.rows; ++r)
            for (std::int64_t c = r < rows ? cols : 0; c < plane.cols; ++c)
                plane(r, c) = continued(fine, place.plane, 2 * r + place.row, 2 * c + place.col);
    }
}

/// How much a derivative's number changes when cells of size 1 become those of the grid.
template <class T>
double scale_of(const FvsGridView<T>& grid, int plane) {
    if (plane == spline::kFvsF) return 1;
    return plane == spline::kFvsFx || plane == spline::kFvsGv ? grid.a : grid.b;
}

/// Details (row, first .. last - 1) of a kind.
struct Segment {
    std::int64_t row;
    std::int64_t first;
    std::int64_t last;
};

/// Weights of the update hold for cells of size 1, those of the prediction as they are.
enum class Weights { AsTheyAre, ForUnitCells };

template <class T>
double weight_of(const Tap& tap, int kind, Weights weights, const FvsGridView<T>& coarse) {
    if (weights == Weights::AsTheyAre) return tap.weight;
    return tap.weight * (scale_of(coarse, detail_plane(kind)) / scale_of(coarse, tap.plane));
}

/// detail[k] += sign * sum of the taps at k.
template <class T>
void gather(const FvsGridView<const T>& coarse, const Taps& taps, int kind, Weights weights,
            const Segment& at, T sign, T* detail) {
    constexpr std::size_t most = 32;  // an edge and its two cells have 25 numbers
    RowTap<T> rows[most];
    int count = 0;
    for (const Tap& tap : taps)
        rows[count++] = {coarse[tap.plane].row(at.row + tap.row) + at.first + tap.col,
                         sign * static_cast<T>(weight_of(tap, kind, weights, coarse))};
    if (count > 0) row_fir_add(detail + at.first, at.last - at.first, rows, count);
}

/// The transpose, into coarse rows first_row .. last_row - 1 only.
template <class T>
void scatter(const T* detail, const Taps& taps, int kind, Weights weights, const Segment& at,
             T sign, std::int64_t first_row, std::int64_t last_row, const FvsGridView<T>& coarse) {
    for (const Tap& tap : taps) {
        const std::int64_t row = at.row + tap.row;
        if (row < first_row || row >= last_row) continue;
        const T weight = sign * static_cast<T>(weight_of(tap, kind, weights, coarse));
        T* target = coarse[tap.plane].row(row) + at.first + tap.col;
        const RowTap<T> source = {detail + at.first, weight};
        if (at.last - at.first == 1)
            *target = *target + weight * *source.row;
        else
            row_fir_add(target, at.last - at.first, &source, 1);
    }
}

/// Runs run(taps, segment) for the update of row `row` of a kind: its columns by class. Two at
/// either end have classes of their own, all between are alike.
template <class Run>
void for_update_segments(int kind, std::int64_t row, std::int64_t cols, std::int64_t nx,
                         std::int64_t ny, Run run) {
    const Owner owner = kDetailPlaces[std::size_t(kind)].owner;
    const UpdateTaps& update = update_taps();
    const int row_class =
        owner == Owner::HorizontalEdge ? edge_class(row, ny) : cell_class(row, ny);
    const auto one = [&](std::int64_t first, std::int64_t last) {
        const int col_class =
            owner == Owner::VerticalEdge ? edge_class(first, nx) : cell_class(first, nx);
        run(update.at(kind, row_class, col_class), Segment{row, first, last});
    };
    const std::int64_t begin = std::min<std::int64_t>(2, cols);
    const std::int64_t end = std::clamp(nx - 1, begin, cols);
    for (std::int64_t c = 0; c < begin; ++c) one(c, c + 1);
    if (begin < end) one(begin, end);
    for (std::int64_t c = end; c < cols; ++c) one(c, c + 1);
}

/// Runs run(first, last) for blocks of coarse rows, each written by one thread.
template <class T, class Run>
void for_coarse_rows(const FvsGridView<T>& coarse, Run run) {
    parallel_for(0, coarse.ny() + 1, grain_of(4 * (coarse.nx() + 1)), run);
}

/// Runs run(kind, row) for the rows of details that reach coarse rows first .. last - 1, in the
/// same order for every coarse row.
template <class T, class Run>
void for_reaching_rows(std::int64_t first, std::int64_t last, const DetailViews<T>& details,
                       Run run) {
    for (std::int64_t r = std::max<std::int64_t>(0, first - 1); r < last + 1; ++r)
        for (int kind = 0; kind < kDetailKinds; ++kind)
            if (r < details[std::size_t(kind)].rows) run(kind, r);
}

/// detail += sign * prediction of a kind.
template <class T>
void add_prediction(const FvsGridView<const T>& coarse, const Taps& taps, int kind, T sign,
                    const GridView<T>& detail) {
    parallel_for(0, detail.rows, grain_of(detail.cols), [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t r = first; r < last; ++r)
            gather(coarse, taps, kind, Weights::AsTheyAre, {r, 0, detail.cols}, sign,
                   detail.row(r));
    });
}

template <class T>
void add_prediction(const FvsGridView<const T>& coarse, T sign, const DetailViews<T>& details) {
    const auto taps = prediction_taps(coarse.a, coarse.b);
    for (std::size_t kind = 0; kind < kDetailKinds; ++kind)
        add_prediction(coarse, taps[kind], static_cast<int>(kind), sign, details[kind]);
}

/// coarse += transpose of the prediction.
template <class T>
void add_prediction_transposed(const DetailViews<T>& details, const FvsGridView<T>& coarse) {
    const auto taps = prediction_taps(coarse.a, coarse.b);
    for_coarse_rows(coarse, [&](std::int64_t first, std::int64_t last) {
        for_reaching_rows(first, last, details, [&](int kind, std::int64_t r) {
            const GridView<T>& detail = details[std::size_t(kind)];
            scatter<T>(detail.row(r), taps[std::size_t(kind)], kind, Weights::AsTheyAre,
                       {r, 0, detail.cols}, T(1), first, last, coarse);
        });
    });
}

/// coarse += sign * update by the details.
template <class T>
void add_update(const DetailViews<T>& details, T sign, const FvsGridView<T>& coarse) {
    for_coarse_rows(coarse, [&](std::int64_t first, std::int64_t last) {
        for_reaching_rows(first, last, details, [&](int kind, std::int64_t r) {
            const GridView<T>& detail = details[std::size_t(kind)];
            for_update_segments(kind, r, detail.cols, coarse.nx(), coarse.ny(),
                                [&](const Taps& taps, const Segment& at) {
                                    scatter<T>(detail.row(r), taps, kind, Weights::ForUnitCells, at,
                                               sign, first, last, coarse);
                                });
        });
    });
}

/// details += sign * transpose of the update.
template <class T>
void add_update_transposed(const FvsGridView<const T>& coarse, T sign,
                           const DetailViews<T>& details) {
    for (int kind = 0; kind < kDetailKinds; ++kind) {
        const GridView<T>& detail = details[std::size_t(kind)];
        parallel_for(
            0, detail.rows, grain_of(detail.cols), [&](std::int64_t first, std::int64_t last) {
                for (std::int64_t r = first; r < last; ++r)
                    for_update_segments(kind, r, detail.cols, coarse.nx(), coarse.ny(),
                                        [&](const Taps& taps, const Segment& at) {
                                            gather(coarse, taps, kind, Weights::ForUnitCells, at,
                                                   sign, detail.row(r));
                                        });
            });
    }
}

template <class T>
void fill_zero(const GridView<T>& plane) {
    for (std::int64_t r = 0; r < plane.rows; ++r) std::fill_n(plane.row(r), plane.cols, T(0));
}

template <class T>
DetailViews<const T> read_only(const DetailViews<T>& details) {
    DetailViews<const T> views;
    std::copy(details.begin(), details.end(), views.begin());
    return views;
}

}  // namespace

std::string_view detail_name(int kind) {
    return kDetailPlaces[std::size_t(kind)].name;
}
int detail_plane(int kind) {
    return kDetailPlaces[std::size_t(kind)].plane;
}

LatticeBox detail_box(int kind, std::int64_t nx, std::int64_t ny) {
    const DetailPlace& place = kDetailPlaces[std::size_t(kind)];
    const std::int64_t rows = place.plane == spline::kFvsGv ? ny : ny + 1;
    const std::int64_t cols = place.plane == spline::kFvsGh ? nx : nx + 1;
    return {0, 0, of_parity(rows, place.row), of_parity(cols, place.col)};
}

template <class T>
Details<T>::Details(std::int64_t nx, std::int64_t ny) {
    for (int kind = 0; kind < kDetailKinds; ++kind) {
        const LatticeBox box = detail_box(kind, nx, ny);
        planes[std::size_t(kind)] = Grid<T>(box.rows, box.cols);
    }
}

template <class T>
DetailViews<T> Details<T>::view() {
    DetailViews<T> views;
    for (std::size_t k = 0; k < kDetailKinds; ++k) views[k] = planes[k].view();
    return views;
}

template <class T>
DetailViews<const T> Details<T>::view() const {
    DetailViews<const T> views;
    for (std::size_t k = 0; k < kDetailKinds; ++k) views[k] = planes[k].view();
    return views;
}

template <class T>
void predict(const FvsGridView<const T>& coarse, const FvsGridView<T>& fine) {
    Details<T> details(fine.nx(), fine.ny());
    for (const GridView<T>& plane : details.view()) fill_zero(plane);
    add_prediction(coarse, T(1), details.view());
    merge(coarse, std::as_const(details).view(), fine);
}

template <class T>
void decompose(const FvsGridView<const T>& fine, Lifting lifting, const FvsGridView<T>& coarse,
               const DetailViews<T>& details) {
    split(fine, coarse, details);
    continue_coarse(fine, coarse);
    add_prediction<T>(coarse, T(-1), details);
    if (lifting == Lifting::L2) add_update(details, T(1), coarse);
}

template <class T>
void details_against(const FvsGridView<const T>& coarse, const FvsGridView<const T>& fine,
                     const DetailViews<T>& details) {
    FvsGrid<T> own(coarse.nx(), coarse.ny());
    split(fine, own.view(), details);
    add_prediction(coarse, T(-1), details);
}

template <class T>
void reconstruct(const FvsGridView<T>& coarse, const DetailViews<T>& details, Lifting lifting,
                 const FvsGridView<T>& fine) {
    if (lifting == Lifting::L2) add_update(details, T(-1), coarse);
    add_prediction<T>(coarse, T(1), details);
    merge<T>(coarse, read_only(details), fine);
}

template <class T>
void transpose(const FvsGridView<const T>& fine_residual, Lifting lifting,
               const FvsGridView<T>& coarse, const DetailViews<T>& details) {
    for (const GridView<T>& plane : coarse.planes) fill_zero(plane);
    split(fine_residual, coarse, details);
    add_prediction_transposed(details, coarse);
    if (lifting == Lifting::L2) add_update_transposed<T>(coarse, T(-1), details);
}

template <class T>
void predict_values(GridView<const T> coarse, GridView<T> fine) {
    const auto part = spline::RasterPart<T>::whole(coarse);
    const auto grid = spline::estimate_fvs_grid(part, {0, 0, coarse.rows, coarse.cols});
    const auto taps = prediction_taps(1, 1);
    const auto predicted = [&](int kind) {
        const LatticeBox box = detail_box(kind, fine.cols - 1, fine.rows - 1);
        Grid<T> values(box.rows, box.cols, T(0));
        add_prediction<T>(grid->view(), taps[std::size_t(kind)], kind, T(1), values.view());
        return values;
    };
    const Grid<T> across = predicted(kEhv), down = predicted(kEvv), centre = predicted(kCv);
    const RowPhases<const T> phases[2] = {{coarse, across.view()}, {down.view(), centre.view()}};
    for (std::int64_t r = 0; r < fine.rows; ++r)
        merge_row(fine.row(r), fine.cols, phases[r % 2].even.row(r / 2),
                  phases[r % 2].odd.row(r / 2));
}

#define RELIEF_INSTANTIATE(T)                                                               \
    template struct Details<T>;                                                             \
    template void predict(const FvsGridView<const T>&, const FvsGridView<T>&);              \
    template void decompose(const FvsGridView<const T>&, Lifting, const FvsGridView<T>&,    \
                            const DetailViews<T>&);                                         \
    template void details_against(const FvsGridView<const T>&, const FvsGridView<const T>&, \
                                  const DetailViews<T>&);                                   \
    template void reconstruct(const FvsGridView<T>&, const DetailViews<T>&, Lifting,        \
                              const FvsGridView<T>&);                                       \
    template void transpose(const FvsGridView<const T>&, Lifting, const FvsGridView<T>&,    \
                            const DetailViews<T>&);                                         \
    template void predict_values(GridView<const T>, GridView<T>);
RELIEF_INSTANTIATE(float)
RELIEF_INSTANTIATE(double)
#undef RELIEF_INSTANTIATE

}  // namespace relief::multires::fvs
