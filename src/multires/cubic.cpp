#include "relief/multires/cubic.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "multires/cubic_exact.h"
#include "multires/cubic_lattice.h"
#include "multires/cubic_level.h"

namespace relief::multires::cubic {

namespace {

constexpr int kMostDefaultLevels = 7;
constexpr std::int64_t kShortestSide = 4;

/// Norms of the one-dimensional atoms of a level: a band's atom is the product of two of them, and
/// so is its norm. Measured on one impulse far from borders; each further level grows by sqrt(2).
struct LineNorms {
    double samples[2];  ///< of scaling function and wavelet
    double surface[2];
};
constexpr std::array<LineNorms, 4> kLineNorms = {
    {{{1.325348872, 0.776234332}, {1.322453039, 0.689119807}},
     {{1.870675865, 0.978643709}, {1.870487013, 0.974665615}},
     {{2.645706835, 1.378784006}, {2.645691616, 1.378524617}},
     {{3.741913434, 1.950009152}, {3.741912111, 1.949988262}}}};
constexpr double kLineMax[2] = {1, 0.621725184};

void set_norms(BandLayout& band) {
    const int measured = std::min<int>(band.level, kLineNorms.size());
    if (measured == 0) return;
    const LineNorms& line = kLineNorms[static_cast<std::size_t>(measured - 1)];
    const double growth = std::ldexp(1.0, band.level - measured);
    const int col = band.channel % 2;
    const int row = band.channel / 2;
    band.norm_samples = line.samples[row] * line.samples[col] * growth;
    band.norm_surface = line.surface[row] * line.surface[col] * growth;
    band.norm_max = kLineMax[row] * kLineMax[col];
}

int default_levels(std::int64_t rows, std::int64_t cols) {
    const std::int64_t shorter = std::min(rows, cols);
    const std::int64_t side = shorter == 1 ? std::max(rows, cols) : shorter;
    int levels = 0;
    while (levels < kMostDefaultLevels && side >> (levels + 1) >= kShortestSide) ++levels;
    return levels;
}

int most_levels(std::int64_t rows, std::int64_t cols) {
    int levels = 0;
    for (std::int64_t n = std::max(rows, cols); n > 1; n = (n + 1) / 2) ++levels;
    return levels;
}

Status check(const SchemeSpec& spec, std::int64_t rows, std::int64_t cols, int components) {
    constexpr std::int64_t longest = std::numeric_limits<std::int32_t>::max();
    if (spec.order != 2)
        return Error{ErrorCode::InvalidArgument,
                     "scheme cubic has order 2 (C2) only, not " + std::to_string(spec.order),
                     "order"};
    if (spec.data_map != DataMap::Interpolate)
        return Error{ErrorCode::InvalidArgument,
                     "the surfaces of scheme cubic pass through their samples; use the data map "
                     "interpolate",
                     "map"};
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
                         " (-1: as many as are useful)",
                     "levels"};
    return {};
}

template <class T>
void copy(GridView<const T> from, GridView<T> to) {
    for (std::int64_t r = 0; r < from.rows; ++r) std::copy_n(from.row(r), from.cols, to.row(r));
}

/// The bands that one level makes, whole: `scaling`, and the details of `level`.
template <class T>
Bands<T> bands_of(Pyramid<T>& pyramid, int component, int level, GridView<T> scaling) {
    Bands<T> bands;
    bands[0] = {scaling, 0, 0};
    for (int k = 1; k < 4; ++k)
        bands[std::size_t(k)] = {
            pyramid.bands[band_of(pyramid.layout, level, k)][std::size_t(component)].view(), 0, 0};
    return bands;
}

template <class T>
Bands<const T> bands_of(const Pyramid<T>& pyramid, int component, int level,
                        GridView<const T> scaling) {
    Bands<const T> bands;
    bands[0] = {scaling, 0, 0};
    for (int k = 1; k < 4; ++k)
        bands[std::size_t(k)] = {
            pyramid.bands[band_of(pyramid.layout, level, k)][std::size_t(component)].view(), 0, 0};
    return bands;
}

template <class T>
void split(const SchemeSpec& spec, const Lifting& lifting, GridView<const T> fine,
           const Bands<T>& bands) {
    if (spec.exact) return split_level_exactly<T>(lifting, fine, bands);
    split_level<T>(lifting, whole({fine.rows, fine.cols}), {fine, 0, 0}, bands);
}

/// Calls step(level, fine, coarse) from the level above `first` up; the coarsest result is the
/// scaling band.
template <class T, class Step>
void fine_to_coarse(GridView<const T> finest, int component, Pyramid<T>& out,
                    Workspace<T>& workspace, int first, Step step) {
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

/// Calls fn(row, col) for the samples at the ends of both axes, for those at corners twice: all
/// that the period of the mirrored raster has once where it has others twice.
template <class Function>
void for_ends(const Lattice& lattice, Function fn) {
    for (const std::int64_t r : {std::int64_t{0}, lattice.rows - 1})
        for (std::int64_t c = 0; lattice.rows > 1 && c < lattice.cols; ++c) fn(r, c);
    for (const std::int64_t c : {std::int64_t{0}, lattice.cols - 1})
        for (std::int64_t r = 0; lattice.cols > 1 && r < lattice.rows; ++r) fn(r, c);
}

}  // namespace

Result<PyramidLayout> layout(const SchemeSpec& spec, std::int64_t rows, std::int64_t cols,
                             int components) {
    RELIEF_CHECK(check(spec, rows, cols, components));
    PyramidLayout out;
    out.spec = spec;
    out.spec.levels = spec.levels < 0 ? default_levels(rows, cols) : spec.levels;
    out.spec.dual_order = 0;
    out.rows = rows;
    out.cols = cols;
    out.components = components;
    const Lattice top = lattice_at(out, out.levels());
    out.bands.push_back({"scaling", out.levels(), 0, {0, 0, top.rows, top.cols}});
    for (int level = out.levels(); level >= 1; --level) {
        const auto [fine_rows, fine_cols] = lattice_at(out, level - 1);
        const Lattice even{(fine_rows + 1) / 2, (fine_cols + 1) / 2};
        const Lattice odd{fine_rows / 2, fine_cols / 2};
        out.bands.push_back({"odd-x", level, 1, {0, 0, even.rows, odd.cols}});
        out.bands.push_back({"odd-y", level, 2, {0, 0, odd.rows, even.cols}});
        out.bands.push_back({"odd-xy", level, 3, {0, 0, odd.rows, odd.cols}});
    }
    for (BandLayout& band : out.bands) set_norms(band);
    return out;
}

template <class T>
void analyse(GridView<const T> finest, int component, Pyramid<T>& out, Workspace<T>& workspace,
             int first_level) {
    const auto step = [&](int level, GridView<const T> fine, GridView<T> coarse) {
        split(out.layout.spec, kAnalysis, fine, bands_of(out, component, level, coarse));
    };
    fine_to_coarse(finest, component, out, workspace, first_level, step);
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
    GridView<const T> coarse = pyramid.bands[0][std::size_t(component)].view();
    if (level == layout.levels()) return copy(coarse, out);
    for (int l = layout.levels(); l > level; --l) {
        const Lattice lattice = lattice_at(layout, l - 1);
        const bool last = l == level + 1;
        const GridView<T> fine = last ? out : workspace.grid(l % 2, lattice.rows, lattice.cols);
        const Bands<const T> bands = bands_of(pyramid, component, l, coarse);
        const Traffic traffic = last ? streamed_if_large<T>(fine.count()) : Traffic::Cached;
        if (layout.spec.exact)
            merge_level_exactly<T>(bands, fine);
        else
            merge_level<T>(whole(lattice), bands, traffic, {fine, 0, 0});
        coarse = fine;
    }
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
    // Over the period of the mirrored raster the transpose of a step is a step (kTransposed). Sums
    // over the raster itself have weight 1 at the ends where the period has half of the others':
    // double the ends first, halve them afterwards.
    Workspace<T> workspace;
    Grid<T> doubled;
    const auto step = [&](int level, GridView<const T> fine, GridView<T> coarse) {
        const Lattice lattice{fine.rows, fine.cols};
        if (level == 1) doubled = Grid<T>(fine.rows, fine.cols);
        const GridView<T> weighted(doubled.row(0), fine.rows, fine.cols, doubled.stride());
        copy(fine, weighted);
        for_ends(lattice, [&](std::int64_t r, std::int64_t c) { weighted(r, c) *= 2; });
        const Bands<T> bands = bands_of(out, component, level, coarse);
        split<T>(out.layout.spec, kTransposed, weighted, bands);
        for_ends(lattice, [&](std::int64_t r, std::int64_t c) {
            *bands[std::size_t(2 * (r % 2) + c % 2)].at(r / 2, c / 2) *= T(0.5);
        });
    };
    fine_to_coarse(finest_residual, component, out, workspace, 0, step);
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

}  // namespace relief::multires::cubic
