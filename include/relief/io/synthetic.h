#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "relief/core/result.h"
#include "relief/io/raster.h"

/// Surfaces made by formula, for examples, tests and measurements. All are float32 rasters with
/// values rounded to float32, row 0 north, a local transform in metres and no CRS. Sizes are
/// clamped to 2 .. 65536. Complexity: O(samples), in parallel, the same values for any thread
/// count.
namespace relief::io {

/// Franke's function on [0, 1]^2: n x n samples, corners included; x grows with the column, y with
/// -row. Source: R. Franke, Scattered data interpolation: tests of some methods, Math. Comp. 38
/// (1982).
[[nodiscard]] Raster franke(int n);

/// A narrow smooth bump on [0, 1]^2: exp(-R / (R - rho^2)) where rho^2 < R = 1/128, else 0; rho is
/// the distance to the centre. Infinitely smooth, with compact support. See spec fvs-hierarchical,
/// section 6.
[[nodiscard]] Raster bump(int n);

/// Mountains: ridged multifractal noise (F. K. Musgrave, in Texturing and Modeling, 1994) over
/// warped ground, n x n samples 30 m apart, heights about 0 .. 3000 m. The same on every machine:
/// only additions, multiplications and comparisons of an integer hash.
[[nodiscard]] Raster ridged(int n, std::uint32_t seed);

/// A torus as a parametric surface: n rows around the tube, 2 n columns around the axis, planes x,
/// y, z in metres; first and last row, and first and last column, coincide.
[[nodiscard]] Raster torus(int n);

/// A face as a range camera sees it: depth in metres on an n x n grid 0.26 m wide, holes outside
/// the head.
[[nodiscard]] Raster face(int n);

/// "franke", "bump", "ridged", "torus", "face".
[[nodiscard]] std::vector<std::string_view> synthetic_names();

struct SyntheticOptions {
    int size = 513;          ///< n above, 2 .. 65536
    std::uint32_t seed = 1;  ///< `ridged` only
};

/// The surface of that name. Errors: InvalidArgument (unknown name, listing all; size out of
/// range).
[[nodiscard]] Result<Raster> synthetic(std::string_view name, const SyntheticOptions& options = {});

}  // namespace relief::io
