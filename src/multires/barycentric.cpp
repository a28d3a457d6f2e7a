#include "relief/multires/barycentric.h"

#include <algorithm>
#include <optional>
#include <string>

#include "multires/barycentric_tiles.h"
#include "relief/core/parallel.h"

namespace relief::multires::barycentric {

namespace {

constexpr int kMostLevels = 24;
/// By default a further level must divide the number of scaling coefficients by at least this much
/// (4 without borders): where the border ring is a large part of what there is, its extrapolated
/// values cost more than they describe.
constexpr double kLeastReduction = 3.3;

/// First and number of coarse x with [2x + k0, 2x + k1] meeting [lo, hi].
std::pair<std::int64_t, std::int64_t> reaching(std::int64_t lo, std::int64_t hi, std::int64_t k0,
                                               std::int64_t k1) {
    const std::int64_t first = (lo - k1 + 1) >> 1;
    const std::int64_t last = (hi - k0) >> 1;
    return {first, last - first + 1};
}

/// First and number of coarse x with [2x + k0, 2x + k0 + size - 1] inside [lo, hi].
std::pair<std::int64_t, std::int64_t> fully_inside(std::int64_t lo, std::int64_t hi,
                                                   std::int64_t k0, std::int64_t size) {
    const std::int64_t first = (lo - k0 + 1) >> 1;
    const std::int64_t last = (hi - k0 - size + 1) >> 1;
    return {first, std::max<std::int64_t>(0, last - first + 1)};
}

/// The spec of a layout is valid, so its bank exists.
FilterBank bank_of(const PyramidLayout& layout) {
    const SchemeSpec& spec = layout.spec;
    return *filter_bank(spec.order, spec.family, spec.dual_order);
}

std::size_t band_index(const PyramidLayout& layout, int level, int channel) {
    return static_cast<std::size_t>((layout.levels() - level) * 7 + channel);
}

/// Boxes of the scaling coefficients of levels 0 .. levels.
std::vector<LatticeBox> scaling_boxes(const FilterBank& bank, std::int64_t rows, std::int64_t cols,
                                      int levels) {
    std::vector<LatticeBox> boxes = {{0, 0, rows, cols}};
    for (int l = 1; l <= levels; ++l) boxes.push_back(channel_boxes(bank, boxes.back())[0]);
    return boxes;
}

template <class T>
void copy(GridView<const T> from, GridView<T> to) {
    for (std::int64_t r = 0; r < from.rows; ++r) std::copy_n(from.row(r), from.cols, to.row(r));
}

/// Runs step(level, fine, scaling channel) from level `first` + 1 up; the coarsest scaling channel
/// is the band.
template <class T, class Step>
void fine_to_coarse(GridView<const T> fine, const std::vector<LatticeBox>& boxes, int component,
                    Pyramid<T>& out, Workspace<T>& workspace, Step step, int first = 0) {
    const int levels = out.layout.levels();
    const GridView<T> coarsest = out.bands[0][static_cast<std::size_t>(component)].view();
    if (levels == first) return copy(fine, coarsest);
    for (int l = first + 1; l <= levels; ++l) {
        const LatticeBox& box = boxes[static_cast<std::size_t>(l)];
        const Channel<T> scaling{box,
                                 l < levels ? workspace.grid(l % 2, box.rows, box.cols) : coarsest};
        step(l, fine, scaling);
        fine = scaling.view;
    }
}

template <class T>
void analyse_by(const Sequence& low, const Sequence& high, double scale, const RowSource<T>& rows,
                const PyramidLayout& layout, int level, int component, Pyramid<T>& out,
                const Channel<T>& scaling) {
    std::array<Channel<T>, 8> channels;
    channels[0] = scaling;
    for (int c = 1; c < 8; ++c) {
        const std::size_t k = band_index(layout, level, c);
        channels[static_cast<std::size_t>(c)] = {
            layout.bands[k].box, out.bands[k][static_cast<std::size_t>(component)].view()};
    }
    analyse_level(low, high, scale, rows, channels);
}

/// The extension of `fine` by everything that the exact semi-orthogonal filters see, divided by
/// D(z^2).
template <class T>
Grid<T> divided(const FilterBank& bank, GridView<const T> fine, const LatticeBox& box,
                LatticeBox& padded) {
    const int reach =
        std::max({bank.a.last(), bank.b.last(), -bank.a.first, -bank.b.first, bank.q.last()});
    const std::int64_t margin = 2 * bank.margin + 4 * reach;
    padded = {box.row0 - margin, box.col0 - margin, box.rows + 2 * margin, box.cols + 2 * margin};
    Grid<T> grid(padded.rows, padded.cols);
    const ExtendedRows<T> extension(fine, box);
    parallel_for(0, padded.rows, 64, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t r = first; r < last; ++r)
            extension.fill(padded.row0 + r, padded.col0, padded.cols, grid.row(r));
    });
    divide_by_symbol(bank.poles, bank.gain, grid.view());
    return grid;
}

/// Coverage of one channel from that of the finer scaling coefficients, whose box is `fine_box`;
/// the fine ones are fully covered inside `full`. Squares of the synthesis kernel are the weights.
Grid<float> channel_coverage(const HexKernel& kernel, const LatticeBox& box,
                             const Grid<float>& fine, const LatticeBox& fine_box,
                             const LatticeBox& full) {
    double total = 0;
    for (const double tap : kernel.taps) total += tap * tap;
    const auto part = [&](std::int64_t row, std::int64_t col) {
        double sum = 0;
        std::size_t k = 0;
        for (std::int64_t i = kernel.box.row0; i < kernel.box.row0 + kernel.box.rows; ++i)
            for (std::int64_t j = kernel.box.col0; j < kernel.box.col0 + kernel.box.cols; ++j, ++k)
                if (fine_box.contains(2 * row + i, 2 * col + j))
                    sum += kernel.taps[k] * kernel.taps[k] *
                           static_cast<double>(
                               fine(2 * row + i - fine_box.row0, 2 * col + j - fine_box.col0));
        return static_cast<float>(sum / total);
    };
    const auto inside = [&](std::int64_t row, std::int64_t col) {
        return full.contains(2 * row + kernel.box.row0, 2 * col + kernel.box.col0) &&
               full.contains(2 * row + kernel.box.row0 + kernel.box.rows - 1,
                             2 * col + kernel.box.col0 + kernel.box.cols - 1);
    };
    Grid<float> grid(box.rows, box.cols);
    for (std::int64_t r = 0; r < box.rows; ++r)
        for (std::int64_t c = 0; c < box.cols; ++c)
            grid(r, c) =
                inside(box.row0 + r, box.col0 + c) ? 1.0F : part(box.row0 + r, box.col0 + c);
    return grid;
}

}  // namespace

std::array<LatticeBox, 8> channel_boxes(const FilterBank& bank, const LatticeBox& fine) {
    std::array<LatticeBox, 8> boxes;
    for (int c = 0; c < 8; ++c) {
        const LatticeBox kernel = synthesis_kernel(bank, c).box;
        const auto rows = reaching(fine.row0, fine.row0 + fine.rows - 1, kernel.row0,
                                   kernel.row0 + kernel.rows - 1);
        const auto cols = reaching(fine.col0, fine.col0 + fine.cols - 1, kernel.col0,
                                   kernel.col0 + kernel.cols - 1);
        boxes[static_cast<std::size_t>(c)] = {rows.first, cols.first, rows.second, cols.second};
    }
    return boxes;
}

Result<PyramidLayout> layout(const SchemeSpec& spec, std::int64_t rows, std::int64_t cols,
                             int components) {
    RELIEF_TRY(const FilterBank bank, filter_bank(spec.order, spec.family, spec.dual_order));
    if (spec.levels > kMostLevels)
        return Error{ErrorCode::InvalidArgument,
                     std::to_string(spec.levels) + " levels are too many; the most is " +
                         std::to_string(kMostLevels),
                     ""};
    PyramidLayout result;
    result.spec = spec;
    result.spec.dual_order = spec.family != Family::Compact ? 0
                             : spec.dual_order == 0         ? spec.order
                                                            : spec.dual_order;
    result.rows = rows;
    result.cols = cols;
    result.components = components;

    std::vector<std::array<LatticeBox, 8>> levels;
    LatticeBox fine{0, 0, rows, cols};
    while (static_cast<int>(levels.size()) < (spec.levels < 0 ? kMostLevels : spec.levels)) {
        const auto boxes = channel_boxes(bank, fine);
        const double reduction =
            static_cast<double>(fine.count()) / static_cast<double>(boxes[0].count());
        if (spec.levels < 0 && (reduction <= 1 || (!levels.empty() && reduction < kLeastReduction)))
            break;
        levels.push_back(boxes);
        fine = boxes[0];
    }
    const int count = static_cast<int>(levels.size());
    result.spec.levels = count;
    result.bands.push_back({channel_name(0), count, 0, fine});
    for (int l = count; l >= 1; --l)
        for (int c = 1; c < 8; ++c)
            result.bands.push_back(
                {channel_name(c), l, c,
                 levels[static_cast<std::size_t>(l - 1)][static_cast<std::size_t>(c)]});
    return result;
}

LatticeBox level_box(const PyramidLayout& layout, int level) {
    return scaling_boxes(bank_of(layout), layout.rows, layout.cols, level).back();
}

std::vector<Grid<float>> coverage(const PyramidLayout& layout) {
    const FilterBank bank = bank_of(layout);
    const auto boxes = scaling_boxes(bank, layout.rows, layout.cols, layout.levels());
    std::vector<Grid<float>> result(layout.bands.size());
    Grid<float> fine(layout.rows, layout.cols, 1.0F);
    LatticeBox full = boxes[0];
    for (int l = 1; l <= layout.levels(); ++l) {
        const LatticeBox& fine_box = boxes[static_cast<std::size_t>(l - 1)];
        for (int c = 1; c < 8; ++c) {
            const std::size_t k = band_index(layout, l, c);
            result[k] = channel_coverage(synthesis_kernel(bank, c), layout.bands[k].box, fine,
                                         fine_box, full);
        }
        const HexKernel scaling = synthesis_kernel(bank, 0);
        fine = channel_coverage(scaling, boxes[static_cast<std::size_t>(l)], fine, fine_box, full);
        const auto rows =
            fully_inside(full.row0, full.row0 + full.rows - 1, scaling.box.row0, scaling.box.rows);
        const auto cols =
            fully_inside(full.col0, full.col0 + full.cols - 1, scaling.box.col0, scaling.box.cols);
        full = {rows.first, cols.first, rows.second, cols.second};
    }
    result[0] = std::move(fine);
    return result;
}

template <class T>
void analyse(GridView<const T> scaling, int component, Pyramid<T>& out, Workspace<T>& workspace,
             int first_level) {
    const PyramidLayout& layout = out.layout;
    const FilterBank bank = bank_of(layout);
    const auto boxes = scaling_boxes(bank, layout.rows, layout.cols, layout.levels());
    const auto step = [&](int level, GridView<const T> fine, const Channel<T>& coarse) {
        const LatticeBox& box = boxes[static_cast<std::size_t>(level - 1)];
        if (bank.poles.empty())
            return analyse_by(bank.a, bank.b, 1, ExtendedRows<T>(fine, box), layout, level,
                              component, out, coarse);
        LatticeBox padded;
        const Grid<T> divided_grid = divided(bank, fine, box, padded);
        analyse_by(bank.a, bank.b, 1, ZeroRows<T>(divided_grid.view(), padded), layout, level,
                   component, out, coarse);
    };
    fine_to_coarse(scaling, boxes, component, out, workspace, step, first_level);
}

template <class T>
void analyse(GridView<const T> scaling, int component, Pyramid<T>& out, int first_level) {
    Workspace<T> workspace;
    analyse(scaling, component, out, workspace, first_level);
}

template <class T>
void coefficients(const Pyramid<T>& pyramid, int component, int level, GridView<T> out,
                  Workspace<T>& workspace) {
    const PyramidLayout& layout = pyramid.layout;
    const FilterBank bank = bank_of(layout);
    const auto boxes = scaling_boxes(bank, layout.rows, layout.cols, layout.levels());
    const auto plane = static_cast<std::size_t>(component);
    GridView<const T> coarse = pyramid.bands[0][plane].view();
    if (level == layout.levels()) return copy(coarse, out);
    for (int l = layout.levels(); l > level; --l) {
        std::array<Channel<const T>, 8> channels;
        channels[0] = {boxes[static_cast<std::size_t>(l)], coarse};
        for (int c = 1; c < 8; ++c) {
            const std::size_t k = band_index(layout, l, c);
            channels[static_cast<std::size_t>(c)] = {layout.bands[k].box,
                                                     pyramid.bands[k][plane].view()};
        }
        const LatticeBox& box = boxes[static_cast<std::size_t>(l - 1)];
        const GridView<T> fine = l == level + 1 ? out : workspace.grid(l % 2, box.rows, box.cols);
        synthesise_level(bank.p, bank.q, 0.5, channels, box, fine);
        coarse = fine;
    }
}

template <class T>
Grid<T> coefficients(const Pyramid<T>& pyramid, int component, int level) {
    const LatticeBox box = level_box(pyramid.layout, level);
    Grid<T> out(box.rows, box.cols);
    Workspace<T> workspace;
    coefficients(pyramid, component, level, out.view(), workspace);
    return out;
}

template <class T>
void adjoint(GridView<const T> residual, int component, Pyramid<T>& out) {
    const PyramidLayout& layout = out.layout;
    const FilterBank bank = bank_of(layout);
    const auto boxes = scaling_boxes(bank, layout.rows, layout.cols, layout.levels());
    const auto step = [&](int level, GridView<const T> fine, const Channel<T>& coarse) {
        const ZeroRows<T> rows(fine, boxes[static_cast<std::size_t>(level - 1)]);
        analyse_by(bank.p, bank.q, 0.5, rows, layout, level, component, out, coarse);
    };
    Workspace<T> workspace;
    fine_to_coarse(residual, boxes, component, out, workspace, step);
}

#define RELIEF_INSTANTIATE(T)                                                            \
    template void analyse(GridView<const T>, int, Pyramid<T>&, int);                     \
    template void analyse(GridView<const T>, int, Pyramid<T>&, Workspace<T>&, int);      \
    template Grid<T> coefficients(const Pyramid<T>&, int, int);                          \
    template void coefficients(const Pyramid<T>&, int, int, GridView<T>, Workspace<T>&); \
    template void adjoint(GridView<const T>, int, Pyramid<T>&);
RELIEF_INSTANTIATE(float)
RELIEF_INSTANTIATE(double)
#undef RELIEF_INSTANTIATE

}  // namespace relief::multires::barycentric
