#pragma once

#include <vector>

#include "relief/mesh/triangulation.h"

namespace relief::mesh {

/// Samples in rows over the plane: that of row r and column c lies at first + (c step.x, r step.y),
/// in the coordinates of a mesh's source.
struct SampleRows {
    Vec2 first;
    Vec2 step{1, 1};  ///< step.x > 0, step.y not 0
    Index rows = 0;
    Index columns = 0;

    [[nodiscard]] Vec2 at(Index row, Index column) const {
        return {first.x + column * step.x, first.y + row * step.y};
    }
};

/// Columns begin .. end - 1 of a row lie in a triangle.
struct SampleRun {
    Index triangle = 0;
    Index begin = 0;
    Index end = 0;

    friend bool operator==(const SampleRun&, const SampleRun&) = default;
};

/// Finds the triangles of all samples of a raster, row by row: far faster than one by one where
/// triangles are larger than samples. Immutable; several threads may ask.
class RowScan {
  public:
    /// The mesh must outlive the scan and keep its address. Requires: at least one row and column,
    /// all places finite. Complexity: O(n + rows); memory: 4 bytes for each triangle in each 8
    /// rows that it meets.
    RowScan(const Triangulation& mesh, const SampleRows& samples);

    /// The runs of a row, from left to right, without those outside: every sample belongs to the
    /// triangle that TriangleLocator::locate says. Complexity: O(columns + triangles at the row).
    [[nodiscard]] std::vector<SampleRun> runs(Index row) const;

  private:
    [[nodiscard]] SampleRun run_of(Index triangle, Index row) const;

    const Triangulation& mesh_;
    SampleRows samples_;
    std::vector<Index> first_;      ///< the triangles at rows 8 b .. 8 b + 7, ascending, are
    std::vector<Index> triangles_;  ///< triangles_[first_[b]] .. triangles_[first_[b + 1] - 1]
};

}  // namespace relief::mesh
