#pragma once

#include <string>

#include "io/colour.h"
#include "relief/io/image.h"

namespace relief::io::detail {

/// Of text on white.
inline constexpr Srgb kInk = {60, 60, 64};

/// The smallest of 1, 2, 5 times a power of ten that is not below x; 1 unless x > 0.
[[nodiscard]] double round_scale(double x);

/// What the colours of the difference ramp mean.
struct Legend {
    double scale = 1;        ///< what its red end stands for
    std::string unit;        ///< behind the largest number
    bool from_zero = false;  ///< no blue arm
};

/// The picture on white with a bar below it that explains the colours.
[[nodiscard]] Image with_legend(const Image& picture, const Legend& legend);

}  // namespace relief::io::detail
