#pragma once

#include <optional>

#include "relief/multires/ps_energy.h"

namespace relief::multires::ps {

/// Solves with a Gram matrix by one sparse Cholesky factor. Nothing if it is singular.
[[nodiscard]] std::optional<Coefficients> solve(const BlockMatrix& gram, const Coefficients& right);

}  // namespace relief::multires::ps
