#include "multires/box_support.h"

namespace relief::multires::box {
namespace {

/// Relative to the largest input; the reference vectors are good to 1e-12.
constexpr double kTolerance = 1e-12;

TEST(BoxGolden, Box) {
    const auto vectors = golden();
    for (const auto& entry : vectors["lifting_box"]) {
        const auto input = grid_of(entry["input"].get<Rows>());
        SCOPED_TRACE(std::to_string(input.rows()) + " x " + std::to_string(input.cols()));
        const double tolerance = kTolerance * largest(input);
        const int levels = entry["levels"];
        auto pyramid = analysed<double>(entry["d"], input, levels);
        EXPECT_LE(largest_difference(pyramid.bands[0][0], grid_of(entry["coarse"].get<Rows>())),
                  tolerance);
        for (int level = 1; level <= levels; ++level) {
            for (const auto& edge : entry["details"][std::size_t(level - 1)]["edges"]) {
                const std::int64_t i = edge[0];
                const std::int64_t j = edge[1];
                const int channel = i % 2 == 1 ? (j % 2 == 1 ? 3 : 1) : 2;
                EXPECT_NEAR(edge_band(pyramid, level, channel)(i / 2, j / 2), edge[2].get<double>(),
                            tolerance)
                    << "level " << level << " fine point " << i << ", " << j;
            }
        }
        EXPECT_LE(largest_difference(coefficients(pyramid, 0, 0), input), tolerance);

        auto coarse_only = empty_pyramid<double>(entry["d"], input.rows(), input.cols(), levels);
        coarse_only.bands[0][0] = pyramid.bands[0][0].clone();
        EXPECT_LE(largest_difference(coefficients(coarse_only, 0, 0),
                                     grid_of(entry["coarse_only_reconstruction"].get<Rows>())),
                  tolerance);
    }
}

/// The interior rules: in the middle of a box, periodic data have the coefficients of the torus.
TEST(BoxGolden, TorusInTheMiddleOfABox) {
    const auto vectors = golden();
    for (const auto& entry : vectors["lifting_torus"]) {
        const auto period = grid_of(entry["input"].get<Rows>());
        const auto tiled = grid_from<double>(129, 129, [&](std::int64_t i, std::int64_t j) {
            return period(i % period.rows(), j % period.cols());
        });
        const double tolerance = kTolerance * largest(period);
        auto pyramid = analysed<double>(entry["d"], tiled, entry["levels"]);
        const auto expect_period = [&](const Grid<double>& band, const Grid<double>& torus,
                                       const char* what) {
            const std::int64_t middle = band.rows() / 2 / torus.rows() * torus.rows();
            for (std::int64_t i = 0; i < torus.rows(); ++i)
                for (std::int64_t j = 0; j < torus.cols(); ++j)
                    EXPECT_NEAR(band(middle + i, middle + j), torus(i, j), tolerance) << what;
        };
        expect_period(pyramid.bands[0][0], grid_of(entry["coarse"].get<Rows>()), "scaling");
        for (int level = 1; level <= entry["levels"].get<int>(); ++level)
            for (const int channel : {1, 2, 3})
                expect_period(
                    edge_band(pyramid, level, channel),
                    grid_of(entry["details"][std::size_t(level - 1)][std::to_string(channel)]
                                .get<Rows>()),
                    "edges");
    }
}

}  // namespace
}  // namespace relief::multires::box
