#pragma once

#include <array>
#include <span>
#include <vector>

#include "relief/multires/ps_space.h"

/// Refinement of Powell-Sabin spaces: the finer space contains the coarser one, and every spline
/// stays as it is. Source: powell-sabin.md sections 6 to 9; docs/powell-sabin.md.
namespace relief::multires::ps {

enum class Scheme {
    Triadic,  ///< each edge into three, each triangle into nine: two steps of Root3
    /// A vertex in each triangle, every inner edge turned. Splits of the triangles along the
    /// boundary are no longer those of the text: for study, not for hierarchies.
    Root3,
    Dyadic,  ///< each edge into two at R, each triangle into four; regular meshes only
};

/// The control triangles of the refined space. Scheme Dyadic always has the smallest.
enum class Rescale {
    Tight,     ///< copies of the old, as small as possible: cheap, well-conditioned
    Smallest,  ///< those of make_space: best conditioned
    Paper,     ///< copies scaled by kappa: condition doubles a level
    None,      ///< the old: condition grows tenfold a level
};

/// How far from a vertex its edges are cut, in the part kappa of the way to R.
enum class CutRule {
    Closed,   ///< min(2/3, eta times what is possible)
    Halving,  ///< 2/3, halved until it is less than that
};

struct RefineOptions {
    Scheme scheme = Scheme::Triadic;
    Rescale rescale = Rescale::Tight;
    CutRule cut = CutRule::Closed;
    double eta = 0.75;  ///< in (0, 1)
};

/// A refined space and what its splines need to know of the step. Vertices: the old, then (Triadic,
/// Root3) one for each triangle at Z, then (Triadic) two for each edge, near its lower and near its
/// higher end, or (Dyadic) one for each edge at R.
struct Refinement {
    Scheme scheme = Scheme::Triadic;
    Space fine;
    std::vector<double> kappa;         ///< of each old vertex; empty for Dyadic
    std::vector<double> second_kappa;  ///< of the second half of a triadic step; else empty
};

/// Errors: `invalid_eta`; `too_many_elements` (2^31 edges); `dyadic_not_applicable` if some Z is
/// not inside the triangle of its R; and, for meshes too thin to be refined in double precision,
/// `degenerate_triangle`, `edge_not_crossed`, `degenerate_split`, `degenerate_hull`. Complexity:
/// O(n).
[[nodiscard]] Result<Refinement> refine(const Space& coarse, const RefineOptions& options = {});

/// The coefficients on the refined space. Requires: a checked spline of the coarse space, the
/// refinement of that space. Complexity: O(n); no matrix is formed.
[[nodiscard]] Coefficients prolong(const Space& coarse, const Refinement& step,
                                   std::span<const Heights> spline);

/// The transpose of prolong: sum of fine numbers times the coarse functions' coefficients.
[[nodiscard]] Coefficients transpose_prolong(const Space& coarse, const Refinement& step,
                                             std::span<const Heights> fine);

/// The three rows of the matrix of prolong that belong to a fine vertex: its coefficient j is the
/// sum over k < count and l of block[k][j][l] times coefficient l of coarse vertex[k].
struct StepRows {
    using Block = std::array<std::array<double, 3>, 3>;
    int count = 0;
    std::array<mesh::Index, 3> vertex{};
    std::array<Block, 3> block{};
};
[[nodiscard]] StepRows step_rows(const Space& coarse, const Refinement& step, mesh::Index fine);

}  // namespace relief::multires::ps
