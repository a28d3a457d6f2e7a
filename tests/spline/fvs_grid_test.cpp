#include "relief/spline/fvs_grid.h"

#include <algorithm>
#include <cstring>

#include "relief/core/parallel.h"
#include "relief/core/simd.h"
#include "support.h"

namespace relief::spline {
namespace {

using test::grid_of;
using test::largest_difference;
using test::noise_grid;

template <class T>
FvsGrid<T> estimated(const Grid<T>& values, double a = 1, double b = 1) {
    const auto part = RasterPart<T>::whole(values.view());
    auto grid = estimate_fvs_grid<T>(part, {0, 0, values.rows(), values.cols()}, a, b);
    EXPECT_TRUE(grid.ok());
    return *std::move(grid);
}

template <class T>
bool same_bits(GridView<const T> a, GridView<const T> b) {
    if (a.rows != b.rows || a.cols != b.cols) return false;
    for (std::int64_t r = 0; r < a.rows; ++r)
        if (a.cols && std::memcmp(a.row(r), b.row(r), sizeof(T) * std::size_t(a.cols)) != 0)
            return false;
    return true;
}

TEST(FvsGrid, GoldenDerivatives) {
    const nlohmann::json data = test::reference("fvs_grid.json");
    const nlohmann::json& golden = data["derivative_estimation"];
    const auto grid = estimated(grid_of(golden["values"]), golden["a"], golden["b"]);
    const char* names[] = {"values", "FX", "FY", "GH", "GV"};
    // Derivatives reach 60; two orders of summation differ by some units of rounding.
    for (int p = 0; p < kFvsPlanes; ++p)
        EXPECT_LE(largest_difference(grid[p], grid_of(golden[names[p]])), 1e-13 * 60) << names[p];
}

/// Sides of 2, 3, 4 and 5 or more samples have rules of their own: lines, parabolas and cubics.
TEST(FvsGrid, ReproducesPolynomialsUpToTheBorder) {
    for (const std::int64_t n : {2, 3, 4, 5, 6, 9}) {
        const int degree = static_cast<int>(std::min<std::int64_t>(n - 1, 3));
        const auto value = [&](double y, double x) {
            return 1 + std::pow(x - 1.5, degree) * (2 + std::pow(y - 2.5, degree));
        };
        const double a = 0.5, b = 0.25;
        Grid<double> values(n, n);
        for (std::int64_t r = 0; r < n; ++r)
            for (std::int64_t c = 0; c < n; ++c) values(r, c) = value(b * double(r), a * double(c));
        const auto grid = estimated(values, a, b);
        const auto dx = [&](double y, double x) {
            return degree * std::pow(x - 1.5, degree - 1) * (2 + std::pow(y - 2.5, degree));
        };
        const auto dy = [&](double y, double x) {
            return std::pow(x - 1.5, degree) * degree * std::pow(y - 2.5, degree - 1);
        };
        for (std::int64_t r = 0; r < n; ++r)
            for (std::int64_t c = 0; c < n; ++c) {
                const double y = b * double(r), x = a * double(c);
                const double tolerance = 1e-11;  // numbers up to 400, differences over 12 * 0.25
                EXPECT_NEAR(grid[kFvsFx](r, c), dx(y, x), tolerance);
                EXPECT_NEAR(grid[kFvsFy](r, c), dy(y, x), tolerance);
                if (c + 1 < n) {
                    EXPECT_NEAR(grid[kFvsGh](r, c), dy(y, x + a / 2), tolerance);
                }
                if (r + 1 < n) {
                    EXPECT_NEAR(grid[kFvsGv](r, c), dx(y + b / 2, x), tolerance);
                }
            }
    }
}

TEST(FvsGrid, ConstantsHaveDerivativeExactlyZero) {
    const auto grid = estimated(Grid<float>(9, 11, 1234.567F));
    for (int p = kFvsFx; p < kFvsPlanes; ++p)
        EXPECT_EQ(largest_difference(grid[p], Grid<float>(grid[p].rows(), grid[p].cols(), 0)), 0);
}

TEST(FvsGrid, ASideOfOneSampleIsConstant) {
    const auto row = estimated(noise_grid<double>(1, 9, 1));
    EXPECT_EQ(largest_difference(row[kFvsFy], Grid<double>(1, 9, 0.0)), 0);
    EXPECT_EQ(largest_difference(row[kFvsGh], Grid<double>(1, 8, 0.0)), 0);
    EXPECT_EQ(row[kFvsGv].rows(), 0);
}

template <class T>
void expect_windows_are_crops(std::int64_t rows, std::int64_t cols) {
    const Grid<T> values = noise_grid<T>(rows, cols, 7);
    const auto whole = estimated(values);
    test::Noise noise(3);
    for (int trial = 0; trial < 60; ++trial) {
        const auto draw = [&](std::int64_t n) {
            return std::min(n - 1, static_cast<std::int64_t>((noise() + 1) / 2 * double(n)));
        };
        LatticeBox window = {draw(rows), draw(cols), 0, 0};
        window.rows = 1 + draw(rows - window.row0);
        window.cols = 1 + draw(cols - window.col0);
        const LatticeBox box = needed_box(window, rows, cols);
        // The samples alone: reading beyond them would read elsewhere.
        Grid<T> some(box.rows, box.cols);
        for (std::int64_t r = 0; r < box.rows; ++r)
            std::copy_n(values.row(box.row0 + r) + box.col0, box.cols, some.row(r));
        const RasterPart<T> part{std::as_const(some).view(), box.row0, box.col0, rows, cols};
        const auto grid = estimate_fvs_grid(part, window);
        ASSERT_TRUE(grid.ok()) << grid.error().text();
        for (int p = 0; p < kFvsPlanes; ++p) {
            const Grid<T>& plane = (*grid)[p];
            const GridView<const T> all = whole[p].view();
            EXPECT_TRUE(same_bits<T>(plane.view(), {all.row(window.row0) + window.col0,
                                                    plane.rows(), plane.cols(), all.stride}))
                << "plane " << p << ", window " << window.row0 << " " << window.col0 << " "
                << window.rows << " " << window.cols << " of " << rows << " x " << cols;
        }
    }
}

TEST(FvsGrid, WindowsAreCropsToTheBit) {
    expect_windows_are_crops<float>(40, 57);
    expect_windows_are_crops<double>(23, 31);
    expect_windows_are_crops<double>(5, 4);
    expect_windows_are_crops<double>(3, 6);
    expect_windows_are_crops<double>(2, 7);
}

TEST(FvsGrid, ThreadsAndInstructionsDoNotShow) {
    const Grid<float> values = noise_grid<float>(90, 1031, 5);
    const auto reference = estimated(values);
    set_simd_enabled(false);
    set_thread_count(3);
    const auto other = estimated(values);
    set_simd_enabled(true);
    set_thread_count(0);
    for (int p = 0; p < kFvsPlanes; ++p)
        EXPECT_TRUE(same_bits<float>(reference[p].view(), other[p].view()));
}

TEST(FvsGrid, WrongCallsAreRefused) {
    const Grid<double> values = noise_grid<double>(10, 10, 1);
    const auto whole = RasterPart<double>::whole(values.view());
    const auto code = [&](const RasterPart<double>& part, const LatticeBox& window, double a) {
        return estimate_fvs_grid(part, window, a).error().code;
    };
    EXPECT_EQ(code(whole, {0, 0, 10, 10}, 0), ErrorCode::InvalidArgument);
    EXPECT_EQ(code(whole, {0, 0, 0, 10}, 1), ErrorCode::InvalidArgument);
    EXPECT_EQ(code(whole, {1, 0, 10, 10}, 1), ErrorCode::InvalidArgument);
    RasterPart<double> part = whole;
    part.rows = 20;
    EXPECT_EQ(code(part, {0, 0, 9, 10}, 1), ErrorCode::InvalidArgument);
    EXPECT_TRUE(estimate_fvs_grid(part, {0, 0, 8, 10}).ok());
}

}  // namespace
}  // namespace relief::spline
