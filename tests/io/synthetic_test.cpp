#include "relief/io/synthetic.h"

#include <cstring>

#include "relief/core/parallel.h"

namespace relief::io {
namespace {

constexpr std::uint64_t kRidged1 = 1120883593154322006U;
constexpr std::uint64_t kRidged2 = 9787116764230624343U;

double sample(const Raster& raster, std::int64_t row, std::int64_t col) {
    return raster.planes[0](row, col);
}

/// FNV-1a over the float32 samples, row by row.
std::uint64_t fingerprint(const Grid<double>& plane) {
    std::uint64_t hash = 14695981039346656037U;
    for (std::int64_t r = 0; r < plane.rows(); ++r) {
        for (std::int64_t c = 0; c < plane.cols(); ++c) {
            const auto value = static_cast<float>(plane(r, c));
            std::uint32_t bits = 0;
            std::memcpy(&bits, &value, sizeof bits);
            for (int k = 0; k < 4; ++k) hash = (hash ^ (bits >> 8 * k & 255U)) * 1099511628211U;
        }
    }
    return hash;
}

TEST(Synthetic, FrankeIsTheClosedForm) {
    const Raster raster = franke(91);
    // At (2/9, 2/9), (7/9, 3/9) and (4/9, 7/9) one term each is at its extreme; columns count x,
    // rows 1 - y.
    const auto closed = [](double x, double y) {
        return 0.75 * std::exp(-(std::pow(9 * x - 2, 2) + std::pow(9 * y - 2, 2)) / 4) +
               0.75 * std::exp(-std::pow(9 * x + 1, 2) / 49 - (9 * y + 1) / 10) +
               0.5 * std::exp(-(std::pow(9 * x - 7, 2) + std::pow(9 * y - 3, 2)) / 4) -
               0.2 * std::exp(-std::pow(9 * x - 4, 2) - std::pow(9 * y - 7, 2));
    };
    // Half a unit of float32 at values up to 1.3.
    for (std::int64_t r = 0; r < 91; r += 5)
        for (std::int64_t c = 0; c < 91; c += 5)
            EXPECT_NEAR(sample(raster, r, c),
                        closed(static_cast<double>(c) / 90, static_cast<double>(90 - r) / 90),
                        6.1e-8);
    EXPECT_NEAR(sample(raster, 70, 20),
                0.75 + 0.75 * std::exp(-9.0 / 49 - 0.3) + 0.5 * std::exp(-26.0 / 4), 1e-7);
}

TEST(Synthetic, BumpHasItsPeakAndItsSupport) {
    const Raster raster = bump(129);
    EXPECT_EQ(sample(raster, 64, 64), static_cast<double>(static_cast<float>(std::exp(-1.0))));
    const auto radius2 = [](std::int64_t r, std::int64_t c) {
        return (std::pow(static_cast<double>(r - 64), 2) +
                std::pow(static_cast<double>(c - 64), 2)) /
               (128.0 * 128.0);
    };
    for (std::int64_t r = 0; r < 129; ++r) {
        for (std::int64_t c = 0; c < 129; ++c) {
            const double rest = 1.0 / 128 - radius2(r, c);
            const double closed = rest > 0 ? std::exp(-1.0 / 128 / rest) : 0;
            EXPECT_NEAR(sample(raster, r, c), closed, 1.5e-8);  // half a unit of float32 below 0.5
            EXPECT_EQ(sample(raster, r, c), sample(raster, c, r));
        }
    }
}

TEST(Synthetic, RidgedIsTheSameEverywhere) {
    const Raster one = ridged(257, 1);
    EXPECT_EQ(fingerprint(one.planes[0]), kRidged1);
    EXPECT_EQ(fingerprint(ridged(257, 2).planes[0]), kRidged2);
    for (const int threads : {1, 3}) {
        set_thread_count(threads);
        EXPECT_EQ(fingerprint(ridged(257, 1).planes[0]), fingerprint(one.planes[0]));
    }
    set_thread_count(0);
}

TEST(Synthetic, RidgedLooksLikeMountains) {
    for (const std::uint32_t seed : {1U, 2U, 3U}) {
        const Raster raster = ridged(300, seed);
        double low = 1e9;
        double high = -1e9;
        double steep = 0;
        for (std::int64_t r = 1; r < 300; ++r) {
            for (std::int64_t c = 1; c < 300; ++c) {
                const double z = sample(raster, r, c);
                low = std::min(low, z);
                high = std::max(high, z);
                steep +=
                    std::hypot(z - sample(raster, r, c - 1), z - sample(raster, r - 1, c)) / 30;
            }
        }
        EXPECT_GT(low, 0);
        EXPECT_LT(high, 3500);
        EXPECT_GT(high - low, 700);
        const double mean_slope = steep / (299.0 * 299.0);
        EXPECT_GT(mean_slope, 0.3);
        EXPECT_LT(mean_slope, 1.2);
    }
}

TEST(Synthetic, TorusKeepsItsDistances) {
    const Raster raster = torus(33);
    ASSERT_EQ(raster.planes.size(), 3U);
    for (std::int64_t r = 0; r < 33; ++r) {
        for (std::int64_t c = 0; c < 66; ++c) {
            const double x = raster.planes[0](r, c);
            const double y = raster.planes[1](r, c);
            const double z = raster.planes[2](r, c);
            EXPECT_NEAR(std::hypot(std::hypot(x, y) - 1, z), 0.4,
                        2e-7);  // float32 at 1.4, squared and added
        }
        for (std::size_t p = 0; p < 3; ++p)
            EXPECT_NEAR(raster.planes[p](r, 0), raster.planes[p](r, 65), 1e-7);  // the seam closes
    }
}

TEST(Synthetic, FaceHasANoseAndHolesAroundTheHead) {
    const Raster raster = face(129);
    EXPECT_FALSE(raster.valid(0, 0));
    EXPECT_TRUE(raster.valid(64, 64));
    std::array<std::int64_t, 2> nose{};
    double depth = 0;
    for (std::int64_t r = 0; r < 129; ++r) {
        for (std::int64_t c = 0; c < 129; ++c) {
            EXPECT_EQ(raster.valid(r, c), std::isfinite(sample(raster, r, c)));
            if (raster.valid(r, c) && sample(raster, r, c) > depth) {
                depth = sample(raster, r, c);
                nose = {r, c};
            }
        }
    }
    EXPECT_EQ(nose[1], 64);
    EXPECT_NEAR(static_cast<double>(nose[0]), 69, 3);  // 1 cm below the middle, 2 mm a row
}

TEST(Synthetic, PointsLieWhereTheTransformSays) {
    const Raster raster = franke(5);
    EXPECT_EQ(raster.type, SampleType::Float32);
    EXPECT_EQ(raster.unit, "m");
    EXPECT_TRUE(raster.geo.pixel_is_point);
    const auto& t = *raster.geo.transform;
    EXPECT_EQ(t[0] + 0.5 * t[1], 0);
    EXPECT_EQ(t[3] + 0.5 * t[5], 1);
    EXPECT_EQ(t[0] + 4.5 * t[1], 1);
    EXPECT_EQ(t[3] + 4.5 * t[5], 0);
}

TEST(Synthetic, NamesAndErrors) {
    for (const std::string_view name : synthetic_names()) {
        const auto raster = synthetic(name, {.size = 16});
        ASSERT_TRUE(raster.ok()) << name;
        EXPECT_EQ(raster->rows, 16);
    }
    EXPECT_EQ(synthetic("moon").error().message,
              "no surface 'moon'; choose one of franke, bump, ridged, torus, face");
    EXPECT_EQ(synthetic("franke", {.size = 1}).error().message, "size 1 is not in 2 .. 65536");
}

}  // namespace
}  // namespace relief::io
