#include "relief/multires/fvs_grid_fit.h"

#include "multires/fvs_support.h"
#include "relief/core/parallel.h"

namespace relief::multires::fvs {
namespace {

using test::franke;

/// Largest and root mean square error against a function of the unit square at n x n points.
template <class Function>
std::pair<double, double> errors_of(const FvsGrid<double>& grid, Function f, int n) {
    const auto surface = std::move(spline::FvsSurface<double>::create(clone(grid))).value();
    double largest = 0, squares = 0;
    for (int r = 0; r < n; ++r)
        for (int c = 0; c < n; ++c) {
            const double y = r / double(n - 1), x = c / double(n - 1);
            const double e =
                surface.jet(y * double(grid.ny()), x * double(grid.nx())).value - f(x, y).value;
            largest = std::max(largest, std::abs(e));
            squares += e * e;
        }
    return {largest, std::sqrt(squares / (double(n) * n))};
}

Grid<double> franke_samples(std::int64_t n) {
    return hermite_grid(n - 1, franke)[spline::kFvsF].clone();
}

/// Section 7 of the specification, from 129 x 129 samples; its points are not given.
TEST(FvsGridFit, FrankeTable) {
    struct Row {
        int level;
        double max;
        double rms;
    };
    const Grid<double> values = franke_samples(129);
    for (const Row& row :
         {Row{4, 2.4e-3, 2.5e-4}, Row{3, 2.4e-4, 2.3e-5}, Row{2, 2.2e-5, 1.9e-6}}) {
        const auto grid = fit_fvs_grid<double>(values.view(), {}, row.level);
        ASSERT_TRUE(grid.ok()) << grid.error().text();
        const auto [largest, rms] = errors_of(*grid, franke, 201);
        EXPECT_NEAR(largest / row.max, 1, 0.15) << row.level;
        EXPECT_NEAR(rms / row.rms, 1, 0.1) << row.level;
        // Interpolation with exact derivatives on the same cells is worse.
        const auto [hermite_max, hermite_rms] =
            errors_of(hermite_grid(128 >> row.level, franke), franke, 201);
        EXPECT_GE(hermite_max, 2 * largest);
        EXPECT_GE(hermite_rms, 2 * rms);
    }
}

/// Splines of the space come back, also where the raster ends within a cell.
TEST(FvsGridFit, ReproducesItsSpace) {
    const FvsGrid<double> original = noisy_grid<double>(6, 5, 3, 4, 4);
    FvsGrid<double> copy = clone(original);
    const auto surface = std::move(spline::FvsSurface<double>::create(std::move(copy))).value();
    Grid<double> values(4 * 5 + 1, 4 * 6 - 1);  // ends in the middle of the last column of cells
    surface.evaluate_grid(0, 0.25, 0, 0.25, values.view());
    const auto grid = fit_fvs_grid<double>(values.view(), {}, 2);
    ASSERT_TRUE(grid.ok());
    const auto fitted = std::move(spline::FvsSurface<double>::create(clone(*grid))).value();
    Grid<double> back(values.rows(), values.cols());
    fitted.evaluate_grid(0, 0.25, 0, 0.25, back.view());
    EXPECT_LE(test::largest_difference(back, values),
              1e-6);  // half of the last column hardly counts
}

/// A hole does not change the fit far away and is filled smoothly: with a plane by that plane.
TEST(FvsGridFit, HolesAreContinued) {
    const std::int64_t n = 65;
    Grid<float> values(n, n);
    Grid<std::uint8_t> mask(n, n, std::uint8_t{1});
    for (std::int64_t r = 0; r < n; ++r)
        for (std::int64_t c = 0; c < n; ++c) {
            const bool hole = r > 20 && r < 40 && c > 30;
            values(r, c) = hole ? NAN : 3.0F + 0.5F * float(r) - 0.25F * float(c);
            mask(r, c) = hole ? 0 : 1;
        }
    const auto grid = fit_fvs_grid<float>(values.view(), std::as_const(mask).view(), 2);
    ASSERT_TRUE(grid.ok()) << grid.error().text();
    for (std::int64_t r = 0; r <= 16; ++r)
        for (std::int64_t c = 0; c <= 16; ++c) {
            const double expected = 3 + 0.5 * double(4 * r) - 0.25 * double(4 * c);
            EXPECT_NEAR((*grid)[spline::kFvsF](r, c), expected, 1e-6) << r << " " << c;
            EXPECT_NEAR((*grid)[spline::kFvsFy](r, c), 0.5, 1e-6);
        }
}

TEST(FvsGridFit, ThreadsDoNotShow) {
    const Grid<double> values = test::noise_grid<double>(120, 90, 4);
    const auto reference = fit_fvs_grid<double>(values.view(), {}, 1);
    set_thread_count(3);
    const auto other = fit_fvs_grid<double>(values.view(), {}, 1);
    set_thread_count(0);
    EXPECT_EQ(largest_difference(*reference, *other), 0);
}

TEST(FvsGridFit, WrongCallsAreRefused) {
    Grid<double> values = test::noise_grid<double>(9, 9, 1);
    const Grid<std::uint8_t> none(9, 9, std::uint8_t{0}), small(8, 9, std::uint8_t{1});
    const auto code = [&](GridView<const std::uint8_t> mask, int level) {
        return fit_fvs_grid<double>(std::as_const(values).view(), mask, level).error().code;
    };
    EXPECT_EQ(code({}, 0), ErrorCode::InvalidArgument);
    EXPECT_EQ(code({}, 4), ErrorCode::InvalidArgument);
    EXPECT_EQ(code(small.view(), 1), ErrorCode::InvalidArgument);
    EXPECT_EQ(code(none.view(), 1), ErrorCode::BadInput);
    values(3, 3) = NAN;
    EXPECT_EQ(code({}, 1), ErrorCode::BadInput);
}

}  // namespace
}  // namespace relief::multires::fvs
