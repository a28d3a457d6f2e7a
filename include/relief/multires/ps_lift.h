#pragma once

#include <span>
#include <vector>

#include "relief/multires/ps_refine.h"

/// Multiresolution of Powell-Sabin splines by lifting: a spline of a fine space as one of the
/// coarse space and one triple of details for each vertex that the coarse mesh has not. Source:
/// powell-sabin.md section 13; docs/powell-sabin.md.
namespace relief::multires::ps {

/// How the coarse spline is chosen: it is the one that interpolates, plus U times the details. The
/// wavelet of a detail is its B-spline minus the coarse splines of its column of U.
enum class Update {
    None,          ///< U = 0: interpolation
    Moments,       ///< wavelets of mean zero and first moments zero, least U
    Semi,          ///< orthogonal to the coarse splines around them
    Semi2,         ///< the same with a ring more: nearly orthogonal
    Semi2Moments,  ///< the same, with moments zero: mean and volume are kept exactly
    Full,          ///< orthogonal to the whole coarse space: the coarse spline is the closest in L2
};

/// A base mesh and its triadic refinements. Level 0 is the coarsest.
class Hierarchy {
  public:
    /// Errors: those of `refine`, `level_out_of_range`. Complexity: O(size of the finest mesh),
    /// which grows by nine a level.
    [[nodiscard]] static Result<Hierarchy> create(Space base, int levels,
                                                  const RefineOptions& options = {});

    [[nodiscard]] int levels() const { return static_cast<int>(steps_.size()); }
    [[nodiscard]] const Space& space(int level) const {
        return level == 0 ? base_ : steps_[static_cast<std::size_t>(level) - 1].fine;
    }
    /// From `level` to level + 1.
    [[nodiscard]] const Refinement& step(int level) const {
        return steps_[static_cast<std::size_t>(level)];
    }

  private:
    explicit Hierarchy(Space base) : base_(std::move(base)) {}
    Space base_;
    std::vector<Refinement> steps_;
};

/// A spline of a refined space, taken apart. Details are those of vertices n, n + 1, .. of the fine
/// mesh, n being the number of coarse vertices; they have the unit of values.
struct Lifted {
    Coefficients coarse;
    Coefficients details;
};

/// One level. Errors: those of `check` for the numbers given; `singular_system` if triangles are so
/// thin that B-splines can not be told apart. Complexity: O(n), with about 10 microseconds a detail
/// triple for Semi2; Full O(n^1.5).
[[nodiscard]] Result<Lifted> analyse(const Space& coarse, const Refinement& step,
                                     std::span<const Heights> fine,
                                     Update update = Update::Semi2Moments);
/// The inverse up to rounding. Both add the same bits for the same details on every machine and for
/// any number of threads.
[[nodiscard]] Result<Coefficients> synthesise(const Space& coarse, const Refinement& step,
                                              const Lifted& lifted,
                                              Update update = Update::Semi2Moments);

/// All levels: details[l] leads from level l to l + 1.
struct Decomposition {
    Coefficients base;
    std::vector<Coefficients> details;
};
[[nodiscard]] Result<Decomposition> analyse(const Hierarchy& hierarchy, Coefficients finest,
                                            Update update = Update::Semi2Moments);
/// The spline of `level`. Errors: those of the levels; `level_out_of_range`.
[[nodiscard]] Result<Coefficients> synthesise(const Hierarchy& hierarchy,
                                              const Decomposition& decomposition, int level,
                                              Update update = Update::Semi2Moments);

/// What a detail of 1 adds to the spline, for each detail: the L2 norm of its wavelet, exact but
/// for Full, where it is that of Semi2, a few per cent too large; and a bound of its largest
/// value, 1 + sum |U|, which for Full is an estimate.
struct DetailNorms {
    Coefficients l2;
    Coefficients bound;
};
[[nodiscard]] Result<DetailNorms> detail_norms(const Space& coarse, const Refinement& step,
                                               Update update = Update::Semi2Moments);

}  // namespace relief::multires::ps
