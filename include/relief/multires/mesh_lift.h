#pragma once

#include <array>
#include <memory>
#include <string_view>
#include <vector>

#include "relief/multires/mesh_step.h"

/// Lifting: coarse vertices take over what the details of the plain reversal say about them.
/// Source: reverse-subdivision.md section 7.
namespace relief::multires {

enum class LiftKind : std::uint8_t {
    None,          ///< the plain reversal, which amplifies noise at every level
    Ring,          ///< one local step of each vertex for itself: the source paper's
    Chebyshev,     ///< some sweeps towards least squares
    LeastSquares,  ///< the coarse mesh whose subdivision is nearest
};
inline constexpr std::array<LiftKind, 4> kLiftKinds = {LiftKind::None, LiftKind::Ring,
                                                       LiftKind::Chebyshev, LiftKind::LeastSquares};

/// "none", "ring", "chebyshev", "least-squares".
[[nodiscard]] const char* lift_name(LiftKind kind);
/// Errors: InvalidArgument listing the names.
[[nodiscard]] Result<LiftKind> lift_from_name(std::string_view name);

struct LiftOptions {
    LiftKind kind = LiftKind::Chebyshev;
    int sweeps = 0;     ///< Chebyshev: from 1 on
    double lowest = 0;  ///< Chebyshev: of the spectrum, in (0, 1)

    friend bool operator==(const LiftOptions&, const LiftOptions&) = default;
};
/// sqrt(3) 4 sweeps from 1/8, Loop 6 from 1/8, Catmull-Clark 12 from 1/16; twice as many at each
/// coarser level, at most 64. level: 0 for the finest.
[[nodiscard]] LiftOptions default_lift(MeshScheme scheme, int level);

/// c_lifted = c + L d for a linear map L of the details alone, so that the reverse is exact.
/// Boundaries and creases are fitted first and to their own curve only, so that they do not depend
/// on what lies beside them; corners stay.
class MeshLift {
  public:
    /// `step` must outlive this. Errors: InvalidArgument `invalid_parameter` for sweeps and lowest.
    /// Complexity: O(n).
    [[nodiscard]] static Result<MeshLift> create(const MeshStep<double>& step,
                                                 const LiftOptions& options);
    MeshLift(MeshLift&&) noexcept;
    MeshLift& operator=(MeshLift&&) noexcept;
    ~MeshLift();

    /// out = L d. residuals: those of stiff vertices. Complexity: O(n) a sweep.
    void apply(const Vec3<double>* details, const Vec3<double>* residuals, Vec3<double>* out) const;

  private:
    struct State;
    explicit MeshLift(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace relief::multires
