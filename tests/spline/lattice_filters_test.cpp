#include "relief/spline/lattice_filters.h"

#include <limits>

#include "relief/core/parallel.h"
#include "relief/core/simd.h"
#include "relief/spline/box_surface.h"
#include "spline/spline_testing.h"

namespace relief::spline {
namespace {

constexpr std::pair<int, int> kBoxes[] = {{1, 1}, {1, 7},  {7, 1},  {2, 2},   {2, 5},
                                          {3, 3}, {9, 13}, {17, 4}, {64, 64}, {150, 600}};

template <class T>
class LatticeFilters : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(LatticeFilters, Scalars);

template <class T, class Filter>
Grid<T> apply(Filter filter, int order, const Grid<T>& in) {
    Grid<T> out(in.rows(), in.cols(), T(99));
    const Status status = filter(order, in.view(), out.view());
    EXPECT_TRUE(status.ok());
    return out;
}
template <class T>
Grid<T> sample(int order, const Grid<T>& c) {
    return apply(sample_lattice<T>, order, c);
}
template <class T>
Grid<T> adjoint(int order, const Grid<T>& r) {
    return apply(sample_lattice_adjoint<T>, order, r);
}
template <class T>
Grid<T> interpolate(int order, const Grid<T>& f) {
    return apply(interpolate_lattice<T>, order, f);
}
template <class T>
Grid<T> quasi(int order, const Grid<T>& f) {
    return apply(quasi_interpolate<T>, order, f);
}
template <class T>
Grid<T> gram(int order, const Grid<T>& c) {
    return apply(gram_apply<T>, order, c);
}

double dot(const Grid<double>& a, const Grid<double>& b) {
    double sum = 0;
    for (std::int64_t r = 0; r < a.rows(); ++r)
        for (std::int64_t c = 0; c < a.cols(); ++c) sum += a(r, c) * b(r, c);
    return sum;
}

TYPED_TEST(LatticeFilters, SamplesAreTheSurfaceAtTheLatticePoints) {
    using T = TypeParam;
    for (int d = 1; d <= kMaxOrder; ++d) {
        for (const auto& [rows, cols] : kBoxes) {
            const Grid<T> c = noise<T>(rows, cols, 1);
            const auto surface = BoxSurface<T>::create(c.view(), d);
            const Grid<T> expected = sampled<T>(
                rows, cols, [&](double i, double j) { return surface->jet(i, j).value; });
            // Two ways to sum at most 48 products of size 1.
            EXPECT_LE(largest_difference(sample(d, c), expected),
                      16 * std::numeric_limits<T>::epsilon());
        }
    }
}

TYPED_TEST(LatticeFilters, InterpolationReproducesTheSamples) {
    using T = TypeParam;
    const double eps = std::numeric_limits<T>::epsilon();
    for (int d = 1; d <= kMaxOrder; ++d) {
        for (const auto& [rows, cols] : kBoxes) {
            for (const unsigned seed : {1U, 2U}) {
                const Grid<T> f = noise<T>(rows, cols, seed);
                const Grid<T> c = interpolate(d, f);
                const double residual = largest_difference(sample(d, c), f);
                // Rounding c alone costs eps max |c|, up to 50 times the samples for order 4.
                EXPECT_LE(residual, 4 * eps * largest(c)) << d << ": " << rows << " x " << cols;
                if (d <= 3) {
                    EXPECT_LE(residual, (sizeof(T) == 8 ? 1e-14 : 1e-6) * largest(f));
                }
            }
        }
    }
}

TYPED_TEST(LatticeFilters, PlanesAreFixedUpToTheBorder) {
    using T = TypeParam;
    for (int d = 1; d <= kMaxOrder; ++d) {
        for (const auto& [rows, cols] : kBoxes) {
            // The border rule continues planes over as many rows as there are, less one, and
            // constants.
            if ((rows > 1 && rows < d) || (cols > 1 && cols < d)) continue;
            const Grid<T> plane =
                sampled<T>(rows, cols, [](double i, double j) { return 0.25 + i / 64 - j / 32; });
            const double tolerance = 200 * std::numeric_limits<T>::epsilon() * largest(plane);
            EXPECT_LE(largest_difference(sample(d, plane), plane), tolerance);
            EXPECT_LE(largest_difference(quasi(d, plane), plane), tolerance);
            EXPECT_LE(largest_difference(interpolate(d, plane), plane), tolerance);
        }
    }
}

TEST(LatticeFilter, AdjointIsTheTransposeIncludingTheBorder) {
    for (int d = 1; d <= kMaxOrder; ++d) {
        for (const auto& [rows, cols] : kBoxes) {
            const Grid<double> c = noise<double>(rows, cols, 1);
            const Grid<double> r = noise<double>(rows, cols, 2);
            const double scale = std::sqrt(dot(c, c) * dot(r, r));
            EXPECT_NEAR(dot(sample(d, c), r), dot(c, adjoint(d, r)), 1e-14 * scale)
                << rows << " x " << cols;
        }
    }
}

TEST(LatticeFilter, AdjointHasTheEntriesOfTheTransposedMatrix) {
    for (int d = 1; d <= kMaxOrder; ++d) {
        const std::int64_t rows = 3;
        const std::int64_t cols = 5;
        for (std::int64_t p = 0; p < rows * cols; ++p) {
            Grid<double> unit(rows, cols, 0.0);
            unit(p / cols, p % cols) = 1;
            const Grid<double> column = sample(d, unit);
            for (std::int64_t q = 0; q < rows * cols; ++q) {
                Grid<double> other(rows, cols, 0.0);
                other(q / cols, q % cols) = 1;
                EXPECT_NEAR(column(q / cols, q % cols), adjoint(d, other)(p / cols, p % cols),
                            1e-15);
            }
        }
    }
}

TEST(LatticeFilter, PeriodicSamplesGiveTheGoldenCoefficients) {
    const nlohmann::json data = golden()["prefilter_order2"];
    const std::int64_t copies = 9;
    const Grid<double> samples = tiled(data["samples"], copies);
    const Grid<double> coefficients = tiled(data["coefficients"], copies);
    const Grid<double> solved = interpolate(2, samples);
    const Grid<double> sampled_back = sample(2, coefficients);
    const std::int64_t period = samples.rows() / copies;
    // The border's influence has decayed below 1e-15 after four periods of eight.
    for (std::int64_t r = 4 * period; r < 5 * period; ++r) {
        for (std::int64_t c = 4 * period; c < 5 * period; ++c) {
            EXPECT_NEAR(solved(r, c), coefficients(r, c), 1e-12 * largest(coefficients));
            EXPECT_NEAR(sampled_back(r, c), samples(r, c), 1e-12 * largest(samples));
        }
    }
}

TEST(LatticeFilter, QuasiInterpolantOfOrderTwoIsTheSpecifiedStencil) {
    const Grid<double> f = noise<double>(9, 8, 3);
    const Grid<double> c = quasi(2, f);
    for (std::int64_t r = 1; r < 8; ++r)
        for (std::int64_t q = 1; q < 7; ++q)
            EXPECT_NEAR(c(r, q),
                        1.5 * f(r, q) - (f(r - 1, q) + f(r + 1, q) + f(r, q - 1) + f(r, q + 1) +
                                         f(r - 1, q - 1) + f(r + 1, q + 1)) /
                                            12,
                        1e-15);
}

TEST(LatticeFilter, QuasiInterpolantIsTheTruncatedNeumannSeriesAcrossTilesAndBorders) {
    for (int d = 1; d <= kMaxOrder; ++d) {
        const Grid<double> f = noise<double>(150, 1100, 3);
        Grid<double> c = f.clone();
        for (int m = 1; m < d; ++m) {
            const Grid<double> sampled_c = sample(d, c);
            for (std::int64_t r = 0; r < f.rows(); ++r)
                for (std::int64_t q = 0; q < f.cols(); ++q) c(r, q) += f(r, q) - sampled_c(r, q);
        }
        // Sums of up to 37 products of size 8.
        EXPECT_LE(largest_difference(quasi(d, f), c), 1e-14);
    }
}

TEST(LatticeFilter, QuasiInterpolationReproducesPolynomials) {
    for (int d = 1; d <= kMaxOrder; ++d) {
        for (int a = 0; a <= 2 * d - 1; ++a) {
            for (int b = 0; a + b <= 2 * d - 1; ++b) {
                const auto monomial = [&](double i, double j) {
                    return std::pow((i - 20) / 8, a) * std::pow((j - 20) / 8, b);
                };
                const Grid<double> c = quasi(d, sampled<double>(41, 41, monomial));
                const auto surface = BoxSurface<double>::create(c.view(), d);
                for (double i = 18; i < 22; i += 0.37)
                    for (double j = 18; j < 22; j += 0.41)
                        EXPECT_NEAR(surface->jet(i, j).value, monomial(i, j), 1e-13)
                            << d << " " << a << " " << b;
            }
        }
    }
}

TEST(LatticeFilter, GramIsThePositiveFormOfTheSurface) {
    for (int d = 1; d <= kMaxOrder; ++d) {
        Grid<double> unit(20, 21, 0.0);
        unit(9, 10) = 1;
        const Grid<double> column = gram(d, unit);
        for (const MaskTap& tap : box_spline(d).gram)
            EXPECT_EQ(column(9 + tap.i, 10 + tap.j), tap.weight);
        const Grid<double> c = noise<double>(7, 3, 5);
        const Grid<double> r = noise<double>(7, 3, 6);
        EXPECT_GT(dot(c, gram(d, c)), 0);
        EXPECT_NEAR(dot(c, gram(d, r)), dot(r, gram(d, c)), 1e-14);
    }
}

/// The measured table of the specification, section 9: largest errors for sin(2 pi x) cos(2 pi (y +
/// 0.2 sin 2 pi x)).
double wave_error(int d, int n, Grid<double> (*coefficients_of)(int, const Grid<double>&)) {
    const double turn = 2 * 3.14159265358979323846;
    const auto wave = [&](double i, double j) {
        const double x = i / n;
        const double y = j / n;
        return std::sin(turn * x) * std::cos(turn * (y + 0.2 * std::sin(turn * x)));
    };
    const Grid<double> c = coefficients_of(d, sampled<double>(4 * n, 4 * n, wave));
    const auto surface = BoxSurface<double>::create(c.view(), d);
    double error = 0;
    Grid<double> values(8 * n, 8 * n);
    surface->evaluate_grid(1.5 * n, 0.125, 1.5 * n, 0.125, values.view());
    for (std::int64_t r = 0; r < values.rows(); ++r)
        for (std::int64_t q = 0; q < values.cols(); ++q)
            error = std::max(
                error, std::abs(values(r, q) - wave(1.5 * n + 0.125 * r, 1.5 * n + 0.125 * q)));
    return error;
}

TEST(LatticeFilter, OrderTwoErrorsAreThoseOfTheSpecification) {
    const auto copy = [](int, const Grid<double>& f) { return f.clone(); };
    const int sizes[] = {16, 32, 64};
    const double samples[] = {8.0e-2, 2.2e-2, 5.6e-3};
    const double local[] = {2.1e-2, 1.6e-3, 1.1e-4};
    const double interpolant[] = {3.6e-3, 1.6e-4, 9.1e-6};
    for (int k = 0; k < 3; ++k) {
        // Two printed digits.
        EXPECT_NEAR(wave_error(2, sizes[k], copy), samples[k], 0.05 * samples[k]);
        EXPECT_NEAR(wave_error(2, sizes[k], quasi<double>), local[k], 0.05 * local[k]);
        EXPECT_NEAR(wave_error(2, sizes[k], interpolate<double>), interpolant[k],
                    0.05 * interpolant[k]);
    }
}

TEST(LatticeFilter, ErrorsFallWithTwiceTheOrder) {
    for (int d = 1; d <= kMaxOrder; ++d) {
        const double rate =
            std::log2(wave_error(d, 48, quasi<double>) / wave_error(d, 96, quasi<double>));
        const double exact_rate = std::log2(wave_error(d, 48, interpolate<double>) /
                                            wave_error(d, 96, interpolate<double>));
        // The interpolant approaches 2d from above, the quasi-interpolant from below.
        EXPECT_NEAR(rate, 2 * d, 0.5) << d;
        EXPECT_NEAR(exact_rate, 2 * d, 0.5) << d;
    }
}

TYPED_TEST(LatticeFilters, BytesDoNotDependOnThreadsOrInstructions) {
    using T = TypeParam;
    for (int d = 2; d <= kMaxOrder; ++d) {
        const Grid<T> f = noise<T>(200, 700, 4);
        for (const auto filter : {sample<T>, adjoint<T>, interpolate<T>, quasi<T>, gram<T>}) {
            set_thread_count(1);
            const Grid<T> expected = filter(d, f);
            set_thread_count(2);
            EXPECT_TRUE(same_bytes(filter(d, f), expected));
            set_simd_enabled(false);
            EXPECT_TRUE(same_bytes(filter(d, f), expected));
            set_simd_enabled(true);
            set_thread_count(0);
        }
    }
}

TEST(LatticeFilter, FiltersCommuteWithPointReflection) {
    EXPECT_TRUE(rc::check([] {
        const int d = *rc::gen::inRange(1, kMaxOrder + 1);
        const auto rows = *rc::gen::inRange<std::int64_t>(1, 40);
        const auto cols = *rc::gen::inRange<std::int64_t>(1, 40);
        const Grid<double> f = noise<double>(rows, cols, *rc::gen::arbitrary<unsigned>());
        const auto turned = [&](const Grid<double>& g) {
            return sampled<double>(rows, cols, [&](double i, double j) {
                return g(rows - 1 - static_cast<std::int64_t>(i),
                         cols - 1 - static_cast<std::int64_t>(j));
            });
        };
        for (const auto filter :
             {sample<double>, adjoint<double>, interpolate<double>, quasi<double>}) {
            const Grid<double> out = filter(d, f);
            RC_ASSERT(largest_difference(turned(filter(d, turned(f))), out) <=
                      1e-12 * (1 + largest(out)));
        }
    }));
}

TEST(LatticeFilter, WrongCallsAreRefused) {
    Grid<double> a(3, 4, 0.0);
    Grid<double> b(4, 3, 0.0);
    Grid<double> empty;
    EXPECT_EQ(sample_lattice<double>(5, a.view(), a.view()).error().code,
              ErrorCode::InvalidArgument);
    EXPECT_EQ(interpolate_lattice<double>(0, a.view(), a.view()).error().code,
              ErrorCode::InvalidArgument);
    EXPECT_EQ(gram_apply<double>(2, a.view(), b.view()).error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(quasi_interpolate<double>(2, empty.view(), empty.view()).error().code,
              ErrorCode::BadInput);
}

}  // namespace
}  // namespace relief::spline
