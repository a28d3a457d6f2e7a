#pragma once

#include <array>
#include <cstdint>

#include "relief/core/grid.h"
#include "relief/multires/filters.h"

/// One level of the barycentric transform, tile by tile. Private to the module.
namespace relief::multires::barycentric {

/// Where analysis reads fine rows from: a grid on a box, and a value for every lattice point around
/// it.
template <class T>
class RowSource {
  public:
    RowSource(GridView<const T> grid, const LatticeBox& box) : grid_(grid), box_(box) {}
    virtual ~RowSource() = default;
    /// out[k] = value at (row, col0 + k), k < n.
    virtual void fill(std::int64_t row, std::int64_t col0, std::int64_t n, T* out) const = 0;

    /// Where values are those of the grid.
    [[nodiscard]] const LatticeBox& box() const { return box_; }
    /// The address of a value inside the box.
    [[nodiscard]] const T* at(std::int64_t row, std::int64_t col) const {
        return grid_.row(row - box_.row0) + (col - box_.col0);
    }

  protected:
    GridView<const T> grid_;
    LatticeBox box_;
};

/// The extension of the specification's section 5: c(-k) = 2 c(0) - c(k), first along rows (i),
/// then along columns.
template <class T>
class ExtendedRows final : public RowSource<T> {
  public:
    using RowSource<T>::RowSource;
    void fill(std::int64_t row, std::int64_t col0, std::int64_t n, T* out) const override;

  private:
    using RowSource<T>::grid_;
    using RowSource<T>::box_;
};

/// Zero outside the box: what the transpose of synthesis sees; or, with a box that is large enough,
/// a plain copy.
template <class T>
class ZeroRows final : public RowSource<T> {
  public:
    using RowSource<T>::RowSource;
    void fill(std::int64_t row, std::int64_t col0, std::int64_t n, T* out) const override;

  private:
    using RowSource<T>::grid_;
    using RowSource<T>::box_;
};

/// One of the 8 channels of a level.
template <class T>
struct Channel {
    LatticeBox box;
    GridView<T> view;
};

/// channel_XYZ(x) = scale * sum X(l) Y(m) Z(n) fine(2x + l e1 + m e2 + n e3), X, Y, Z in {low,
/// high} by the channel's letters.
template <class T>
void analyse_level(const Sequence& low, const Sequence& high, double scale,
                   const RowSource<T>& fine, const std::array<Channel<T>, 8>& channels);

/// fine(y) = scale * sum over channels and x of X Y Z (y - 2x) channel_XYZ(x) on `box`: the
/// transpose of analyse_level.
template <class T>
void synthesise_level(const Sequence& low, const Sequence& high, double scale,
                      const std::array<Channel<const T>, 8>& channels, const LatticeBox& box,
                      GridView<T> fine);

/// In place grid <- D(z^2)^-1 grid along e1, e2 and e3, where D has these poles and this gain; zero
/// outside the grid.
template <class T>
void divide_by_symbol(const std::vector<double>& poles, double gain, GridView<T> grid);

}  // namespace relief::multires::barycentric
