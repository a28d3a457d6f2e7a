#pragma once

#include <cstdint>

#include "relief/core/grid.h"

namespace relief::multires {

/// Memory for the scaling coefficients between levels, a third of a raster, kept from call to call:
/// for several components or many tiles, first touch of fresh memory would cost as much as a level.
/// One workspace serves one call at a time.
template <class T>
class Workspace {
  public:
    /// rows x cols elements, not initialised, valid until slot 0 or 1 is asked for again.
    GridView<T> grid(int slot, std::int64_t rows, std::int64_t cols) {
        constexpr std::int64_t line = 64 / std::int64_t(sizeof(T));
        const std::int64_t stride = ((cols + line - 1) / line | 1) * line;
        Buffer<T>& buffer = slots_[slot];
        if (buffer.size() < std::size_t(rows * stride))
            buffer = Buffer<T>(std::size_t(rows * stride));
        return {buffer.data(), rows, cols, stride};
    }

  private:
    Buffer<T> slots_[2];
};

}  // namespace relief::multires
