#pragma once

#include "relief/multires/fvs_mesh.h"

/// Splines on quadrangulations for storage: a quantiser whose errors do not add up over the levels,
/// for a bound on the largest error, and a lifted transform that is stable in L2, for the
/// root-mean-square error. They do not combine. Source: fvs-hierarchical.md sections 8.2 and 9.
namespace relief::multires::fvs_mesh {

/// Multiples of the steps: `step` for values, kappa step / h for derivatives, with h as in
/// `Convention` and, at level 0, the length of the edge or the mean length of a vertex's edges.
struct Quantised {
    double step = 0;
    double kappa = 4;
    Nodal<std::int32_t> base;
    std::vector<Details<std::int32_t>> details;
};

/// Closed loop: each level is predicted from the dequantised level below it, and what is missing is
/// rounded to whole steps (ties to even). A number of level m is off by at most half its step.
/// Errors: those of check; `step_not_positive`; `step_too_small` if a multiple exceeds 2^31 - 1.
[[nodiscard]] Result<Quantised> quantise(const Hierarchy& hierarchy, const NodalData& finest,
                                         double step, double kappa = 4);

/// The spline of `level` that `quantise` arrived at, to the bit on every machine. Errors:
/// `level_out_of_range`, `size_mismatch`, `step_not_positive`, `non_finite_data` if numbers
/// overflow.
[[nodiscard]] Result<NodalData> dequantise(const Hierarchy& hierarchy, const Quantised& code,
                                           int level);

struct ClosedLoopOptions {
    double kappa = 4;
    int search_refinements = 1;       ///< of the bound during the search
    int certificate_refinements = 2;  ///< of the bound that is reported
    int bisections = 10;
};

struct ClosedLoop {
    Quantised code;
    double bound = 0;  ///< certified largest error of dequantise(., ., levels())
};

/// The coarsest step, found by bisection, for which the certified error is at most `tolerance`.
/// Errors: those of quantise, `tolerance_not_positive`, `tolerance_too_small` if it lies below the
/// rounding of the data. Complexity: about 12 quantisations.
[[nodiscard]] Result<ClosedLoop> quantise_within(const Hierarchy& hierarchy,
                                                 const NodalData& finest, double tolerance,
                                                 const ClosedLoopOptions& options = {});

/// The update step of every level: a detail moves the coarse spline towards the L2 projection, on
/// the functionals of the one or two parent quads that own it.
class Update {
  public:
    /// Errors: `degenerate_quad` if a mass matrix is singular in double precision. Complexity: O(n)
    /// with a large constant; memory: 300 numbers a parent quad.
    [[nodiscard]] static Result<Update> create(const Hierarchy& hierarchy);

    /// Adds `sign` times U_m details to the spline of level m - 1.
    void apply(const mesh::Quadrangulation& parent, int level, const Details<double>& details,
               double sign, NodalData& low) const;

    /// weights()[m - 1]: L2 norm of what one unit of a detail of level m adds to the surface.
    [[nodiscard]] const std::vector<Details<double>>& weights() const { return weights_; }

  private:
    /// Columns of U: for every parent quad those of centre_value, centre_dx, centre_dy and of its
    /// four inner edges, 16 numbers each; for every parent edge those of edge_value,
    /// edge_tangential and its two halves, 25 numbers each.
    struct Level {
        std::vector<std::array<double, 7 * 16>> quad_columns;
        std::vector<std::array<double, 4 * 25>> edge_columns;
        std::vector<std::array<mesh::Index, 2>> edge_quads;
    };
    friend class UpdateBuilder;
    std::vector<Level> levels_;
    std::vector<Details<double>> weights_;
};

/// As decompose and reconstruct, with the update.
[[nodiscard]] Result<Decomposition> decompose_lifted(const Hierarchy& hierarchy,
                                                     const Update& update, NodalData finest);
[[nodiscard]] Result<NodalData> reconstruct_lifted(const Hierarchy& hierarchy, const Update& update,
                                                   const Decomposition& coefficients, int level);

/// Limits for `threshold` that drop details which change the surface by less than epsilon in L2.
[[nodiscard]] std::vector<Details<double>> lifted_limits(const Update& update, double epsilon);

struct FitOptions {
    double ridge = 1e-10;      ///< weight of the change of the unknowns, derivatives times h
    double reduction = 1e-10;  ///< of the residual of the normal equations, ends the iteration
    int iterations = 5000;     ///< at most
};

struct Fit {
    NodalData data;
    int iterations = 0;
    double rms = 0;  ///< of the residuals at the samples
};

/// The spline of `level` nearest to scattered samples in the sense of least squares, by conjugate
/// gradients (preconditioned by the diagonal) from `start`, which also decides where samples say
/// nothing. Sensible from about two samples a quad and direction. Errors: those of check for
/// `start`; `level_out_of_range`, `size_mismatch`, `non_finite_data`, `outside_domain` for a
/// sample, `no_samples`, `ridge_not_positive`. Complexity: O(samples log n + iterations n).
[[nodiscard]] Result<Fit> fit(const Hierarchy& hierarchy, int level, std::span<const Vec2> points,
                              std::span<const double> values, const NodalData& start,
                              const FitOptions& options = {});

}  // namespace relief::multires::fvs_mesh
