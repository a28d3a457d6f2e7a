#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "relief/core/raster.h"
#include "relief/core/result.h"

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

/// The rows of one paper.
class Rows {
  public:
    explicit Rows(std::string source) : source_(std::move(source)) {}

    void add(std::string item, std::string quantity, std::optional<double> paper, double ours,
             std::string note = "") {
        rows_.push_back(
            {source_, std::move(item), std::move(quantity), paper, ours, std::move(note)});
    }
    [[nodiscard]] std::vector<Row> take() && { return std::move(rows_); }

  private:
    std::string source_;
    std::vector<Row> rows_;
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

/// Multiresolution by reversing subdivision, its filters found by diagrams: sqrt(3), with Loop and
/// Catmull-Clark.
[[nodiscard]] std::vector<Row> reverse_rows();
/// Its figures, drawn with our meshes: PNG and SVG files in a folder that exists. Errors: those of
/// io::write_png and io::write_file_atomically.
[[nodiscard]] Status reverse_figures(const std::string& folder);

/// Vanraes, Windmolders, Bultheel, Dierckx: automatic construction of control triangles for
/// subdivided Powell-Sabin splines.
[[nodiscard]] std::vector<Row> powell_sabin_rows();
/// Its figures, drawn with our meshes: SVG files in a folder that exists. Errors: those of
/// io::write_file_atomically.
[[nodiscard]] Status powell_sabin_figures(const std::string& folder);

}  // namespace relief::reproduce
