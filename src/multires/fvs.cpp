#include "relief/multires/fvs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "relief/multires/fvs_grid_transform.h"
#include "relief/spline/fvs_cell.h"
#include "relief/spline/fvs_surface.h"

namespace relief::multires::fvs {

namespace {

constexpr int kDerivativePlanes = spline::kFvsPlanes - 1;
constexpr int kFirstDetail = 1 + kDerivativePlanes;
constexpr int kMostUsefulLevels = 8;
constexpr const char* kDerivativeNames[kDerivativePlanes] = {"fx", "fy", "gh", "gv"};

/// Cells of a level.
struct Cells {
    std::int64_t x = 0;
    std::int64_t y = 0;
};

Cells cells_at(const PyramidLayout& layout, int level) {
    Cells cells = {layout.cols - 1, layout.rows - 1};
    for (int l = 0; l < level; ++l) cells = {coarser(cells.x), coarser(cells.y)};
    return cells;
}

/// How often n cells can be halved until one is left.
int halvings(std::int64_t n) {
    int count = 0;
    for (; n > 1; n = coarser(n)) ++count;
    return count;
}

int default_levels(std::int64_t rows, std::int64_t cols) {
    std::int64_t shorter = std::min(rows, cols) - 1;
    if (shorter == 0) shorter = std::max(rows, cols) - 1;
    int levels = 0;
    while (levels < kMostUsefulLevels && (std::int64_t{2} << levels) <= shorter) ++levels;
    return levels;
}

template <class T>
FvsGrid<T> grid_at(const PyramidLayout& layout, int level) {
    const Cells cells = cells_at(layout, level);
    const double size = std::ldexp(1.0, level);
    return FvsGrid<T>(cells.x, cells.y, size, size);
}

/// The first band of the details of a level, from which kinds follow in order.
std::size_t details_band(const PyramidLayout& layout, int level) {
    return static_cast<std::size_t>(kFirstDetail + kDetailKinds * (layout.levels() - level));
}

template <class T>
DetailViews<T> details_of(Pyramid<T>& pyramid, int component, int level) {
    const std::size_t first = details_band(pyramid.layout, level);
    DetailViews<T> views;
    for (std::size_t k = 0; k < kDetailKinds; ++k)
        views[k] = pyramid.bands[first + k][static_cast<std::size_t>(component)].view();
    return views;
}

template <class T>
void copy(GridView<const T> from, GridView<T> to) {
    for (std::int64_t r = 0; r < from.rows; ++r) std::copy_n(from.row(r), from.cols, to.row(r));
}

/// The coarsest data, of which a pyramid without levels has only the values.
template <class T>
void store_coarsest(const FvsGrid<T>& grid, int component, Pyramid<T>& out) {
    const int planes = out.layout.levels() == 0 ? 1 : spline::kFvsPlanes;
    for (int p = 0; p < planes; ++p)
        copy<T>(grid[p].view(),
                out.bands[static_cast<std::size_t>(p)][static_cast<std::size_t>(component)].view());
}

template <class T>
FvsGrid<T> estimate(GridView<const T> values, int level) {
    const double size = std::ldexp(1.0, level);
    auto grid = spline::estimate_fvs_grid(spline::RasterPart<T>::whole(values),
                                          {0, 0, values.rows, values.cols}, size, size);
    return *std::move(grid);  // a window that is the whole raster is always right
}

/// From fine to coarse with step(fine, coarse, details of the level).
template <class T, class Step>
void to_coarsest(FvsGrid<T> fine, int first_level, int component, Pyramid<T>& out, Step step) {
    for (int level = first_level + 1; level <= out.layout.levels(); ++level) {
        FvsGrid<T> coarse = grid_at<T>(out.layout, level);
        step(std::as_const(fine).view(), coarse.view(), details_of(out, component, level));
        fine = std::move(coarse);
    }
    store_coarsest(fine, component, out);
}

Status check(const SchemeSpec& spec, std::int64_t rows, std::int64_t cols, int components) {
    constexpr std::int64_t longest = std::numeric_limits<std::int32_t>::max();
    if (spec.order != 2)
        return Error{ErrorCode::InvalidArgument,
                     "scheme fvs has one order, written 2, not " + std::to_string(spec.order),
                     "order"};
    if (spec.data_map != DataMap::Interpolate)
        return Error{ErrorCode::InvalidArgument,
                     "surfaces of scheme fvs pass through the samples; the data map must be "
                     "interpolate",
                     "data map"};
    if (components < 1 || components > 4)
        return Error{ErrorCode::InvalidArgument,
                     std::to_string(components) + " components; give 1 to 4", "components"};
    if (rows < 1 || cols < 1 || rows > longest || cols > longest)
        return Error{ErrorCode::BadInput,
                     "a raster of " + std::to_string(rows) + " x " + std::to_string(cols) +
                         " samples; each side must have 1 to " + std::to_string(longest),
                     "raster"};
    const int most = halvings(std::max(rows, cols) - 1);
    if (spec.levels >= -1 && spec.levels <= most) return {};
    return Error{ErrorCode::InvalidArgument,
                 std::to_string(spec.levels) + " levels; a raster of " + std::to_string(rows) +
                     " x " + std::to_string(cols) + " has at most " + std::to_string(most) +
                     " (-1: as many as are useful)",
                 "levels"};
}

/// What is measured of the atoms of one level, by channel.
struct Norms {
    double samples = 1;
    double max = 1;
};
using LevelNorms = std::array<Norms, kFirstDetail + kDetailKinds>;

/// Levels whose sample norms are measured. A level doubles lengths: norms of surfaces double where
/// the coefficient is a value, quadruple where it is a derivative. Sums over samples come close to
/// integrals; maxima of value atoms stay, those of derivative atoms double.
constexpr int kMeasuredLevels = 3;

/// The integral of the square of a surface with cells of size 1.
double squared_norm(const FvsGrid<double>& grid) {
    const auto& mass = spline::fvs_cell_mass();
    double sum = 0;
    for (std::int64_t r = 0; r < grid.ny(); ++r)
        for (std::int64_t c = 0; c < grid.nx(); ++c) {
            double number[spline::kFvsCellNumbers];
            for (std::size_t k = 0; k < spline::kFvsCellNumbers; ++k) {
                const auto& at = spline::kFvsCell[k];
                number[k] = grid[at.plane](r + at.row, c + at.col);
            }
            for (std::size_t m = 0; m < spline::kFvsCellNumbers; ++m)
                for (std::size_t n = 0; n < spline::kFvsCellNumbers; ++n)
                    sum += number[m] * mass[m][n] * number[n];
        }
    return sum;
}

Norms norms_of(const Grid<double>& atom) {
    Norms norms{0, 0};
    for (std::int64_t r = 0; r < atom.rows(); ++r)
        for (std::int64_t c = 0; c < atom.cols(); ++c) {
            norms.samples += atom(r, c) * atom(r, c);
            norms.max = std::max(norms.max, std::abs(atom(r, c)));
        }
    norms.samples = std::sqrt(norms.samples);
    return norms;
}

std::vector<BandLayout> bands_of(const PyramidLayout& layout) {
    std::vector<BandLayout> bands;
    const int levels = layout.levels();
    const Cells top = cells_at(layout, levels);
    bands.push_back({"scaling", levels, 0, {0, 0, top.y + 1, top.x + 1}});
    for (int p = 1; levels > 0 && p < spline::kFvsPlanes; ++p)
        bands.push_back(
            {kDerivativeNames[p - 1],
             levels,
             p,
             {0, 0, top.y + (p == spline::kFvsGv ? 0 : 1), top.x + (p == spline::kFvsGh ? 0 : 1)}});
    for (int level = levels; level >= 1; --level) {
        const Cells fine = cells_at(layout, level - 1);
        for (int kind = 0; kind < kDetailKinds; ++kind)
            bands.push_back({std::string(detail_name(kind)), level, kFirstDetail + kind,
                             detail_box(kind, fine.x, fine.y)});
    }
    return bands;
}

/// Calls use(channel, atom) for the atoms of `level`: nodal data of the finest level by synthesis
/// of impulses in the middle of a raster that holds them.
template <class Use>
void for_atoms(int level, Use use) {
    PyramidLayout layout;
    layout.spec.id = SchemeId::Fvs;
    layout.spec.levels = level;
    layout.rows = layout.cols = (std::int64_t{10} << level) + 1;
    layout.bands = bands_of(layout);
    auto pyramid = Pyramid<double>::allocate(layout);
    for (auto& band : pyramid.bands) band[0] = Grid<double>(band[0].rows(), band[0].cols(), 0.0);
    for (std::size_t k = 0; k < kFirstDetail + kDetailKinds; ++k) {  // those of the coarsest level
        double& middle = pyramid.bands[k][0](5, 5);
        middle = 1;
        use(static_cast<std::size_t>(layout.bands[k].channel), nodal_data(pyramid, 0, 0));
        middle = 0;
    }
}

struct NormTable {
    std::array<LevelNorms, kMeasuredLevels> levels;
    std::array<double, kFirstDetail + kDetailKinds> surfaces{};  ///< of level 1
};

const NormTable& norm_table() {
    static const NormTable table = [] {
        NormTable norms;
        for (int level = 1; level <= kMeasuredLevels; ++level)
            for_atoms(level, [&](std::size_t channel, const FvsGrid<double>& atom) {
                norms.levels[static_cast<std::size_t>(level - 1)][channel] =
                    norms_of(atom[spline::kFvsF]);
                if (level == 1) norms.surfaces[channel] = std::sqrt(squared_norm(atom));
            });
        return norms;
    }();
    return table;
}

bool is_derivative(const BandLayout& band) {
    const int plane =
        band.channel < kFirstDetail ? band.channel : detail_plane(band.channel - kFirstDetail);
    return plane != spline::kFvsF;
}

void fill_norms(std::vector<BandLayout>& bands) {
    const NormTable& table = norm_table();
    for (BandLayout& band : bands) {
        if (band.level == 0) continue;
        const auto channel = static_cast<std::size_t>(band.channel);
        const int powers = is_derivative(band) ? 2 : 1;
        band.norm_surface = table.surfaces[channel] * std::ldexp(1.0, powers * (band.level - 1));
        const int measured = std::min(band.level, kMeasuredLevels);
        const Norms& norms = table.levels[static_cast<std::size_t>(measured - 1)][channel];
        band.norm_samples = band.level == measured ? norms.samples : band.norm_surface;
        band.norm_max = norms.max * std::ldexp(1.0, (powers - 1) * (band.level - measured));
    }
}

}  // namespace

Result<PyramidLayout> layout(const SchemeSpec& spec, std::int64_t rows, std::int64_t cols,
                             int components) {
    RELIEF_CHECK(check(spec, rows, cols, components));
    PyramidLayout out;
    out.spec = spec;
    out.spec.family = Family::Compact;
    out.spec.dual_order = 0;
    if (spec.levels < 0) out.spec.levels = default_levels(rows, cols);
    out.rows = rows;
    out.cols = cols;
    out.components = components;
    out.bands = bands_of(out);
    fill_norms(out.bands);
    return out;
}

template <class T>
void analyse(GridView<const T> values, int component, Pyramid<T>& out, int first_level) {
    to_coarsest(
        estimate(values, first_level), first_level, component, out,
        [](const FvsGridView<const T>& fine, const FvsGridView<T>& coarse,
           const DetailViews<T>& details) { decompose(fine, Lifting::L2, coarse, details); });
}

template <class T>
FvsGrid<T> nodal_data(const Pyramid<T>& pyramid, int component, int level) {
    const PyramidLayout& layout = pyramid.layout;
    const auto band = [&](std::size_t k) -> const Grid<T>& {
        return pyramid.bands[k][static_cast<std::size_t>(component)];
    };
    if (layout.levels() == 0) return estimate<T>(band(0).view(), 0);
    FvsGrid<T> grid = grid_at<T>(layout, layout.levels());
    for (std::size_t p = 0; p < spline::kFvsPlanes; ++p)
        copy<T>(band(p).view(), grid.planes[p].view());
    for (int l = layout.levels(); l > level; --l) {
        FvsGrid<T> fine = grid_at<T>(layout, l - 1);
        Details<T> details(fine.nx(), fine.ny());
        for (std::size_t k = 0; k < kDetailKinds; ++k)
            copy<T>(band(details_band(layout, l) + k).view(), details.planes[k].view());
        reconstruct(grid.view(), details.view(), Lifting::L2, fine.view());
        grid = std::move(fine);
    }
    return grid;
}

template <class T>
Grid<T> coefficients(const Pyramid<T>& pyramid, int component, int level) {
    if (level == pyramid.layout.levels())
        return pyramid.bands[0][static_cast<std::size_t>(component)].clone();
    return std::move(nodal_data(pyramid, component, level)[spline::kFvsF]);
}

template <class T>
Grid<T> subdivide(const PyramidLayout& layout, GridView<const T> values, int from, int to) {
    FvsGrid<T> grid = estimate(values, from);
    for (int level = from; level > to; --level) {
        FvsGrid<T> fine = grid_at<T>(layout, level - 1);
        predict(std::as_const(grid).view(), fine.view());
        grid = std::move(fine);
    }
    return std::move(grid[spline::kFvsF]);
}

template <class T>
void adjoint(GridView<const T> finest_residual, int component, Pyramid<T>& out) {
    FvsGrid<T> residual = grid_at<T>(out.layout, 0);
    for (auto& plane : residual.planes) plane = Grid<T>(plane.rows(), plane.cols(), T(0));
    copy(finest_residual, residual[spline::kFvsF].view());
    to_coarsest(
        std::move(residual), 0, component, out,
        [](const FvsGridView<const T>& fine, const FvsGridView<T>& coarse,
           const DetailViews<T>& details) { transpose(fine, Lifting::L2, coarse, details); });
}

bool follows_values_of(const PyramidLayout& layout, const BandLayout& band, int level) {
    return band.level > level || (level == layout.levels() && band.channel < kFirstDetail);
}

LatticeRange cardinal_support(std::int64_t k, std::int64_t n) {
    // Derivatives reach two points; one-sided ones, of the first and last two, reach four.
    return {k <= 4 ? 0 : k - 3, k >= n - 5 ? n - 1 : k + 3};
}

Result<CardinalFunction> cardinal_function(std::int64_t rows, std::int64_t cols, int level,
                                           std::int64_t row, std::int64_t col) {
    PyramidLayout layout;
    layout.rows = rows;
    layout.cols = cols;
    if (rows < 2 || cols < 2 || level < 0 || level > halvings(std::max(rows, cols) - 1))
        return Error{ErrorCode::InvalidArgument,
                     "a raster of " + std::to_string(rows) + " x " + std::to_string(cols) +
                         " has no lattice of level " + std::to_string(level),
                     "level"};
    const Cells cells = cells_at(layout, level);
    if (row < 0 || row > cells.y || col < 0 || col > cells.x)
        return Error{ErrorCode::InvalidArgument,
                     "there is no value (" + std::to_string(row) + ", " + std::to_string(col) +
                         ") at level " + std::to_string(level) + "; rows are 0 to " +
                         std::to_string(cells.y) + ", columns 0 to " + std::to_string(cells.x),
                     "value"};
    const auto [top, bottom] = cardinal_support(row, cells.y + 1);
    const auto [left, right] = cardinal_support(col, cells.x + 1);
    const std::int64_t scale = std::int64_t{1} << level;
    const LatticeBox box = {top * scale, left * scale,
                            std::min(bottom * scale, rows - 1) - top * scale + 1,
                            std::min(right * scale, cols - 1) - left * scale + 1};
    const double step = std::ldexp(1.0, -level);
    const LatticeBox reach = spline::resampling_box(double(top), step, box.rows, double(left), step,
                                                    box.cols, cells.y + 1, cells.x + 1);
    Grid<double> impulse(reach.rows, reach.cols, 0.0);
    impulse(row - reach.row0, col - reach.col0) = 1;
    CardinalFunction function{box, Grid<double>(box.rows, box.cols)};
    const spline::RasterPart<double> part{std::as_const(impulse).view(), reach.row0, reach.col0,
                                          cells.y + 1, cells.x + 1};
    RELIEF_CHECK(spline::FvsSurface<double>::resample(part, double(top), step, double(left), step,
                                                      function.values.view()));
    return function;
}

#define RELIEF_INSTANTIATE(T)                                                      \
    template void analyse(GridView<const T>, int, Pyramid<T>&, int);               \
    template FvsGrid<T> nodal_data(const Pyramid<T>&, int, int);                   \
    template Grid<T> coefficients(const Pyramid<T>&, int, int);                    \
    template Grid<T> subdivide(const PyramidLayout&, GridView<const T>, int, int); \
    template void adjoint(GridView<const T>, int, Pyramid<T>&);
RELIEF_INSTANTIATE(float)
RELIEF_INSTANTIATE(double)
#undef RELIEF_INSTANTIATE

}  // namespace relief::multires::fvs
