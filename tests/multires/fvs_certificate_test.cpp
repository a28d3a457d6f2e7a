#include "relief/multires/fvs_certificate.h"

#include "multires/fvs_support.h"
#include "relief/core/parallel.h"

namespace relief::multires::fvs {
namespace {

using spline::FvsSurface;
using spline::RasterPart;
using test::noise_grid;

/// The largest |difference| of the surfaces at 8 x 8 points a cell.
template <class T>
double sampled_difference(const Grid<T>& u, const Grid<T>& v) {
    Grid<double> difference(u.rows(), u.cols());
    for (std::int64_t r = 0; r < u.rows(); ++r)
        for (std::int64_t c = 0; c < u.cols(); ++c)
            difference(r, c) = double(u(r, c)) - double(v(r, c));
    Grid<double> samples(8 * u.rows() - 7, 8 * u.cols() - 7);
    EXPECT_TRUE(FvsSurface<double>::resample(RasterPart<double>::whole(difference.view()), 0, 0.125,
                                             0, 0.125, samples.view())
                    .ok());
    double largest = 0;
    for (std::int64_t r = 0; r < samples.rows(); ++r)
        for (std::int64_t c = 0; c < samples.cols(); ++c)
            largest = std::max(largest, std::abs(samples(r, c)));
    return largest;
}

template <class T>
Grid<T> zeros(const Grid<T>& like) {
    return Grid<T>(like.rows(), like.cols(), T(0));
}

TEST(FvsCertificate, IsAboveAndNearTheMaximum) {
    // Noise is rougher than any error; the ratios of section 8.1 for terrain are 1.42, 1.06, 1.02.
    const double ratios[] = {1.6, 1.12, 1.03};
    const Grid<float> u = noise_grid<float>(60, 300, 1);
    const Grid<float> v = noise_grid<float>(60, 300, 2);
    const double largest = sampled_difference(u, v);
    double last = INFINITY;
    for (int k = 0; k < 3; ++k) {
        const auto bound = certify<float>(u.view(), v.view(), k);
        ASSERT_TRUE(bound.ok());
        EXPECT_GE(*bound, largest);
        EXPECT_LE(*bound, ratios[k] * largest) << k;
        EXPECT_LE(*bound, last);
        last = *bound;
    }
}

TEST(FvsCertificate, SmoothSurfaces) {
    const double ratios[] = {1.109, 1.022, 1.007};  // section 8.1, of another error
    const Grid<double> u = hermite_grid(64, test::franke)[spline::kFvsF].clone();
    const double largest = sampled_difference(u, zeros(u));
    for (int k = 0; k < 3; ++k) {
        const auto bound = certify<double>(u.view(), zeros(u).view(), k);
        EXPECT_GE(*bound, largest);
        EXPECT_LE(*bound, ratios[k] * largest);
    }
}

TEST(FvsCertificate, ConstantsAreExact) {
    const Grid<double> u(9, 9, 5.25), v(9, 9, 5.0);
    EXPECT_NEAR(*certify<double>(u.view(), v.view(), 0), 0.25, 1e-12);
    EXPECT_GE(*certify<double>(u.view(), v.view(), 2), 0.25);
}

TEST(FvsCertificate, BandsOfRowsGiveTheSame) {
    const Grid<double> u = noise_grid<double>(75, 200, 3), v = zeros(u);
    const double whole = *certify<double>(u.view(), v.view(), 1);
    double largest = 0;
    for (std::int64_t row = 0; row < 74; row += 20) {
        const LatticeBox window = {row, 0, std::min<std::int64_t>(20, 74 - row) + 1, 200};
        const LatticeBox box = spline::needed_box(window, 75, 200);
        const auto part = [&](const Grid<double>& grid) {
            return RasterPart<double>{
                {grid.row(box.row0), box.rows, 200, grid.stride()}, box.row0, 0, 75, 200};
        };
        const auto bound = certify(part(u), part(v), window, 1);
        ASSERT_TRUE(bound.ok()) << bound.error().text();
        largest = std::max(largest, *bound);
    }
    EXPECT_EQ(largest, whole);
}

TEST(FvsCertificate, BoundsEveryCell) {
    const FvsGrid<double> grid = noisy_grid<double>(140, 20, 4, 0.5, 2);
    set_thread_count(3);
    const auto bounds = cell_bounds<double>(grid.view(), 2);
    set_thread_count(0);
    ASSERT_TRUE(bounds.ok());
    const auto coarse = cell_bounds<double>(grid.view(), 0);
    const auto surface = std::move(FvsSurface<double>::create(clone(grid))).value();
    double excess = 0;
    for (std::int64_t r = 0; r < 20; ++r)
        for (std::int64_t c = 0; c < 140; ++c) {
            double largest = 0;
            for (int p = 0; p <= 16; ++p)
                for (int q = 0; q <= 16; ++q)
                    largest = std::max(
                        largest,
                        std::abs(surface.jet(double(r) + p / 16.0, double(c) + q / 16.0).value));
            ASSERT_GE((*bounds)(r, c), largest * (1 - 1e-14));
            ASSERT_LE((*bounds)(r, c), (*coarse)(r, c) * (1 + 1e-14));
            excess = std::max(excess, (*bounds)(r, c) / largest);
        }
    EXPECT_LE(excess, 1.35);  // of the worst of 2800 cells of noise
}

TEST(FvsCertificate, WrongCallsAreRefused) {
    const Grid<double> u = noise_grid<double>(9, 9, 1), v = noise_grid<double>(9, 8, 1);
    Grid<double> hole = noise_grid<double>(9, 9, 1);
    hole(8, 0) = NAN;
    const auto code = [](const Grid<double>& a, const Grid<double>& b, int k) {
        return certify<double>(a.view(), b.view(), k).error().code;
    };
    EXPECT_EQ(code(u, v, 1), ErrorCode::InvalidArgument);
    EXPECT_EQ(code(u, u, 5), ErrorCode::InvalidArgument);
    EXPECT_EQ(code(u, hole, 1), ErrorCode::BadInput);
    EXPECT_EQ(code(hole, u, 0), ErrorCode::BadInput);
    const Grid<double> line = noise_grid<double>(1, 9, 1);
    EXPECT_EQ(code(line, line, 1), ErrorCode::InvalidArgument);
    RasterPart<double> part = RasterPart<double>::whole(u.view());
    part.rows = 20;
    EXPECT_EQ(certify(part, part, {0, 0, 9, 9}, 1).error().code, ErrorCode::InvalidArgument);
}

}  // namespace
}  // namespace relief::multires::fvs
