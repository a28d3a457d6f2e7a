#include "relief/spline/fvs_surface.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "franke.h"
#include "relief/core/parallel.h"
#include "relief/core/simd.h"
#include "relief/spline/fvs_cell.h"
#include "support.h"

namespace relief::spline {
namespace {

using test::franke;
using test::noise_grid;

template <class T>
FvsSurface<T> through(const Grid<T>& values) {
    return std::move(FvsSurface<T>::create(RasterPart<T>::whole(values.view()),
                                           {0, 0, values.rows(), values.cols()}))
        .value();
}

/// A cell with random numbers.
template <class T>
FvsGrid<T> noisy_grid(std::int64_t nx, std::int64_t ny, std::uint64_t seed) {
    FvsGrid<T> grid(nx, ny);
    for (int p = 0; p < kFvsPlanes; ++p)
        grid[p] = noise_grid<T>(grid[p].rows(), grid[p].cols(), seed + std::uint64_t(p));
    return grid;
}

template <class T>
std::vector<T> random_points(std::size_t count, double low, double high, std::uint64_t seed) {
    test::Noise noise(seed);
    std::vector<T> points(count);
    for (T& x : points) x = static_cast<T>(low + (noise() + 1) / 2 * (high - low));
    return points;
}

template <class T>
using Jets = std::array<std::vector<T>, 6>;

template <class T>
Jets<T> evaluate(const FvsSurface<T>& surface, const std::vector<T>& i, const std::vector<T>& j) {
    Jets<T> jets;
    for (auto& quantity : jets) quantity.resize(i.size());
    EXPECT_TRUE(
        surface.evaluate(i, j, 2, {jets[0], jets[1], jets[2], jets[3], jets[4], jets[5]}).ok());
    return jets;
}

/// The edges of the reference cell run 0-1, 1-2, 2-3, 0-3; their normals are the directions turned
/// by +90 degrees.
TEST(FvsSurface, GoldenCell) {
    const nlohmann::json data = test::reference("fvs_grid.json");
    const nlohmann::json& golden = data["unit_cell"];
    FvsGrid<double> grid(1, 1);
    const int row[] = {0, 0, 1, 1}, col[] = {0, 1, 1, 0};
    for (int k = 0; k < 4; ++k) {
        grid[kFvsF](row[k], col[k]) = golden["value"][k];
        grid[kFvsFx](row[k], col[k]) = golden["grad"][k][0];
        grid[kFvsFy](row[k], col[k]) = golden["grad"][k][1];
    }
    const auto gamma = golden["gamma"].get<std::vector<double>>();
    grid[kFvsGh](0, 0) = gamma[0];
    grid[kFvsGv](0, 1) = -gamma[1];
    grid[kFvsGh](1, 0) = -gamma[2];
    grid[kFvsGv](0, 0) = -gamma[3];
    Grid<double> bound(1, 1);
    fvs_ordinate_bounds<double>(std::as_const(grid).view(), bound.view());
    double largest = 0;
    for (const auto& net : golden["nets"])
        for (const double ordinate : net) largest = std::max(largest, std::abs(ordinate));
    EXPECT_NEAR(bound(0, 0), largest, 1e-14);

    const auto surface = std::move(FvsSurface<double>::create(std::move(grid))).value();
    for (const auto& point : golden["points"]) {
        const auto jet = surface.jet(point["x"][1], point["x"][0]);
        EXPECT_NEAR(jet.value, point["value"].get<double>(), 2e-13);
        EXPECT_NEAR(jet.dj, point["grad"][0].get<double>(), 4e-12);
        EXPECT_NEAR(jet.di, point["grad"][1].get<double>(), 4e-12);
        EXPECT_NEAR(jet.djj, point["hessian"][0][0].get<double>(), 1e-10);
        EXPECT_NEAR(jet.dij, point["hessian"][0][1].get<double>(), 1e-10);
        EXPECT_NEAR(jet.dii, point["hessian"][1][1].get<double>(), 1e-10);
    }
}

/// Errors at the points of a grid of 4 x 4 points a cell and more.
struct Errors {
    double max = 0;
    double rms = 0;
};

template <class Surface>
Errors franke_errors(const Surface& surface, std::int64_t n) {
    constexpr std::int64_t points = 401;
    const double step = 1 / double(points - 1);
    Errors errors;
    for (std::int64_t r = 0; r < points; ++r)
        for (std::int64_t c = 0; c < points; ++c) {
            const double y = double(r) * step, x = double(c) * step;
            const double e =
                surface.jet(y * double(n - 1), x * double(n - 1)).value - franke(x, y).value;
            errors.max = std::max(errors.max, std::abs(e));
            errors.rms += e * e;
        }
    errors.rms = std::sqrt(errors.rms / double(points * points));
    return errors;
}

/// The table of section 7 of the specification, two printed digits; its grid of points is not
/// given, which leaves 10 percent.
TEST(FvsSurface, FrankeTable) {
    struct Row {
        std::int64_t n;
        Errors estimated;
        Errors exact;
    };
    const Row table[] = {{33, {1.3e-4, 1.2e-5}, {4.9e-5, 4.3e-6}},
                         {65, {4.8e-6, 3.9e-7}, {3.2e-6, 2.7e-7}},
                         {129, {2.3e-7, 1.9e-8}, {2.0e-7, 1.7e-8}}};
    for (const Row& row : table) {
        const double h = 1 / double(row.n - 1);
        FvsGrid<double> exact(row.n - 1, row.n - 1, h, h);
        for (std::int64_t r = 0; r < row.n; ++r)
            for (std::int64_t c = 0; c < row.n; ++c) {
                const double x = double(c) * h, y = double(r) * h;
                const auto at = franke(x, y);
                exact[kFvsF](r, c) = at.value;
                exact[kFvsFx](r, c) = at.x;
                exact[kFvsFy](r, c) = at.y;
                if (c + 1 < row.n) exact[kFvsGh](r, c) = franke(x + h / 2, y).y;
                if (r + 1 < row.n) exact[kFvsGv](r, c) = franke(x, y + h / 2).x;
            }
        const Errors fd4 = franke_errors(through(exact[kFvsF]), row.n);
        EXPECT_NEAR(fd4.max / row.estimated.max, 1, 0.1) << row.n;
        EXPECT_NEAR(fd4.rms / row.estimated.rms, 1, 0.1) << row.n;
        const auto surface = std::move(FvsSurface<double>::create(std::move(exact))).value();
        const Errors hermite = franke_errors(surface, row.n);
        EXPECT_NEAR(hermite.max / row.exact.max, 1, 0.1) << row.n;
        EXPECT_NEAR(hermite.rms / row.exact.rms, 1, 0.1) << row.n;
    }
}

TEST(FvsSurface, ReproducesCubics) {
    const auto f = [](double i, double j) {
        return 1 + 0.1 * i * i * i - 0.2 * i * i * j + 0.3 * i * j * j - 0.05 * j * j * j + i - j;
    };
    Grid<double> values(7, 9);
    for (std::int64_t r = 0; r < 7; ++r)
        for (std::int64_t c = 0; c < 9; ++c) values(r, c) = f(double(r), double(c));
    const auto surface = through(values);
    for (double i = 0; i <= 6; i += 0.23)
        for (double j = 0; j <= 8; j += 0.31) {
            const auto jet = surface.jet(i, j);
            EXPECT_NEAR(jet.value, f(i, j), 1e-12);  // values up to 100
            EXPECT_NEAR(jet.di, 0.3 * i * i - 0.4 * i * j + 0.3 * j * j + 1, 1e-11);
            EXPECT_NEAR(jet.dj, -0.2 * i * i + 0.6 * i * j - 0.15 * j * j - 1, 1e-11);
            EXPECT_NEAR(jet.dii, 0.6 * i - 0.4 * j, 1e-10);
            EXPECT_NEAR(jet.dij, -0.4 * i + 0.6 * j, 1e-10);
            EXPECT_NEAR(jet.djj, 0.6 * i - 0.3 * j, 1e-10);
        }
}

TEST(FvsSurface, MeetsItsNodalData) {
    const FvsGrid<double> grid = noisy_grid<double>(5, 4, 3);
    FvsGrid<double> copy(5, 4);
    for (int p = 0; p < kFvsPlanes; ++p) copy[p] = grid[p].clone();
    const auto surface = std::move(FvsSurface<double>::create(std::move(copy))).value();
    for (std::int64_t r = 0; r < 5; ++r)
        for (std::int64_t c = 0; c < 6; ++c) {
            const auto jet = surface.jet(double(r), double(c));
            EXPECT_EQ(jet.value, grid[kFvsF](r, c));
            EXPECT_NEAR(jet.dj, grid[kFvsFx](r, c), 1e-14);
            EXPECT_NEAR(jet.di, grid[kFvsFy](r, c), 1e-14);
            if (c < 5) {
                EXPECT_NEAR(surface.jet(double(r), double(c) + 0.5).di, grid[kFvsGh](r, c), 1e-14);
            }
            if (r < 4) {
                EXPECT_NEAR(surface.jet(double(r) + 0.5, double(c)).dj, grid[kFvsGv](r, c), 1e-14);
            }
        }
}

/// Both sides of cell sides and of diagonals, from arbitrary nodal data.
TEST(FvsSurface, IsC1) {
    const auto surface =
        std::move(FvsSurface<double>::create(noisy_grid<double>(6, 6, 11))).value();
    const double e = 1e-9;  // jumps would be of order 1, slopes and curvatures are below 100
    const auto expect_smooth = [&](double i, double j, double di, double dj) {
        const auto a = surface.jet(i + e * di, j + e * dj);
        const auto b = surface.jet(i - e * di, j - e * dj);
        EXPECT_NEAR(a.value, b.value, 1e-7);
        EXPECT_NEAR(a.di, b.di, 1e-6);
        EXPECT_NEAR(a.dj, b.dj, 1e-6);
    };
    for (double t = 0.05; t < 6; t += 0.17) {
        for (int k = 1; k < 6; ++k) {
            expect_smooth(k, t, 1, 0);
            expect_smooth(t, k, 0, 1);
        }
        expect_smooth(t, t, 1, -1);
        expect_smooth(t, 6 - t, 1, 1);
    }
}

TEST(FvsSurface, SpacingScalesDerivativesOnly) {
    FvsGrid<double> grid = noisy_grid<double>(3, 2, 5);
    FvsGrid<double> wide(3, 2, 4, 0.5);
    for (int p = 0; p < kFvsPlanes; ++p) {
        wide[p] = grid[p].clone();
        const double factor = p == kFvsF ? 1 : p == kFvsFx || p == kFvsGv ? 0.25 : 2;
        for (std::int64_t r = 0; r < wide[p].rows(); ++r)
            for (std::int64_t c = 0; c < wide[p].cols(); ++c) wide[p](r, c) *= factor;
    }
    Grid<double> bounds(2, 3), wide_bounds(2, 3);
    fvs_ordinate_bounds<double>(std::as_const(grid).view(), bounds.view());
    fvs_ordinate_bounds<double>(std::as_const(wide).view(), wide_bounds.view());
    EXPECT_EQ(test::largest_difference(bounds, wide_bounds), 0);
    const auto a = std::move(FvsSurface<double>::create(std::move(grid))).value();
    const auto b = std::move(FvsSurface<double>::create(std::move(wide))).value();
    EXPECT_EQ(a.jet(1.3, 2.6).dij, b.jet(1.3, 2.6).dij);
}

template <class T>
void expect_same_bits(const std::vector<T>& a, const std::vector<T>& b) {
    ASSERT_EQ(a.size(), b.size());
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(T)), 0);
}

template <class T>
void expect_twins_agree() {
    const auto surface = through(noise_grid<T>(23, 37, 2));
    auto i = random_points<T>(5003, -1, 23, 5);
    auto j = random_points<T>(5003, -1, 37, 6);
    for (std::size_t k = 0; k < 200; ++k) i[k] = std::round(i[k]);  // ties
    for (std::size_t k = 100; k < 400; ++k) j[k] = std::round(j[k] * 2) / 2;
    const Jets<T> jets = evaluate(surface, i, j);
    set_simd_enabled(false);
    set_thread_count(3);
    const Jets<T> twins = evaluate(surface, i, j);
    set_simd_enabled(true);
    set_thread_count(0);
    for (std::size_t q = 0; q < 6; ++q) expect_same_bits(jets[q], twins[q]);
    for (std::size_t k = 0; k < i.size(); k += 7) {
        const auto jet = surface.jet(i[k], j[k]);
        EXPECT_EQ(jet.value, jets[0][k]);
        EXPECT_EQ(jet.dij, jets[4][k]);
    }
}

TEST(FvsSurface, AllWaysAgreeToTheBit) {
    expect_twins_agree<float>();
    expect_twins_agree<double>();
}

template <class T>
void expect_windows_agree() {
    const std::int64_t rows = 30, cols = 41;
    const Grid<T> values = noise_grid<T>(rows, cols, 4);
    const auto whole = through(values);
    for (const LatticeBox& window :
         {LatticeBox{0, 0, 5, 6}, LatticeBox{7, 9, 12, 13}, LatticeBox{20, 30, 10, 11},
          LatticeBox{29, 40, 1, 1}, LatticeBox{12, 0, 1, 41}, LatticeBox{3, 4, 2, 2}}) {
        const LatticeBox box = FvsSurface<T>::samples_for(window, rows, cols);
        Grid<T> some(box.rows, box.cols);
        for (std::int64_t r = 0; r < box.rows; ++r)
            std::copy_n(values.row(box.row0 + r) + box.col0, box.cols, some.row(r));
        const RasterPart<T> part{std::as_const(some).view(), box.row0, box.col0, rows, cols};
        const auto surface = FvsSurface<T>::create(part, window);
        ASSERT_TRUE(surface.ok()) << surface.error().text();
        EXPECT_EQ(surface->box(), window);
        const auto last = [](std::int64_t first, std::int64_t count) {
            return double(first + count - 1);
        };
        auto i = random_points<T>(500, double(window.row0), last(window.row0, window.rows), 8);
        auto j = random_points<T>(500, double(window.col0), last(window.col0, window.cols), 9);
        for (std::size_t k = 0; k < 100; ++k) {
            i[k] = T(k % 2 ? window.row0 : window.row0 + window.rows - 1);
            if (k % 3) j[k] = T(window.col0 + window.cols - 1);
        }
        const Jets<T> jets = evaluate(*surface, i, j);
        const Jets<T> expected = evaluate(whole, i, j);
        for (std::size_t q = 0; q < 6; ++q) expect_same_bits(jets[q], expected[q]);

        Grid<T> grid(2 * window.rows - 1, 4 * window.cols - 3), all(grid.rows(), grid.cols());
        surface->evaluate_grid(double(window.row0), 0.5, double(window.col0), 0.25, grid.view());
        whole.evaluate_grid(double(window.row0), 0.5, double(window.col0), 0.25, all.view());
        EXPECT_EQ(test::largest_difference(grid, all), 0);
    }
}

TEST(FvsSurface, WindowsEqualTheWholeToTheBit) {
    expect_windows_agree<float>();
    expect_windows_agree<double>();
}

TEST(FvsSurface, RegularGridsEqualPoints) {
    const auto surface = through(noise_grid<double>(20, 31, 6));
    for (const double step : {0.5, 0.25, 1.0, 1.5, 0.37, 1 / 3.0, 3.0, -0.5, 2.7}) {
        Grid<double> out(45, 64);
        const double i0 = step < 0 ? 19.5 : -0.5, j0 = step < 0 ? 31 : -0.25;
        surface.evaluate_grid(i0, step, j0, step, out.view());
        for (std::int64_t r = 0; r < out.rows(); ++r)
            for (std::int64_t c = 0; c < out.cols(); ++c)
                ASSERT_NEAR(out(r, c),
                            surface.jet(i0 + double(r) * step, j0 + double(c) * step).value, 1e-13)
                    << step << " " << r << " " << c;
    }
}

template <class T>
void expect_resampling_is_the_surface(double step) {
    const std::int64_t rows = 150, cols = 50;
    const Grid<T> values = noise_grid<T>(rows, cols, 12);
    const auto n = [&](std::int64_t side) {
        return static_cast<std::int64_t>(double(side + 1) / std::abs(step));
    };
    Grid<T> out(n(rows), n(cols)), expected(out.rows(), out.cols());
    const double i0 = step < 0 ? double(rows) : -1;
    through(values).evaluate_grid(i0, step, -1, std::abs(step), expected.view());
    const auto part = RasterPart<T>::whole(values.view());
    ASSERT_TRUE(FvsSurface<T>::resample(part, i0, step, -1, std::abs(step), out.view()).ok());
    EXPECT_EQ(test::largest_difference(out, expected), 0);
}

TEST(FvsSurface, ResamplingNeedsNoSurface) {
    for (const double step : {0.5, 0.125, 0.37, 1.0, 2.5, -0.5, -0.3}) {
        expect_resampling_is_the_surface<float>(step);
        expect_resampling_is_the_surface<double>(step);
    }
    const Grid<double> values = noise_grid<double>(30, 30, 1);
    Grid<double> out(9, 9);
    const LatticeBox box = resampling_box(10, 0.5, 9, 12, 0.5, 9, 30, 30);
    EXPECT_EQ(box, (LatticeBox{8, 10, 10, 10}));
    RasterPart<double> part{{values.row(8) + 10, 10, 10, values.stride()}, 8, 10, 30, 30};
    EXPECT_TRUE(FvsSurface<double>::resample(part, 10, 0.5, 12, 0.5, out.view()).ok());
    EXPECT_FALSE(FvsSurface<double>::resample(part, 11, 0.5, 12, 0.5, out.view()).ok());
}

TEST(FvsSurface, MassMatrix) {
    // The diagonal of the reference: vertex (value, dx, dy), then sides.
    const nlohmann::json data = test::reference("fvs_grid.json");
    const auto diagonal = data["l2_update"]["mass_coarse_diag"].get<std::vector<double>>();
    const auto& mass = fvs_cell_mass();
    for (std::size_t k = 0; k < 4; ++k) {
        EXPECT_NEAR(mass[k][k], diagonal[3 * k], 1e-15);
        EXPECT_NEAR(mass[4 + k][4 + k], diagonal[3 * k + 1], 1e-15);
        EXPECT_NEAR(mass[8 + k][8 + k], diagonal[3 * k + 2], 1e-15);
        EXPECT_NEAR(mass[12 + k][12 + k], diagonal[12 + k], 1e-15);
    }
    // 1 = sum of the four values' functions.
    double area = 0;
    for (std::size_t m = 0; m < 4; ++m)
        for (std::size_t n = 0; n < 4; ++n) area += mass[m][n];
    EXPECT_NEAR(area, 1, 1e-15);
}

TEST(FvsSurface, BoundsHold) {
    FvsGrid<float> grid = noisy_grid<float>(37, 5, 21);
    Grid<float> bounds(5, 37), twins(5, 37);
    fvs_ordinate_bounds<float>(std::as_const(grid).view(), bounds.view());
    set_simd_enabled(false);
    fvs_ordinate_bounds<float>(std::as_const(grid).view(), twins.view());
    set_simd_enabled(true);
    EXPECT_EQ(test::largest_difference(bounds, twins), 0);
    grid[kFvsGv](2, 36) = NAN;
    fvs_ordinate_bounds<float>(std::as_const(grid).view(), twins.view());
    EXPECT_TRUE(std::isnan(twins(2, 36)) && std::isnan(twins(2, 35)));
    EXPECT_EQ(twins(1, 36), bounds(1, 36));
    grid[kFvsGv](2, 36) = 0.5F;
    fvs_ordinate_bounds<float>(std::as_const(grid).view(), bounds.view());
    const auto surface = std::move(FvsSurface<float>::create(std::move(grid))).value();
    for (const float i : random_points<float>(100, 0, 5, 1))
        for (const float j : random_points<float>(100, 0, 37, 2))
            EXPECT_LE(std::abs(surface.jet(i, j).value),
                      bounds(std::int64_t(i), std::int64_t(j)) * (1 + 1e-6F));
}

TEST(FvsSurface, WrongCallsAreRefused) {
    const Grid<double> line = noise_grid<double>(1, 5, 1);
    EXPECT_EQ(FvsSurface<double>::create(RasterPart<double>::whole(line.view()), {0, 0, 1, 5})
                  .error()
                  .code,
              ErrorCode::BadInput);
    EXPECT_EQ(FvsSurface<double>::create(FvsGrid<double>(3, 0)).error().code, ErrorCode::BadInput);
    EXPECT_EQ(FvsSurface<double>::create(noisy_grid<double>(1, 1, 1), -1).error().code,
              ErrorCode::InvalidArgument);
    const auto surface = through(noise_grid<double>(4, 4, 1));
    std::vector<double> two(2), three(3);
    EXPECT_EQ(surface.evaluate(two, two, 3, {two}).error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(surface.evaluate(two, three, 0, {two}).error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(surface.evaluate(two, two, 1, {two}).error().code, ErrorCode::InvalidArgument);
    EXPECT_TRUE(surface.contains(3, 0));
    EXPECT_FALSE(surface.contains(3.01, 0));
    EXPECT_FALSE(surface.contains(std::nan(""), 0));
    EXPECT_EQ(surface.jet(std::nan(""), 9).value, surface.jet(0, 3).value);
}

}  // namespace
}  // namespace relief::spline
