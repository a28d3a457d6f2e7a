#pragma once

#include <optional>
#include <string>
#include <vector>

#include "relief/core/raster.h"

/// The numbers of the source papers beside ours.
namespace relief::reproduce {

struct Row {
    std::string source;  ///< which paper
    std::string item;    ///< the case: an equation, figure or data set
    std::string quantity;
    std::optional<double> paper;  ///< what the paper prints; none where it prints nothing
    double ours = 0;
    std::string note;
};

struct Terrain {
    std::string name;
    Raster raster;
};

/// Dreger, Gross, Schlegel: triangular B-spline surfaces by hexagonal filters (ETH Zurich, report
/// 327, 1999).
[[nodiscard]] std::vector<Row> barycentric_rows(const std::vector<Terrain>& terrains);

/// Hong, Schumaker: surface compression using a space of C1 cubic splines with a hierarchical
/// basis.
[[nodiscard]] std::vector<Row> fvs_rows();

}  // namespace relief::reproduce
