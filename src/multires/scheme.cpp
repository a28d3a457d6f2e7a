#include "relief/multires/scheme.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <tuple>

#include "relief/core/parallel.h"
#include "relief/multires/barycentric.h"
#include "relief/multires/box.h"
#include "relief/multires/cubic.h"
#include "relief/multires/fvs.h"
#include "relief/spline/lattice_filters.h"

namespace relief::multires {

namespace {

template <class Id>
struct Named {
    Id id;
    std::string_view name;
};

constexpr std::array<Named<SchemeId>, 4> kSchemes = {{{SchemeId::Barycentric, "barycentric"},
                                                      {SchemeId::Box, "box"},
                                                      {SchemeId::Cubic, "cubic"},
                                                      {SchemeId::Fvs, "fvs"}}};
constexpr std::array<Named<Family>, 4> kFamilies = {
    {{Family::Compact, "compact"},
     {Family::SemiOrthogonal, "semi-orthogonal"},
     {Family::TruncatedCorrect, "truncated"},
     {Family::TruncatedLiteral, "truncated-literal"}}};
constexpr std::array<Named<DataMap>, 3> kDataMaps = {
    {{DataMap::Interpolate, "interpolate"},
     {DataMap::QuasiInterpolate, "quasi-interpolate"},
     {DataMap::Coefficients, "coefficients"}}};

template <class Table, class Id>
std::string_view name_in(const Table& table, Id id) {
    for (const auto& entry : table)
        if (entry.id == id) return entry.name;
    return "unknown";
}

template <class Id, class Table>
Result<Id> find_in(const Table& table, std::string_view name, const char* what) {
    std::string known;
    for (const auto& entry : table) {
        if (entry.name == name) return entry.id;
        known += (known.empty() ? "" : ", ") + std::string(entry.name);
    }
    return Error{ErrorCode::InvalidArgument,
                 "unknown " + std::string(what) + " '" + std::string(name) + "'; known: " + known,
                 ""};
}

Result<PyramidLayout> scheme_layout(const SchemeSpec& spec, std::int64_t rows, std::int64_t cols,
                                    int components) {
    switch (spec.id) {
        case SchemeId::Box:
            return box::layout(spec, rows, cols, components);
        case SchemeId::Cubic:
            return cubic::layout(spec, rows, cols, components);
        case SchemeId::Fvs:
            return fvs::layout(spec, rows, cols, components);
        case SchemeId::Barycentric:
            break;
    }
    return barycentric::layout(spec, rows, cols, components);
}

template <class T>
Grid<T> scheme_coefficients(const Pyramid<T>& pyramid, int component, int level) {
    switch (pyramid.layout.spec.id) {
        case SchemeId::Box:
            return box::coefficients(pyramid, component, level);
        case SchemeId::Cubic:
            return cubic::coefficients(pyramid, component, level);
        case SchemeId::Fvs:
            return fvs::coefficients(pyramid, component, level);
        case SchemeId::Barycentric:
            break;
    }
    return barycentric::coefficients(pyramid, component, level);
}

template <class T>
void scheme_adjoint(GridView<const T> residual, int component, Pyramid<T>& out) {
    switch (out.layout.spec.id) {
        case SchemeId::Box:
            return box::adjoint<T>(residual, component, out);
        case SchemeId::Cubic:
            return cubic::adjoint<T>(residual, component, out);
        case SchemeId::Fvs:
            return fvs::adjoint<T>(residual, component, out);
        case SchemeId::Barycentric:
            break;
    }
    barycentric::adjoint<T>(residual, component, out);
}

template <class T>
void fill_zero(Pyramid<T>& pyramid) {
    for (Planes<T>& band : pyramid.bands)
        for (Grid<T>& plane : band)
            for (std::int64_t r = 0; r < plane.rows(); ++r)
                std::fill_n(plane.row(r), plane.cols(), T(0));
}

// Lattice maps fail for wrong orders and sizes only; those of a layout are right.

template <class T>
Grid<T> copied(GridView<const T> from) {
    Grid<T> grid(from.rows, from.cols);
    for (std::int64_t r = 0; r < from.rows; ++r) std::copy_n(from.row(r), from.cols, grid.row(r));
    return grid;
}

// --- norms
// ------------------------------------------------------------------------------------------------------

struct Norms {
    double samples = 1;
    double surface = 1;
    double max = 1;
};

/// Levels whose norms are measured; from there on each level doubles the L2 norms and keeps the
/// maximum.
constexpr int kMeasuredLevels = 3;
using NormTable = std::map<std::pair<int, int>, Norms>;  ///< by (level, channel)

Norms measure(const SchemeSpec& spec, const Grid<double>& atom) {
    Grid<double> other(atom.rows(), atom.cols());
    const auto square_sum = [](const Grid<double>& a, const Grid<double>& b) {
        double sum = 0;
        for (std::int64_t r = 0; r < a.rows(); ++r)
            for (std::int64_t c = 0; c < a.cols(); ++c) sum += a(r, c) * b(r, c);
        return sum;
    };
    Norms norms;
    (void)spline::gram_apply<double>(spec.order, atom.view(), other.view());
    norms.surface = std::sqrt(square_sum(atom, other));
    const Grid<double>* samples = &atom;
    if (!samples_are_coefficients(spec)) {
        (void)spline::sample_lattice<double>(spec.order, atom.view(), other.view());
        samples = &other;
    }
    norms.samples = std::sqrt(square_sum(*samples, *samples));
    norms.max = 0;
    for (std::int64_t r = 0; r < samples->rows(); ++r)
        for (std::int64_t c = 0; c < samples->cols(); ++c)
            norms.max = std::max(norms.max, std::abs((*samples)(r, c)));
    return norms;
}

/// Norms of the atoms of levels 1 .. kMeasuredLevels, by synthesis of one impulse in the middle of
/// a raster that holds the atom.
NormTable measure_norms(SchemeSpec spec) {
    NormTable table;
    for (int level = 1; level <= kMeasuredLevels; ++level) {
        spec.levels = level;
        const std::int64_t n = std::int64_t{48} << level;
        auto layout = scheme_layout(spec, n, n, 1);
        if (!layout.ok()) return table;
        auto pyramid = Pyramid<double>::allocate(*std::move(layout));
        fill_zero(pyramid);
        for (std::size_t k = 0; k < pyramid.bands.size(); ++k) {
            const BandLayout& band = pyramid.layout.bands[k];
            if (band.level != level) continue;
            double& middle = pyramid.bands[k][0](24 - band.box.row0, 24 - band.box.col0);
            middle = 1;
            table[{level, band.channel}] = measure(spec, scheme_coefficients(pyramid, 0, 0));
            middle = 0;
        }
    }
    return table;
}

const NormTable& norms_of(const SchemeSpec& spec) {
    using Key = std::tuple<SchemeId, int, Family, int, DataMap>;
    static std::mutex mutex;
    static std::map<Key, NormTable> tables;
    const std::lock_guard lock(mutex);
    const Key key{spec.id, spec.order, spec.family, spec.dual_order, spec.data_map};
    auto found = tables.find(key);
    if (found == tables.end()) found = tables.emplace(key, measure_norms(spec)).first;
    return found->second;
}

void fill_norms(PyramidLayout& layout) {
    if (layout.spec.id == SchemeId::Fvs) return;  // its layout has them
    const NormTable& table = norms_of(layout.spec);
    for (BandLayout& band : layout.bands) {
        if (band.level == 0) continue;
        const int measured = std::min(band.level, kMeasuredLevels);
        const auto found = table.find({measured, band.channel});
        if (found == table.end()) continue;
        const double factor = std::ldexp(1.0, band.level - measured);
        band.norm_samples = found->second.samples * factor;
        band.norm_surface = found->second.surface * factor;
        band.norm_max = found->second.max;
    }
}

}  // namespace

bool samples_are_coefficients(const SchemeSpec& spec) {
    return spec.id == SchemeId::Cubic || spec.id == SchemeId::Fvs || spec.order == 1 ||
           spec.data_map == DataMap::Coefficients;
}

std::string_view scheme_name(SchemeId id) {
    return name_in(kSchemes, id);
}
std::string_view family_name(Family family) {
    return name_in(kFamilies, family);
}
std::string_view data_map_name(DataMap map) {
    return name_in(kDataMaps, map);
}
Result<SchemeId> scheme_from_name(std::string_view name) {
    return find_in<SchemeId>(kSchemes, name, "scheme");
}
Result<Family> family_from_name(std::string_view name) {
    return find_in<Family>(kFamilies, name, "family");
}
Result<DataMap> data_map_from_name(std::string_view name) {
    return find_in<DataMap>(kDataMaps, name, "data map");
}

Result<PyramidLayout> layout(const SchemeSpec& spec, std::int64_t rows, std::int64_t cols,
                             int components) {
    constexpr std::int64_t most = INT32_MAX;
    if (rows < 1 || cols < 1)
        return Error{ErrorCode::BadInput, "the raster is empty; it needs at least one sample", ""};
    if (rows > most || cols > most)
        return Error{ErrorCode::BadInput,
                     "the raster has more than 2^31 - 1 samples a side; cut it into parts", ""};
    if (components < 1 || components > 4)
        return Error{
            ErrorCode::BadInput,
            "a surface has 1 to 4 components, not " + std::to_string(components) + "; choose bands",
            ""};
    RELIEF_TRY(PyramidLayout result, scheme_layout(spec, rows, cols, components));
    if (spec.id != SchemeId::Cubic) fill_norms(result);
    return result;
}

template <class T>
void analyse_coefficients(GridView<const T> scaling, int component, Pyramid<T>& out,
                          int first_level) {
    Workspace<T> workspace;
    switch (out.layout.spec.id) {
        case SchemeId::Box:
            return box::analyse<T>(scaling, component, out, workspace, first_level);
        case SchemeId::Cubic:
            return cubic::analyse<T>(scaling, component, out, workspace, first_level);
        case SchemeId::Fvs:
            return fvs::analyse<T>(scaling, component, out, first_level);
        case SchemeId::Barycentric:
            break;
    }
    barycentric::analyse<T>(scaling, component, out, workspace, first_level);
}

template <class T>
Result<Pyramid<T>> analyse(const std::vector<GridView<const T>>& planes, const SchemeSpec& spec) {
    if (planes.empty()) return Error{ErrorCode::BadInput, "the surface has no components", ""};
    for (const auto& plane : planes)
        if (plane.rows != planes[0].rows || plane.cols != planes[0].cols)
            return Error{ErrorCode::BadInput, "the components differ in size", ""};
    RELIEF_TRY(PyramidLayout bands,
               layout(spec, planes[0].rows, planes[0].cols, static_cast<int>(planes.size())));
    auto pyramid = Pyramid<T>::allocate(std::move(bands));
    for (std::size_t c = 0; c < planes.size(); ++c) {
        GridView<const T> finest = planes[c];
        Grid<T> mapped;
        if (!samples_are_coefficients(spec)) {
            mapped = Grid<T>(finest.rows, finest.cols);
            RELIEF_CHECK(spec.data_map == DataMap::Interpolate
                             ? spline::interpolate_lattice<T>(spec.order, finest, mapped.view())
                             : spline::quasi_interpolate<T>(spec.order, finest, mapped.view()));
            finest = std::as_const(mapped).view();
        }
        analyse_coefficients(finest, static_cast<int>(c), pyramid);
    }
    return pyramid;
}

LatticeBox scaling_box(const PyramidLayout& layout, int level) {
    if (level == layout.levels()) return layout.bands[0].box;
    if (layout.spec.id == SchemeId::Barycentric) return barycentric::level_box(layout, level);
    SchemeSpec spec = layout.spec;
    spec.levels = level;
    return scheme_layout(spec, layout.rows, layout.cols, 1)->bands[0].box;
}

std::vector<Grid<float>> coverage(const PyramidLayout& layout) {
    return layout.spec.id == SchemeId::Barycentric ? barycentric::coverage(layout)
                                                   : std::vector<Grid<float>>{};
}

template <class T>
LevelCoefficients<T> coefficients(const Pyramid<T>& pyramid, int level) {
    LevelCoefficients<T> result;
    result.box = scaling_box(pyramid.layout, level);
    for (int c = 0; c < pyramid.layout.components; ++c)
        result.planes.push_back(scheme_coefficients(pyramid, c, level));
    return result;
}

template <class T>
LevelCoefficients<T> subdivide(const PyramidLayout& layout, LevelCoefficients<T> coarse, int from,
                               int to) {
    if (from == to) return coarse;
    if (layout.spec.id == SchemeId::Fvs) {
        for (Grid<T>& plane : coarse.planes)
            plane = fvs::subdivide<T>(layout, plane.view(), from, to);
        return {scaling_box(layout, to), std::move(coarse.planes)};
    }
    SchemeSpec spec = layout.spec;
    spec.levels = from;
    auto bands =
        scheme_layout(spec, layout.rows, layout.cols, static_cast<int>(coarse.planes.size()));
    auto pyramid = Pyramid<T>::allocate(*std::move(bands));
    fill_zero(pyramid);
    pyramid.bands[0] = std::move(coarse.planes);
    return coefficients(pyramid, to);
}

template <class T>
Planes<T> samples_of(const PyramidLayout& layout, const LevelCoefficients<T>& level_coefficients,
                     int level) {
    const std::int64_t step = std::int64_t{1} << level;
    const std::int64_t rows = (layout.rows + step - 1) / step;
    const std::int64_t cols = (layout.cols + step - 1) / step;
    const LatticeBox& box = level_coefficients.box;
    Planes<T> result;
    for (const Grid<T>& plane : level_coefficients.planes) {
        GridView<const T> values = plane.view();
        Grid<T> sampled;
        if (!samples_are_coefficients(layout.spec)) {
            sampled = Grid<T>(plane.rows(), plane.cols());
            (void)spline::sample_lattice<T>(layout.spec.order, values, sampled.view());
            values = std::as_const(sampled).view();
        }
        if (sampled.empty() || box != LatticeBox{0, 0, rows, cols})
            sampled = copied(
                GridView<const T>(values.row(-box.row0) - box.col0, rows, cols, values.stride));
        result.push_back(std::move(sampled));
    }
    return result;
}

template <class T>
Planes<T> synthesise(const Pyramid<T>& pyramid, int level) {
    auto result = coefficients(pyramid, level);
    const PyramidLayout& layout = pyramid.layout;
    if (level == 0 && samples_are_coefficients(layout.spec)) return std::move(result.planes);
    return samples_of(layout, result, level);
}

template <class T>
Pyramid<T> adjoint(const PyramidLayout& layout, const std::vector<GridView<const T>>& planes) {
    auto pyramid = Pyramid<T>::allocate(layout);
    for (std::size_t c = 0; c < planes.size(); ++c) {
        GridView<const T> residual = planes[c];
        Grid<T> mapped;
        if (!samples_are_coefficients(layout.spec)) {
            mapped = Grid<T>(residual.rows, residual.cols);
            (void)spline::sample_lattice_adjoint<T>(layout.spec.order, residual, mapped.view());
            residual = std::as_const(mapped).view();
        }
        scheme_adjoint(residual, static_cast<int>(c), pyramid);
    }
    return pyramid;
}

#define RELIEF_INSTANTIATE(T)                                                                      \
    template Result<Pyramid<T>> analyse(const std::vector<GridView<const T>>&, const SchemeSpec&); \
    template void analyse_coefficients(GridView<const T>, int, Pyramid<T>&, int);                  \
    template LevelCoefficients<T> coefficients(const Pyramid<T>&, int);                            \
    template LevelCoefficients<T> subdivide(const PyramidLayout&, LevelCoefficients<T>, int, int); \
    template Planes<T> samples_of(const PyramidLayout&, const LevelCoefficients<T>&, int);         \
    template Planes<T> synthesise(const Pyramid<T>&, int);                                         \
    template Pyramid<T> adjoint(const PyramidLayout&, const std::vector<GridView<const T>>&);
RELIEF_INSTANTIATE(float)
RELIEF_INSTANTIATE(double)
#undef RELIEF_INSTANTIATE

}  // namespace relief::multires
