#include "relief/multires/box.h"

#include <algorithm>
#include <limits>

#include "multires/box_adjoint.h"
#include "multires/box_curve.h"
#include "multires/box_factors.h"
#include "multires/box_level.h"
#include "multires/box_rules.h"

namespace relief::multires::box {

namespace {

Lattice lattice_at(const PyramidLayout& layout, int level) {
    Lattice lattice = {layout.rows, layout.cols};
    for (int l = 0; l < level; ++l) lattice = {coarser(lattice.rows), coarser(lattice.cols)};
    return lattice;
}

int most_levels(std::int64_t rows, std::int64_t cols) {
    int levels = 0;
    for (std::int64_t n = std::max(rows, cols); n > 2; n = coarser(n)) ++levels;
    return levels;
}

bool is_curve(const PyramidLayout& layout) {
    return layout.rows == 1 || layout.cols == 1;
}

std::size_t band_of(const PyramidLayout& layout, int level, int kind) {
    return std::size_t(1 + kEdgeKinds * (layout.levels() - level) + kind);
}

template <class T>
EdgePlanes<T> edges_of(Pyramid<T>& pyramid, int component, int level) {
    EdgePlanes<T> edges;
    for (int kind = 0; kind < kEdgeKinds; ++kind)
        edges[std::size_t(kind)] =
            pyramid.bands[band_of(pyramid.layout, level, kind)][std::size_t(component)].view();
    return edges;
}

template <class T>
EdgePlanes<const T> edges_of(const Pyramid<T>& pyramid, int component, int level) {
    EdgePlanes<const T> edges;
    for (int kind = 0; kind < kEdgeKinds; ++kind)
        edges[std::size_t(kind)] =
            pyramid.bands[band_of(pyramid.layout, level, kind)][std::size_t(component)].view();
    return edges;
}

template <class T>
void copy(GridView<const T> from, GridView<T> to) {
    for (std::int64_t i = 0; i < from.rows; ++i) std::copy_n(from.row(i), from.cols, to.row(i));
}

/// A grid of one row or one column as a line, whichever the raster is.
template <class T>
Line<T> line_of(const PyramidLayout& layout, GridView<T> grid) {
    if (layout.rows == 1) return {grid.data, grid.cols, 1};
    return {grid.data, grid.rows, grid.stride};
}

/// The edge plane that a curve uses.
std::size_t curve_kind(const PyramidLayout& layout) {
    return layout.rows == 1 ? 1 : 0;
}

/// Runs step(level, fine, coarse) from the level above `first` up; the coarsest result is the
/// scaling band.
template <class T, class Step>
void fine_to_coarse(GridView<const T> finest, int component, Pyramid<T>& out,
                    Workspace<T>& workspace, Step step, int first = 0) {
    const int levels = out.layout.levels();
    const GridView<T> scaling = out.bands[0][std::size_t(component)].view();
    if (levels == first) return copy(finest, scaling);
    for (int level = first + 1; level <= levels; ++level) {
        const Lattice lattice = lattice_at(out.layout, level);
        const GridView<T> coarse =
            level == levels ? scaling : workspace.grid(level % 2, lattice.rows, lattice.cols);
        step(level, finest, coarse);
        finest = coarse;
    }
}

/// Runs step(level, coarse, fine) from the coarsest level down to `target` + 1, into `out`.
template <class T, class Step>
void coarse_to_fine(const Pyramid<T>& pyramid, int component, int target, GridView<T> out,
                    Workspace<T>& workspace, Step step) {
    GridView<const T> coarse = pyramid.bands[0][std::size_t(component)].view();
    if (target == pyramid.layout.levels()) return copy(coarse, out);
    for (int level = pyramid.layout.levels(); level > target; --level) {
        const Lattice lattice = lattice_at(pyramid.layout, level - 1);
        const GridView<T> fine =
            level == target + 1 ? out : workspace.grid(level % 2, lattice.rows, lattice.cols);
        step(level, coarse, fine);
        coarse = fine;
    }
}

}  // namespace

Result<PyramidLayout> layout(const SchemeSpec& spec, std::int64_t rows, std::int64_t cols,
                             int components) {
    constexpr std::int64_t longest = std::numeric_limits<std::int32_t>::max();
    if (spec.order != 1 && spec.order != 2)
        return Error{
            ErrorCode::InvalidArgument,
            "scheme box has orders 1 (linear) and 2 (quartic), not " + std::to_string(spec.order),
            "order"};
    if (components < 1 || components > 4)
        return Error{ErrorCode::InvalidArgument,
                     std::to_string(components) + " components; give 1 to 4", "components"};
    if (rows < 1 || cols < 1 || rows > longest || cols > longest)
        return Error{ErrorCode::BadInput,
                     "a raster of " + std::to_string(rows) + " x " + std::to_string(cols) +
                         " samples; each side must have 1 to " + std::to_string(longest),
                     "raster"};
    const int most = most_levels(rows, cols);
    if (spec.levels < -1 || spec.levels > most)
        return Error{ErrorCode::InvalidArgument,
                     std::to_string(spec.levels) + " levels; a raster of " + std::to_string(rows) +
                         " x " + std::to_string(cols) + " has at most " + std::to_string(most) +
                         " (-1: all of them)",
                     "levels"};
    PyramidLayout out;
    out.spec = spec;
    out.spec.levels = spec.levels < 0 ? most : spec.levels;
    out.spec.dual_order = 0;
    out.rows = rows;
    out.cols = cols;
    out.components = components;
    const Lattice top = lattice_at(out, out.levels());
    out.bands.push_back({"scaling", out.levels(), 0, {0, 0, top.rows, top.cols}});
    for (int level = out.levels(); level >= 1; --level) {
        const Lattice lattice = lattice_at(out, level);
        for (int kind = 0; kind < kEdgeKinds; ++kind)
            out.bands.push_back({"edge" + std::to_string(kind + 1),
                                 level,
                                 kind + 1,
                                 {0, 0, lattice.edge_rows(kind), lattice.edge_cols(kind)}});
    }
    return out;
}

template <class T>
void analyse(GridView<const T> finest, int component, Pyramid<T>& out, Workspace<T>& workspace,
             int first_level) {
    const PyramidLayout& layout = out.layout;
    const int order = layout.spec.order;
    if (is_curve(layout)) {
        const auto factors =
            curve_factors(order, std::max(layout.rows, layout.cols), layout.levels());
        const auto step = [&](int level, GridView<const T> fine, GridView<T> coarse) {
            const GridView<T> edges = edges_of(out, component, level)[curve_kind(layout)];
            analyse_curve<T>(order, factors[std::size_t(level - 1)], line_of(layout, fine),
                             line_of(layout, coarse), line_of(layout, edges));
        };
        return fine_to_coarse(finest, component, out, workspace, step, first_level);
    }
    const auto factors = update_factors(order, layout.rows, layout.cols, layout.levels());
    const auto step = [&](int level, GridView<const T> fine, GridView<T> coarse) {
        analyse_level<T>(order, factors[std::size_t(level - 1)], fine, coarse,
                         edges_of(out, component, level));
    };
    fine_to_coarse(finest, component, out, workspace, step, first_level);
}

template <class T>
void analyse(GridView<const T> finest, int component, Pyramid<T>& out) {
    Workspace<T> workspace;
    analyse(finest, component, out, workspace);
}

template <class T>
void coefficients(const Pyramid<T>& pyramid, int component, int level, GridView<T> out,
                  Workspace<T>& workspace) {
    const PyramidLayout& layout = pyramid.layout;
    const int order = layout.spec.order;
    if (is_curve(layout)) {
        const auto factors =
            curve_factors(order, std::max(layout.rows, layout.cols), layout.levels());
        const auto step = [&](int l, GridView<const T> coarse, GridView<T> fine) {
            const GridView<const T> edges = edges_of(pyramid, component, l)[curve_kind(layout)];
            synthesise_curve<T>(order, factors[std::size_t(l - 1)], line_of(layout, coarse),
                                line_of(layout, edges), line_of(layout, fine));
        };
        return coarse_to_fine(pyramid, component, level, out, workspace, step);
    }
    const auto factors = update_factors(order, layout.rows, layout.cols, layout.levels());
    const auto step = [&](int l, GridView<const T> coarse, GridView<T> fine) {
        const Traffic traffic =
            l == level + 1 ? streamed_if_large<T>(fine.count()) : Traffic::Cached;
        synthesise_level<T>(order, factors[std::size_t(l - 1)], coarse,
                            edges_of(pyramid, component, l), traffic, fine);
    };
    coarse_to_fine(pyramid, component, level, out, workspace, step);
}

template <class T>
Grid<T> coefficients(const Pyramid<T>& pyramid, int component, int level) {
    const Lattice lattice = lattice_at(pyramid.layout, level);
    Grid<T> out(lattice.rows, lattice.cols);
    Workspace<T> workspace;
    coefficients(pyramid, component, level, out.view(), workspace);
    return out;
}

template <class T>
void adjoint(GridView<const T> finest_residual, int component, Pyramid<T>& out) {
    const PyramidLayout& layout = out.layout;
    const int order = layout.spec.order;
    Workspace<T> workspace;
    if (is_curve(layout)) {
        const auto factors =
            curve_factors(order, std::max(layout.rows, layout.cols), layout.levels());
        const auto step = [&](int level, GridView<const T> fine, GridView<T> coarse) {
            const GridView<T> edges = edges_of(out, component, level)[curve_kind(layout)];
            transpose_curve<T>(order, factors[std::size_t(level - 1)], line_of(layout, fine),
                               line_of(layout, coarse), line_of(layout, edges));
        };
        return fine_to_coarse(finest_residual, component, out, workspace, step);
    }
    const auto factors = update_factors(order, layout.rows, layout.cols, layout.levels());
    const auto step = [&](int level, GridView<const T> fine, GridView<T> coarse) {
        transpose_level<T>(order, factors[std::size_t(level - 1)], fine, coarse,
                           edges_of(out, component, level));
    };
    fine_to_coarse(finest_residual, component, out, workspace, step);
}

#define RELIEF_INSTANTIATE(T)                                                            \
    template void analyse(GridView<const T>, int, Pyramid<T>&);                          \
    template void analyse(GridView<const T>, int, Pyramid<T>&, Workspace<T>&, int);      \
    template Grid<T> coefficients(const Pyramid<T>&, int, int);                          \
    template void coefficients(const Pyramid<T>&, int, int, GridView<T>, Workspace<T>&); \
    template void adjoint(GridView<const T>, int, Pyramid<T>&);
RELIEF_INSTANTIATE(float)
RELIEF_INSTANTIATE(double)
#undef RELIEF_INSTANTIATE

}  // namespace relief::multires::box
