#include "codec/decimal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace relief::codec {
namespace {

TEST(Decimal, RoundsToNearestUpAndDown) {
    EXPECT_EQ(rounded(9.48345947265625, 4), 9.483);
    EXPECT_EQ(rounded_up(9.48345947265625, 4), 9.484);
    EXPECT_EQ(rounded_down(0.0031707279265873016, 6), 0.00317072);
    EXPECT_EQ(rounded_up(9.9999, 3), 10);
    EXPECT_EQ(rounded_down(9.9999, 3), 9.99);
    EXPECT_EQ(rounded_up(1e22, 3), 1e22);
    EXPECT_EQ(rounded(-797.5823, 5), -797.58);
    EXPECT_EQ(rounded_up(0, 4), 0);
    EXPECT_EQ(rounded_up(std::numeric_limits<double>::infinity(), 4),
              std::numeric_limits<double>::infinity());
}

/// Never on the wrong side, never off by as much as one in the last digit, and final.
TEST(Decimal, StaysOnItsSide) {
    std::mt19937 engine(1);
    std::uniform_real_distribution<double> exponent(-40, 40);
    for (int k = 0; k < 20000; ++k) {
        const double x = std::pow(10.0, exponent(engine));
        const int digits = 1 + k % 8;
        // One in the last digit, relative to the smallest mantissa; rounding of doubles besides.
        const double part = std::pow(10.0, 1 - digits) * (1 + 1e-9);
        const double up = rounded_up(x, digits);
        const double down = rounded_down(x, digits);
        ASSERT_GE(up, x);
        ASSERT_LE(up, x * (1 + part));
        ASSERT_LE(down, x);
        ASSERT_GE(down, x * (1 - part));
        ASSERT_EQ(rounded_up(up, digits), up);
        ASSERT_EQ(rounded_down(down, digits), down);
    }
}

}  // namespace
}  // namespace relief::codec
