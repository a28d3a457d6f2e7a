#include "relief/multires/cubic_window.h"

#include <algorithm>
#include <string>
#include <utility>

#include "multires/cubic_exact.h"
#include "multires/cubic_lattice.h"

namespace relief::multires::cubic {

namespace {

LatticeBox box_of(Range rows, Range cols) {
    return {rows.first, cols.first, rows.last - rows.first, cols.last - cols.first};
}

Status check_window(const PyramidLayout& layout, int lowest, int level, const LatticeBox& window) {
    const auto refuse = [](std::string what) {
        return Error{ErrorCode::InvalidArgument, std::move(what), "window"};
    };
    if (level < lowest || level > layout.levels())
        return refuse("there is no level " + std::to_string(level) + "; give " +
                      std::to_string(lowest) + " to " + std::to_string(layout.levels()));
    const Lattice lattice = lattice_at(layout, level);
    if (window.rows >= 1 && window.cols >= 1 && window.row0 >= 0 && window.col0 >= 0 &&
        window.row0 <= lattice.rows - window.rows && window.col0 <= lattice.cols - window.cols)
        return {};
    return refuse("it is empty or not inside the " + std::to_string(lattice.rows) + " x " +
                  std::to_string(lattice.cols) + " values of level " + std::to_string(level));
}

Error wrong_size(const LatticeBox& expected) {
    return Error{ErrorCode::InvalidArgument,
                 "values of another size than needed: give " + std::to_string(expected.rows) +
                     " x " + std::to_string(expected.cols),
                 "window"};
}

template <class T>
bool has_size(const GridView<const T>& grid, const LatticeBox& box) {
    return grid.rows == box.rows && grid.cols == box.cols;
}

/// The pairs of a fine lattice that a box of it has samples of; exact mode works on all.
Window pairs_around(const SchemeSpec& spec, const Lattice& fine, const LatticeBox& box) {
    if (spec.exact) return whole(fine);
    return {{fine.rows, {box.row0 / 2, (box.row0 + box.rows + 1) / 2}},
            {fine.cols, {box.col0 / 2, (box.col0 + box.cols + 1) / 2}}};
}

/// What synthesis of some pairs reads, by channel.
std::array<LatticeBox, 4> read_boxes(const SchemeSpec& spec, const Window& pairs) {
    const auto range = [&](const Axis& axis, Parity parity) {
        if (spec.exact) return Range{0, axis.count(parity)};
        return axis.existing(parity, parity == Parity::Even ? kReach : 2 * kReach);
    };
    std::array<LatticeBox, 4> boxes;
    for (const Parity row : {Parity::Even, Parity::Odd})
        for (const Parity col : {Parity::Even, Parity::Odd})
            boxes[channel(row, col)] = box_of(range(pairs.rows, row), range(pairs.cols, col));
    return boxes;
}

template <class T>
Grid<T> copied(GridView<const T> from, std::int64_t row0, std::int64_t col0,
               const LatticeBox& box) {
    Grid<T> out(box.rows, box.cols);
    for (std::int64_t r = 0; r < box.rows; ++r)
        std::copy_n(from.row(box.row0 - row0 + r) + (box.col0 - col0), box.cols, out.row(r));
    return out;
}

/// The values of `fine` on `box` from the parts of the bands that read_boxes gives.
template <class T>
Grid<T> merged(const SchemeSpec& spec, const Lattice& fine, const LatticeBox& box,
               const Bands<const T>& bands) {
    if (spec.exact) {
        Grid<T> all(fine.rows, fine.cols);
        merge_level_exactly<T>(bands, all.view());
        return copied<T>(all.view(), 0, 0, box);
    }
    Grid<T> out(box.rows, box.cols);
    merge_level<T>(pairs_around(spec, fine, box), bands, Traffic::Cached,
                   {out.view(), box.row0, box.col0});
    return out;
}

/// Where values are needed, from `level` (the window) to the coarsest level.
std::vector<LatticeBox> value_boxes(const PyramidLayout& layout, int level,
                                    const LatticeBox& window) {
    std::vector<LatticeBox> boxes = {window};
    for (int l = level; l < layout.levels(); ++l)
        boxes.push_back(read_boxes(
            layout.spec, pairs_around(layout.spec, lattice_at(layout, l), boxes.back()))[0]);
    return boxes;
}

}  // namespace

std::vector<LatticeBox> needed_boxes(const PyramidLayout& layout, int level,
                                     const LatticeBox& window) {
    const std::vector<LatticeBox> values = value_boxes(layout, level, window);
    std::vector<LatticeBox> boxes(layout.bands.size());
    boxes[0] = values.back();
    for (int l = level; l < layout.levels(); ++l) {
        const auto read =
            read_boxes(layout.spec, pairs_around(layout.spec, lattice_at(layout, l),
                                                 values[static_cast<std::size_t>(l - level)]));
        for (int k = 1; k < 4; ++k)
            boxes[band_of(layout, l + 1, k)] = read[static_cast<std::size_t>(k)];
    }
    return boxes;
}

template <class T>
Result<Grid<T>> synthesise_window(const PyramidLayout& layout, int level, const LatticeBox& window,
                                  const std::vector<GridView<const T>>& bands) {
    RELIEF_CHECK(check_window(layout, 0, level, window));
    const std::vector<LatticeBox> needed = needed_boxes(layout, level, window);
    if (bands.size() != needed.size())
        return Error{ErrorCode::InvalidArgument,
                     "give all " + std::to_string(needed.size()) + " bands", "window"};
    for (std::size_t k = 0; k < needed.size(); ++k)
        if (needed[k].count() > 0 && !has_size(bands[k], needed[k])) return wrong_size(needed[k]);
    const std::vector<LatticeBox> boxes = value_boxes(layout, level, window);
    Grid<T> values = copied<T>(bands[0], needed[0].row0, needed[0].col0, needed[0]);
    for (int l = layout.levels(); l > level; --l) {
        const LatticeBox& coarse = boxes[static_cast<std::size_t>(l - level)];
        Bands<const T> parts;
        parts[0] = {values.view(), coarse.row0, coarse.col0};
        for (int k = 1; k < 4; ++k) {
            const std::size_t band = band_of(layout, l, k);
            parts[static_cast<std::size_t>(k)] = {bands[band], needed[band].row0,
                                                  needed[band].col0};
        }
        values = merged(layout.spec, lattice_at(layout, l - 1),
                        boxes[static_cast<std::size_t>(l - 1 - level)], parts);
    }
    return values;
}

AnalysisBoxes analysis_boxes(const PyramidLayout& layout, int level, const LatticeBox& window) {
    const Lattice fine = lattice_at(layout, level - 1);
    const Axis rows{fine.rows, {window.row0, window.row0 + window.rows}};
    const Axis cols{fine.cols, {window.col0, window.col0 + window.cols}};
    AnalysisBoxes boxes;
    for (const Parity row : {Parity::Even, Parity::Odd})
        for (const Parity col : {Parity::Even, Parity::Odd})
            boxes.bands[channel(row, col)] = box_of(rows.existing(row, 0), cols.existing(col, 0));
    const auto read = [&](const Axis& axis) {
        if (layout.spec.exact) return Range{0, axis.n};
        const Range even = axis.existing(Parity::Even, 2 * kReach);
        return Range{2 * even.first, std::min(2 * even.last, axis.n)};
    };
    boxes.finer = box_of(read(rows), read(cols));
    return boxes;
}

template <class T>
Result<std::array<Grid<T>, 4>> analyse_window(const PyramidLayout& layout, int level,
                                              const LatticeBox& window, GridView<const T> finer) {
    RELIEF_CHECK(check_window(layout, 1, level, window));
    const AnalysisBoxes boxes = analysis_boxes(layout, level, window);
    if (!has_size(finer, boxes.finer)) return wrong_size(boxes.finer);
    const Lattice fine = lattice_at(layout, level - 1);
    const LatticeBox all{0, 0, (fine.rows + 1) / 2, (fine.cols + 1) / 2};
    const LatticeBox& worked_on = layout.spec.exact ? all : window;
    const AnalysisBoxes worked = analysis_boxes(layout, level, worked_on);
    std::array<Grid<T>, 4> out;
    Bands<T> parts;
    for (std::size_t k = 0; k < 4; ++k) {
        const LatticeBox& box = worked.bands[k];
        out[k] = Grid<T>(box.rows, box.cols);
        parts[k] = {out[k].view(), box.row0, box.col0};
    }
    if (layout.spec.exact) {
        split_level_exactly<T>(kAnalysis, finer, parts);
        for (std::size_t k = 0; k < 4; ++k) out[k] = copied<T>(out[k].view(), 0, 0, boxes.bands[k]);
        return out;
    }
    const Window pairs{{fine.rows, {window.row0, window.row0 + window.rows}},
                       {fine.cols, {window.col0, window.col0 + window.cols}}};
    split_level<T>(kAnalysis, pairs, {finer, boxes.finer.row0, boxes.finer.col0}, parts);
    return out;
}

#define RELIEF_INSTANTIATE(T)                                                                \
    template Result<Grid<T>> synthesise_window(const PyramidLayout&, int, const LatticeBox&, \
                                               const std::vector<GridView<const T>>&);       \
    template Result<std::array<Grid<T>, 4>> analyse_window(const PyramidLayout&, int,        \
                                                           const LatticeBox&, GridView<const T>);
RELIEF_INSTANTIATE(float)
RELIEF_INSTANTIATE(double)
#undef RELIEF_INSTANTIATE

}  // namespace relief::multires::cubic
