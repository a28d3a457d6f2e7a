#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "relief/io/image.h"

namespace relief::io::detail {

/// Draws text in a built-in 5 x 7 font, each of its dots `scale` pixels wide, from the top left
/// corner (row, col); what falls outside the image is cut. Characters the font lacks are left out.
void draw_text(Image& image, std::string_view text, int row, int col, int scale,
               const std::array<std::uint8_t, 3>& colour);

/// Pixels the text takes; its height is 7 scale.
[[nodiscard]] int text_width(std::string_view text, int scale);

}  // namespace relief::io::detail
