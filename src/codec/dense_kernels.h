#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

/// The vector kernels of the dense profile. They have scalar twins that give the same bytes.
namespace relief::codec::dense {

/// Element k of a tap is weight * samples[2 k].
struct Tap {
    const std::int32_t* samples;
    double weight;
};

/// Elements behind the last that kernels may read from taps (twice as many samples) and write.
inline constexpr std::size_t kSlack = 16;

/// out[k] = sum of the taps in their order, for k < count.
void weighted_sum(std::span<const Tap> taps, std::size_t count, double* out);

/// One equation of a least squares problem in 16 unknowns.
inline constexpr std::size_t kUnknowns = 16;
struct Equation {
    std::array<double, kUnknowns> features;
    std::array<double, kUnknowns + 1> weighted;  ///< features and target, times the weight
};

/// Row i < 16: the matrix of the normal equations, element j of use for j <= i only; row 16: the
/// right-hand side.
using NormalEquations = std::array<std::array<double, kUnknowns>, kUnknowns + 1>;

/// normal[i][j] += weighted[i] features[j] for each equation in order.
void add_equations(std::span<const Equation> equations, NormalEquations& normal);

}  // namespace relief::codec::dense
