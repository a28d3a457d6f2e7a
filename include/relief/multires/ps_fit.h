#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "relief/multires/ps_space.h"

/// Powell-Sabin splines near scattered data: least squares with smoothing. Source: powell-sabin.md
/// section 12 (c); docs/powell-sabin.md.
namespace relief::multires::ps {

/// Where the data are: in the coordinates of the triangulation's source.
struct DataSites {
    std::span<const Vec2> points;
    std::span<const mesh::Index> triangles;  ///< the triangle of each point
    std::span<const double> weights;         ///< not negative; empty: all 1
};

/// What smoothing penalises: zero for linear functions, or for quadratic ones.
enum class Energy {
    ThinPlate,  ///< the integral of the squared second derivatives
    Jump,       ///< the jumps of the second derivatives
};

struct FitReport {
    double smoothing = 0;
    double rms_error = 0;   ///< at the points, weighted; of all components
    double max_error = 0;   ///< of the points of positive weight and any component
    std::size_t worst = 0;  ///< the point of the largest error
};

struct FittedSpline {
    Coefficients spline;
    FitReport report;
};
struct FittedSplines {
    std::vector<Coefficients> components;
    FitReport report;
};

/// A space and the sites of data, ready to be fitted to any number of value sets.
class LeastSquares {
  public:
    /// The space must outlive this. Errors: `size_mismatch`; `non_finite_input` and
    /// InvalidArgument for a weight that is negative, naming the point; `no_data` if there is no
    /// point of positive weight.
    /// Complexity: O(points + n).
    [[nodiscard]] static Result<LeastSquares> create(const Space& space, const DataSites& sites,
                                                     Energy energy = Energy::ThinPlate);
    LeastSquares(LeastSquares&&) noexcept;
    LeastSquares& operator=(LeastSquares&&) noexcept;
    ~LeastSquares();

    /// `smoothing` is the weight of the energy, without a unit: mean square residual + smoothing x
    /// area x energy is least. None: that of the powers of ten from 1e-12 to 1e-3 by which data
    /// left out are predicted best (generalised cross validation). Where neither data nor smoothing
    /// determine the spline, it is the polynomial nearest to the data that the energy does not
    /// penalise. Errors: `size_mismatch`, `non_finite_input` naming the point; InvalidArgument for
    /// smoothing that is negative or not a number; BadInput `singular_system` naming a vertex whose
    /// B-splines the data do not determine without smoothing, or "points" that lie on a line (or,
    /// for jumps, on a conic). Complexity: O(points + n^1.5) for given smoothing, ten to twelve
    /// times that for none, on two threads. The same bits for any number of threads.
    [[nodiscard]] Result<FittedSpline> fit(std::span<const double> values,
                                           std::optional<double> smoothing = {}) const;
    /// The same for several components, which get the same smoothing: where they are a surface in
    /// space, it does not depend on the directions of the axes.
    [[nodiscard]] Result<FittedSplines> fit(std::span<const std::span<const double>> components,
                                            std::optional<double> smoothing = {}) const;

    /// Values of a spline at the sites.
    void evaluate(std::span<const Heights> spline, std::span<double> out) const;

  private:
    struct State;
    explicit LeastSquares(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace relief::multires::ps
