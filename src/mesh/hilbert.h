#pragma once

#include <cstdint>

namespace relief::mesh {

/// How far along Hilbert's curve of 31 levels a cell of the square [0, 2^31)^2 lies.
inline std::uint64_t hilbert_distance(std::uint32_t x, std::uint32_t y) {
    // Of each state (the square as it is, transposed, turned by 180 degrees and both) and quadrant
    // 2 x + y: the quadrant's place on the curve + 4 x the state in it.
    static constexpr std::uint8_t kStep[4][4] = {{0 + 4 * 1, 1 + 4 * 0, 3 + 4 * 3, 2 + 4 * 0},
                                                 {0 + 4 * 0, 3 + 4 * 2, 1 + 4 * 1, 2 + 4 * 1},
                                                 {2 + 4 * 2, 3 + 4 * 1, 1 + 4 * 2, 0 + 4 * 3},
                                                 {2 + 4 * 3, 1 + 4 * 3, 3 + 4 * 0, 0 + 4 * 2}};
    std::uint64_t distance = 0;
    unsigned state = 0;
    for (int bit = 30; bit >= 0; --bit) {
        const unsigned quadrant = 2 * (x >> bit & 1) + (y >> bit & 1);
        const unsigned step = kStep[state][quadrant];
        distance = distance << 2 | (step & 3);
        state = step >> 2;
    }
    return distance;
}

}  // namespace relief::mesh
