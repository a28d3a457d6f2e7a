#include "codec/embedded_quantiser.h"

#include <random>

#include "relief/core/parallel.h"

namespace relief::codec {
namespace {

template <class T>
struct Quantised {
    Grid<std::int32_t> q;
    Grid<std::uint8_t> worth;

    Quantised(const Grid<T>& c, double step) : q(c.rows(), c.cols()), worth(c.rows(), c.cols()) {
        quantise_band<T>(c.view(), step, q.view(), worth.view());
    }
};

Grid<double> row_of(const std::vector<double>& values) {
    Grid<double> grid(1, static_cast<std::int64_t>(values.size()));
    std::copy(values.begin(), values.end(), grid.row(0));
    return grid;
}

TEST(EmbeddedQuantiser, RoundsAtFiftyFiveHundredths) {
    const Grid<double> c = row_of({0, 0.54, 0.56, -0.56, 1.54, 1.56, -7.54, -7.56, 1e9, -1e300});
    const Quantised<double> quantised(c, 1);
    const std::int32_t q[] = {0, 0, 1, -1, 1, 2, -7, -8, 1000000000, -2147483647};
    for (std::int64_t k = 0; k < c.cols(); ++k) EXPECT_EQ(quantised.q(0, k), q[k]) << k;
    const Quantised<double> coarse(c, 4);
    EXPECT_EQ(coarse.q(0, 7), -2);
    EXPECT_EQ(coarse.q(0, 4), 0);
}

/// 64 (2 v - 1) rounded: what squared error grows by, v^2 - (v - 1)^2, when a 1 becomes 0.
TEST(EmbeddedQuantiser, TellsWhatOnesAreWorth) {
    const Quantised<double> quantised(row_of({0.3, 1.2, -2, 3, -4}), 2);
    const std::int32_t worth[] = {0, 13, 64, 128, 0};
    for (std::int64_t k = 0; k < 5; ++k) EXPECT_EQ(quantised.worth(0, k), worth[k]) << k;
}

TEST(EmbeddedQuantiser, ReconstructsTheMiddleOfWhatIsOpen) {
    Grid<std::int32_t> q(1, 5);
    const std::int32_t values[] = {0, 4, -4, 24, -40};
    std::copy_n(values, 5, q.row(0));
    const auto expect = [&](const KnownBits& known, const std::vector<double>& expected) {
        Grid<double> c(1, 5);
        reconstruct_band<double>(q.view(), known, 0.5, c.view());
        for (std::int64_t k = 0; k < 5; ++k)
            EXPECT_EQ(c(0, k), expected[static_cast<std::size_t>(k)]) << k;
    };
    expect({0, 3}, {0, 2, -2, 12, -20});
    expect({0, 2}, {0, 2, -2, 12, -20});
    // Pass 1 has not reached the last bits of values above 1.
    expect({0, 1}, {0, 2.5, -2.5, 12.5, -20.5});
    expect({2, 3}, {0, 3, -3, 13, -21});
    expect({2, 2}, {0, 3, -3, 13, -21});
    expect({2, 1}, {0, 3, -3, 14, -22});
}

/// Half a step, but for values that become 0.
TEST(EmbeddedQuantiser, ErrsByLittleMoreThanHalfAStep) {
    std::mt19937 engine(6);
    Grid<float> c(70, 33);
    for (std::int64_t r = 0; r < c.rows(); ++r)
        for (std::int64_t k = 0; k < c.cols(); ++k)
            c(r, k) = static_cast<float>(engine() % 100000) / 1000 - 50;
    const double step = 0.7;
    const Quantised<float> quantised(c, step);
    Grid<float> back(70, 33);
    reconstruct_band<float>(quantised.q.view(), {0, 3}, step, back.view());
    for (std::int64_t r = 0; r < c.rows(); ++r)
        for (std::int64_t k = 0; k < c.cols(); ++k)
            // 4e-6: half a unit in the last place of a float below 64, twice.
            ASSERT_LE(std::abs(back(r, k) - c(r, k)), 0.55 * step + 4e-6);
    set_thread_count(1);
    const Quantised<float> again(c, step);
    set_thread_count(0);
    for (std::int64_t r = 0; r < c.rows(); ++r) {
        EXPECT_TRUE(std::equal(again.q.row(r), again.q.row(r) + 33, quantised.q.row(r)));
        EXPECT_TRUE(
            std::equal(again.worth.row(r), again.worth.row(r) + 33, quantised.worth.row(r)));
    }
}

}  // namespace
}  // namespace relief::codec
