#include "relief/codec/raster_codec.h"
#include "support.h"

/// Scheme fvs in files: the coarsest level has derivatives that finer ones have not, so that bands
/// and their parents are not numbered alike.
namespace relief::codec {
namespace {

Raster landscape(std::int64_t rows, std::int64_t cols) {
    Raster raster;
    raster.rows = rows;
    raster.cols = cols;
    raster.type = SampleType::Float64;
    test::Noise noise(7);
    Grid<double> plane(rows, cols);
    for (std::int64_t r = 0; r < rows; ++r)
        for (std::int64_t c = 0; c < cols; ++c)
            plane(r, c) =
                50 * std::sin(0.1 * double(r)) * std::cos(0.07 * double(c)) + 0.5 * noise();
    raster.planes.push_back(std::move(plane));
    return raster;
}

TEST(FvsPyramid, FilesMeetTheirGoal) {
    for (const auto& [rows, cols] :
         {std::pair<std::int64_t, std::int64_t>{60, 83}, {3, 20}, {1, 40}}) {
        const Raster raster = landscape(rows, cols);
        multires::SchemeSpec spec;
        spec.id = multires::SchemeId::Fvs;
        EncodeOptions options;
        options.spec = spec;
        options.goal = {Goal::Kind::RmsError, 0.3};
        const auto file = encode_raster(raster, options);
        ASSERT_TRUE(file.ok()) << file.error().text();
        const auto opened = RasterFile::open(file->bytes);
        ASSERT_TRUE(opened.ok());
        const auto decoded = opened->decode(0);
        ASSERT_TRUE(decoded.ok());
        double squares = 0;
        for (std::int64_t r = 0; r < rows; ++r)
            for (std::int64_t c = 0; c < cols; ++c) {
                const double e = decoded->planes[0](r, c) - raster.planes[0](r, c);
                squares += e * e;
            }
        EXPECT_LE(std::sqrt(squares / double(rows * cols)), 0.3);
        EXPECT_EQ(opened->decode(1)->rows, (rows + 1) / 2);
    }
}

}  // namespace
}  // namespace relief::codec
