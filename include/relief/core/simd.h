#pragma once

#include <string>

namespace relief {

/// Chooses between the vector kernels (default) and their scalar twins, process wide. Both give the
/// same bytes; the tests compare them.
void set_simd_enabled(bool enabled);
[[nodiscard]] bool simd_enabled();

/// The instruction set that the vector kernels run on here, such as "AVX3" or "AVX2"; "scalar" when
/// disabled.
[[nodiscard]] std::string simd_target();

}  // namespace relief
