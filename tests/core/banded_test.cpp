#include "relief/core/banded.h"

#include <gtest/gtest.h>

#include "relief/core/vec3.h"
#include "support.h"

namespace relief {
namespace {

TEST(BandedCholesky, SolvesWhatItWasGiven) {
    for (const std::size_t width : {0U, 1U, 2U, 4U})
        for (const std::size_t size : {1U, 2U, 5U, 40U}) {
            test::Noise noise(static_cast<std::uint64_t>(size + width));
            BandedCholesky band(size, width);
            std::vector<std::vector<double>> full(size, std::vector<double>(size, 0));
            for (std::size_t i = 0; i < size; ++i)
                for (std::size_t j = i < width ? 0 : i - width; j <= i; ++j) {
                    const double value = i == j ? 3 + double(width) : noise();
                    band.add(j, i, value);
                    full[i][j] += value;
                    if (i != j) full[j][i] += value;
                }
            ASSERT_TRUE(band.factor());
            std::vector<double> wanted(size);
            for (double& x : wanted) x = noise();
            std::vector<Vec3<double>> x(size);
            for (std::size_t i = 0; i < size; ++i)
                for (std::size_t j = 0; j < size; ++j)
                    x[i] += full[i][j] * Vec3<double>{wanted[j], 2 * wanted[j], 0};
            band.solve(x.data());
            // Condition at most (3 + 2w) / 3 or so.
            for (std::size_t i = 0; i < size; ++i) {
                EXPECT_NEAR(x[i].x, wanted[i], 1e-13);
                EXPECT_NEAR(x[i].y, 2 * wanted[i], 1e-13);
            }
        }
}

TEST(BandedCholesky, RefusesWhatIsNotPositive) {
    BandedCholesky band(2, 1);
    band.add(0, 0, 1);
    band.add(1, 1, 1);
    band.add(0, 1, 1);
    EXPECT_FALSE(band.factor());
}

}  // namespace
}  // namespace relief
