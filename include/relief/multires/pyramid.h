#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "relief/core/grid.h"
#include "relief/core/result.h"

/// What analysis makes of a surface, and all that oracles, codec, editing and viewers know of it.
namespace relief::multires {

enum class SchemeId : std::uint8_t {
    Barycentric,  ///< box spline M_ddd, 7 wavelet kinds a level (a frame); docs/barycentric.md
    Box,          ///< the same splines, 3 wavelets a level by lifting (a basis); docs/box.md
    Cubic,        ///< bicubic C2 splines on the square lattice, by lifting (a basis); docs/cubic.md
    Fvs,          ///< C1 cubic splines on quadrilaterals cut by both diagonals; docs/fvs.md
};

/// The pair of dual sequences of scheme `barycentric`.
enum class Family : std::uint8_t {
    Compact,           ///< biorthogonal pair (d, dual order), all filters finite
    SemiOrthogonal,    ///< Chui-Wang; analysis by exact recursive solves
    TruncatedCorrect,  ///< the paper's 19- and 17-tap filters with b corrected: reproduction only,
                       ///< not exact
    TruncatedLiteral,  ///< the paper's table to the letter
};

/// How raster samples and finest scaling coefficients correspond. For linear surfaces all three are
/// the same.
enum class DataMap : std::uint8_t {
    Interpolate,       ///< the surface passes through the samples
    QuasiInterpolate,  ///< local, fourth-order accurate; the surface smooths the samples slightly
    Coefficients,      ///< the samples ARE the control coefficients, as in the source paper
};

/// Everything that fixes a scheme but the data.
struct SchemeSpec {
    SchemeId id = SchemeId::Box;
    int order = 2;  ///< d: 1 linear C0, 2 quartic C2 (cubic: bicubic C2), 3 degree 7 C4, 4 degree
                    ///< 10 C6
    Family family = Family::Compact;  ///< barycentric only
    int dual_order = 0;               ///< barycentric compact only; 0: the same as order
    int levels = -1;                  ///< -1: as many as are useful for the size
    DataMap data_map = DataMap::Interpolate;
    bool exact = false;  ///< cubic only: the whole spline by recursion, not its taps cut at six

    friend bool operator==(const SchemeSpec&, const SchemeSpec&) = default;
};

/// One band's place in the pyramid.
struct BandLayout {
    std::string name;  ///< "aaa" (scaling), "aab" ..; "scaling", "edge1" .. or "odd-x" ..
    int level = 0;     ///< 1: finest details .. levels: coarsest details and the scaling band
    int channel = 0;   ///< 0: scaling; details count from 1
    LatticeBox box;    ///< in units of 2^level samples; (i, j) sits at fine (2^level i, 2^level j)
    double norm_samples =
        1;  ///< root of the sum of squares, over the raster samples, of one unit of a coefficient
    double norm_surface = 1;  ///< L2 norm of the atom as a surface (area in samples)
    double norm_max = 1;      ///< largest absolute value of the atom at a sample
};

/// Which bands a raster of rows x cols has under a scheme. bands[0] is the coarsest scaling band,
/// then details from the coarsest level to level 1, channels ascending within a level.
struct PyramidLayout {
    SchemeSpec spec;  ///< with levels and dual_order resolved
    std::int64_t rows = 0;
    std::int64_t cols = 0;
    int components = 1;  ///< 1 .. 4, planar
    std::vector<BandLayout> bands;

    [[nodiscard]] int levels() const { return spec.levels; }
    /// Coefficients of one component.
    [[nodiscard]] std::int64_t coefficients() const {
        std::int64_t n = 0;
        for (const BandLayout& band : bands) n += band.box.count();
        return n;
    }
};

/// Components of one raster or of one band: 1 .. 4 grids of the same size.
template <class T>
using Planes = std::vector<Grid<T>>;

/// Coefficients: bands[k][component] has the size of layout.bands[k].box.
template <class T>
struct Pyramid {
    PyramidLayout layout;
    std::vector<Planes<T>> bands;

    /// All bands allocated, not initialised.
    static Pyramid allocate(const PyramidLayout& layout) {
        Pyramid p;
        p.layout = layout;
        for (const BandLayout& band : p.layout.bands) {
            Planes<T> planes;
            for (int c = 0; c < p.layout.components; ++c)
                planes.emplace_back(band.box.rows, band.box.cols);
            p.bands.push_back(std::move(planes));
        }
        return p;
    }
};

/// The scaling coefficients of one level on their lattice box.
template <class T>
struct LevelCoefficients {
    LatticeBox box;
    Planes<T> planes;
};

}  // namespace relief::multires
