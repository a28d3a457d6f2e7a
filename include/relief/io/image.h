#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace relief::io {

/// A picture of 8-bit sRGB samples; row 0 is the top.
struct Image {
    int width = 0;
    int height = 0;
    int channels = 3;  ///< 3: red, green, blue; 4: and alpha (0 transparent, not premultiplied)
    std::vector<std::uint8_t> pixels;  ///< height x width x channels

    Image() = default;
    Image(int w, int h, int c)
        : width(w),
          height(h),
          channels(c),
          pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) *
                 static_cast<std::size_t>(c)) {}

    [[nodiscard]] std::uint8_t* pixel(int row, int col) { return pixels.data() + offset(row, col); }
    [[nodiscard]] const std::uint8_t* pixel(int row, int col) const {
        return pixels.data() + offset(row, col);
    }

  private:
    [[nodiscard]] std::size_t offset(int row, int col) const {
        return (static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                static_cast<std::size_t>(col)) *
               static_cast<std::size_t>(channels);
    }
};

}  // namespace relief::io
