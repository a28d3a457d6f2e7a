#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "relief/multires/pyramid.h"

/// The one door to all raster schemes: what codec, editing and faces call.
namespace relief::multires {

/// "barycentric", "box", "cubic", "fvs". Errors: InvalidArgument listing the known names.
[[nodiscard]] Result<SchemeId> scheme_from_name(std::string_view name);
[[nodiscard]] std::string_view scheme_name(SchemeId id);
[[nodiscard]] std::string_view family_name(Family family);
[[nodiscard]] Result<Family> family_from_name(std::string_view name);
[[nodiscard]] std::string_view data_map_name(DataMap map);
[[nodiscard]] Result<DataMap> data_map_from_name(std::string_view name);

/// Whether the values of a surface at the lattice points are its coefficients: linear surfaces, the
/// cardinal form of scheme `cubic`, and the data map that says so.
[[nodiscard]] bool samples_are_coefficients(const SchemeSpec& spec);

/// The bands of a rows x cols raster with 1 .. 4 components, with their norms.
/// Errors: InvalidArgument for an order, family, dual order or level count the scheme does not
/// have; BadInput for an empty raster or one of more than 2^31 - 1 samples a side. Complexity:
/// O(levels) after the first call of a spec.
[[nodiscard]] Result<PyramidLayout> layout(const SchemeSpec& spec, std::int64_t rows,
                                           std::int64_t cols, int components);

/// Samples to pyramid. planes: 1 .. 4 grids of one size, finite values. Complexity: O(samples).
template <class T>
[[nodiscard]] Result<Pyramid<T>> analyse(const std::vector<GridView<const T>>& planes,
                                         const SchemeSpec& spec);

/// Scaling coefficients of `first_level` (0: the finest) to the bands of `component` above that
/// level, in `out` (allocated). Complexity: O(coefficients).
template <class T>
void analyse_coefficients(GridView<const T> scaling, int component, Pyramid<T>& out,
                          int first_level = 0);

/// The scaling coefficients of `level` (0: finest .. levels: the coarsest band itself), finer
/// details unused.
template <class T>
[[nodiscard]] LevelCoefficients<T> coefficients(const Pyramid<T>& pyramid, int level = 0);

/// The box of the scaling coefficients of `level`, as `coefficients` returns it.
[[nodiscard]] LatticeBox scaling_box(const PyramidLayout& layout, int level);

/// The scaling coefficients of `to` that those of level `from` >= `to` alone describe: subdivision
/// without details.
template <class T>
[[nodiscard]] LevelCoefficients<T> subdivide(const PyramidLayout& layout,
                                             LevelCoefficients<T> coarse, int from, int to);

/// From the scaling coefficients of `level` to the raster of that level: synthesise(p, l) is
/// samples_of(p.layout, coefficients(p, l), l).
template <class T>
[[nodiscard]] Planes<T> samples_of(const PyramidLayout& layout,
                                   const LevelCoefficients<T>& level_coefficients, int level);

/// The surface of `level` sampled at every 2^level-th raster sample of each axis: ceil(rows /
/// 2^level) rows. Level 0 gives the raster back.
template <class T>
[[nodiscard]] Planes<T> synthesise(const Pyramid<T>& pyramid, int level = 0);

/// For each band, which part of the squared norm of each atom lies on the raster; empty for schemes
/// without coefficients beyond the border. What an oracle should multiply squared norms by.
[[nodiscard]] std::vector<Grid<float>> coverage(const PyramidLayout& layout);

/// The transpose of coefficients(pyramid, 0) followed by the data map: from sample residuals to a
/// gradient with respect to every coefficient, for least squares. planes: one per component.
template <class T>
[[nodiscard]] Pyramid<T> adjoint(const PyramidLayout& layout,
                                 const std::vector<GridView<const T>>& planes);

}  // namespace relief::multires
