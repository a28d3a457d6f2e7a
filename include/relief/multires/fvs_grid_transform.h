#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "relief/core/grid.h"
#include "relief/core/result.h"
#include "relief/spline/fvs_grid.h"

/// The hierarchical transform of C1 cubic splines on rectangular grids. Halving the cells of a
/// spline space gives a larger one; what its finer data are beyond the coarse spline's is detail.
/// Source: specification of hierarchical FVS splines, sections 4, 5, 8 and 9.
namespace relief::multires::fvs {

using spline::FvsGrid;
using spline::FvsGridView;

/// The details of a level, by what they belong to: each coarse horizontal edge has 4, each vertical
/// edge 4, each cell 7. "a" is the half nearer to the origin, "b" the other.
enum DetailKind : int {
    kEhv,   ///< horizontal edge: value at its midpoint
    kEht,   ///< derivative along x at its midpoint
    kGh0a,  ///< derivative along y in the middle of its halves
    kGh0b,
    kEvv,   ///< vertical edge: value at its midpoint
    kEvt,   ///< derivative along y at its midpoint
    kGv0a,  ///< derivative along x in the middle of its halves
    kGv0b,
    kCv,    ///< cell: value at its centre
    kCx,    ///< derivative along x there
    kCy,    ///< derivative along y there
    kGh1a,  ///< derivative along y left and right of the centre
    kGh1b,
    kGv1a,  ///< derivative along x below (nearer to row 0) and above the centre
    kGv1b,
};
inline constexpr int kDetailKinds = 15;

/// "ehv", "eht", "gh0a" ..
[[nodiscard]] std::string_view detail_name(int kind);
/// The array of nodal data that a detail corrects (spline::FvsPlane).
[[nodiscard]] int detail_plane(int kind);

/// One array a kind, not owned.
template <class T>
using DetailViews = std::array<GridView<T>, kDetailKinds>;

/// One array a kind, owned.
template <class T>
struct Details {
    std::array<Grid<T>, kDetailKinds> planes;

    /// Arrays for a fine grid of nx x ny cells, not initialised.
    Details(std::int64_t nx, std::int64_t ny);

    [[nodiscard]] Grid<T>& operator[](int kind) { return planes[static_cast<std::size_t>(kind)]; }
    [[nodiscard]] const Grid<T>& operator[](int kind) const {
        return planes[static_cast<std::size_t>(kind)];
    }
    [[nodiscard]] DetailViews<T> view();
    [[nodiscard]] DetailViews<const T> view() const;
};

/// Coarse cells over n fine ones; an odd n leaves half of the last cell without data.
[[nodiscard]] constexpr std::int64_t coarser(std::int64_t n) {
    return (n + 1) / 2;
}

/// The rows and columns of a kind's array for a fine grid of nx x ny cells (origin 0). Data of the
/// missing half of a last cell have no details.
[[nodiscard]] LatticeBox detail_box(int kind, std::int64_t nx, std::int64_t ny);

/// Whether coarse data are the fine spline's own (interpolation: coarse surfaces pass through the
/// samples) or are updated so that coarse surfaces are close to the fine ones in the mean (L2
/// stable). The update of a detail changes the data of the one or two cells that it belongs to, by
/// the projection of its basis function on their basis functions.
enum class Lifting { None, L2 };

/// Fine data of the coarse spline itself. Requires: fine grid of nx x ny cells, coarse one of
/// coarser(nx) x coarser(ny); spacing of fine half of that of coarse. Complexity: O(cells), in
/// parallel, vectors along x.
template <class T>
void predict(const FvsGridView<const T>& coarse, const FvsGridView<T>& fine);

/// Splits fine data into coarse ones and details. Where a side has an odd number of cells the line
/// beyond it is made by odd reflection of the values in the last line; it does not enter the data
/// that `reconstruct` returns. Requires: sizes and spacing as `predict`, details as `Details`.
template <class T>
void decompose(const FvsGridView<const T>& fine, Lifting lifting, const FvsGridView<T>& coarse,
               const DetailViews<T>& details);

/// The details of `fine` against coarse data that are not its own, such as decoded ones:
/// reconstruct(coarse, details, Lifting::None) has the new numbers of `fine`, which is how a closed
/// loop keeps errors from adding up. Requires: sizes and spacing as `predict`.
template <class T>
void details_against(const FvsGridView<const T>& coarse, const FvsGridView<const T>& fine,
                     const DetailViews<T>& details);

/// The inverse of `decompose`, up to rounding. `coarse` and `details` are used as working memory.
template <class T>
void reconstruct(const FvsGridView<T>& coarse, const DetailViews<T>& details, Lifting lifting,
                 const FvsGridView<T>& fine);

/// The transpose of `reconstruct`: <reconstruct(c, d), r> = <c, coarse> + <d, details>. Requires:
/// as decompose.
template <class T>
void transpose(const FvsGridView<const T>& fine_residual, Lifting lifting,
               const FvsGridView<T>& coarse, const DetailViews<T>& details);

/// Values of the next finer level from those of a coarse one alone: derivatives are estimated on
/// the coarse lattice, values between predicted by the spline. Requires: coarse is (coarser(rows -
/// 1) + 1) x (coarser(cols - 1) + 1) for fine of rows x cols, both sides of `fine` at least 1.
/// Source: section 8.3.
template <class T>
void predict_values(GridView<const T> coarse, GridView<T> fine);

}  // namespace relief::multires::fvs
