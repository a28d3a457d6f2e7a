#pragma once

#include <array>
#include <cstdint>

/// Colour arithmetic: linear light for mixing, OKLab (Ottosson 2020) for ramps, sRGB for storage.
namespace relief::io::detail {

/// Linear-light sRGB primaries, 0 .. 1.
using Light = std::array<double, 3>;
using Srgb = std::array<std::uint8_t, 3>;

[[nodiscard]] double linear_of(std::uint8_t code);
/// Values outside 0 .. 1 are clipped.
[[nodiscard]] std::uint8_t code_of(double linear);
[[nodiscard]] inline Srgb srgb_of(const Light& c) {
    return {code_of(c[0]), code_of(c[1]), code_of(c[2])};
}
[[nodiscard]] inline Light light_of(const Srgb& c) {
    return {linear_of(c[0]), linear_of(c[1]), linear_of(c[2])};
}

/// The ramps behind height_colour and difference_colour, -1 .. 1 (clipped).
[[nodiscard]] const Light& height_light(double height);
[[nodiscard]] const Light& difference_light(double difference);

/// How a surface of colour `c` looks under sun and blue sky; `brightness` is that of
/// illumination(), `level` that of level ground, which keeps its colour.
[[nodiscard]] Light lit(const Light& c, double brightness, double level);

}  // namespace relief::io::detail
