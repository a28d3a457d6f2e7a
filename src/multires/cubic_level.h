#pragma once

#include <array>

#include "multires/cubic_rules.h"
#include "multires/row_copy.h"
#include "relief/core/grid.h"

/// One level of the transform, on a whole lattice or a window of it. Tiles are independent (their
/// halos are computed twice by the same expressions), so neither threads nor windows change a bit.
namespace relief::multires::cubic {

/// A part of a lattice, addressed by the indices of the lattice.
template <class T>
struct Part {
    GridView<T> view;
    std::int64_t row0 = 0;
    std::int64_t col0 = 0;

    Part() = default;
    Part(GridView<T> values, std::int64_t first_row, std::int64_t first_col)
        : view(values), row0(first_row), col0(first_col) {}
    /// A part of mutable values is also one of const values.
    template <class U>
    requires std::is_same_v<const U, T> Part(const Part<U>& o)
        : view(o.view), row0(o.row0), col0(o.col0) {}  // NOLINT: implicit

    [[nodiscard]] T* at(std::int64_t row, std::int64_t col) const {
        return view.row(row - row0) + (col - col0);
    }
};

/// The four bands that one level makes of a lattice: channel 0 (even samples, the next scaling
/// band), 1 (odd columns), 2 (odd rows), 3 (both).
template <class T>
using Bands = std::array<Part<T>, 4>;

constexpr std::size_t channel(Parity row, Parity col) {
    return 2 * index(row) + index(col);
}

/// Pairs of rows and columns of a fine lattice.
struct Window {
    Axis rows;
    Axis cols;
};

/// Lifts along the rows, then along the columns: analysis, and the transpose of synthesis. Writes
/// the members of the window's pairs to `bands`. `fine` has, as far as they exist, the samples of
/// these pairs and of 2 kReach more on every side.
template <class T>
void split_level(const Lifting& lifting, const Window& window, const Part<const T>& fine,
                 const Bands<T>& bands);

/// Synthesis: lifts along the columns, then along the rows. Writes the samples of `fine`, which lie
/// in the window's pairs. `bands` have, as far as they exist, the members of these pairs and more
/// on every side: of even rows (columns) kReach, of odd ones 2 kReach. `traffic`: whether `fine`
/// will be read soon.
template <class T>
void merge_level(const Window& window, const Bands<const T>& bands, Traffic traffic,
                 const Part<T>& fine);

}  // namespace relief::multires::cubic
