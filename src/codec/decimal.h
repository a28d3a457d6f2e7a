#pragma once

/// Numbers with few decimal digits: short in a header. x is finite or infinite, digits 1 .. 17.
namespace relief::codec {

/// The nearest number of so many significant digits.
[[nodiscard]] double rounded(double x, int digits);

/// The least such number that is not below x >= 0.
[[nodiscard]] double rounded_up(double x, int digits);

/// The largest such number that is not above x >= 0.
[[nodiscard]] double rounded_down(double x, int digits);

}  // namespace relief::codec
