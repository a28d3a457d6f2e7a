#include "codec/lattice_margin.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "relief/codec/raster_surface.h"

namespace relief::codec {
namespace {

/// Whole metres on every second row and column, from (first_row, first_col) on, and rounded means
/// in between.
Raster interpolated(std::int64_t rows, std::int64_t cols, std::int64_t first_row,
                    std::int64_t first_col) {
    std::mt19937 engine(7);
    const auto coarse = [&](std::int64_t i, std::int64_t j) {
        const auto x = static_cast<double>(i);
        const auto y = static_cast<double>(j);
        return std::rint(300 * std::sin(x / 9) * std::cos(y / 11) +
                         static_cast<double>(engine() % 30));
    };
    // The coarse grid has samples beyond all borders.
    Grid<double> known(rows / 2 + 2, cols / 2 + 2);
    for (std::int64_t i = 0; i < known.rows(); ++i)
        for (std::int64_t j = 0; j < known.cols(); ++j) known(i, j) = coarse(i, j);
    Raster raster;
    raster.rows = rows;
    raster.cols = cols;
    raster.type = SampleType::Int16;
    raster.geo.transform = {100, 10, 0, 2000, 0, -10};
    raster.planes.emplace_back(rows, cols);
    const auto across = [&](std::int64_t i, std::int64_t c) {
        const std::int64_t j = (c + first_col) / 2;
        return (c + first_col) % 2 == 0 ? known(i, j)
                                        : std::floor((known(i, j) + known(i, j + 1)) / 2);
    };
    for (std::int64_t r = 0; r < rows; ++r)
        for (std::int64_t c = 0; c < cols; ++c) {
            const std::int64_t i = (r + first_row) / 2;
            raster.planes[0](r, c) = (r + first_row) % 2 == 0
                                         ? across(i, c)
                                         : std::floor((across(i, c) + across(i + 1, c)) / 2);
        }
    return raster;
}

EncodedRaster encoded(const Raster& raster, const Goal& goal) {
    EncodeOptions options;
    options.goal = goal;
    options.spec = multires::SchemeSpec{.id = multires::SchemeId::Fvs};
    return *encode_raster(raster, options);
}

TEST(LatticeMargin, PutsCoarserSamplesOnTheLattice) {
    for (const std::int64_t row : {0, 1})
        for (const std::int64_t col : {0, 1}) {
            const Raster raster = interpolated(150, 171, row, col);
            const auto margin = choose_margin(MemoryRaster(raster));
            ASSERT_TRUE(margin.ok());
            EXPECT_EQ(*margin, (LatticeMargin{row, col}));
        }
}

TEST(LatticeMargin, IsNotThereWithoutReason) {
    const Raster small = interpolated(20, 20, 1, 1);
    EXPECT_EQ(*choose_margin(MemoryRaster(small)), LatticeMargin());
    Raster flat = interpolated(150, 171, 1, 1);
    for (std::int64_t r = 0; r < flat.rows; ++r)
        for (std::int64_t c = 0; c < flat.cols; ++c) flat.planes[0](r, c) = 7;
    EXPECT_EQ(*choose_margin(MemoryRaster(flat)), LatticeMargin());
    // Holes count for nothing.
    Raster holes = interpolated(150, 171, 1, 1);
    holes.mask = Grid<std::uint8_t>(150, 171, 0);
    EXPECT_EQ(*choose_margin(MemoryRaster(holes)), LatticeMargin());
}

TEST(LatticeMargin, WindowsRepeatTheFirstRowAndColumn) {
    const Raster raster = interpolated(9, 7, 1, 1);
    const MemoryRaster source(raster);
    const RasterWithMargin wide(source, {1, 1});
    EXPECT_EQ(wide.description().rows, 10);
    EXPECT_EQ(wide.description().cols, 8);
    for (const LatticeBox& box :
         {LatticeBox{0, 0, 10, 8}, {0, 3, 1, 2}, {4, 0, 3, 1}, {2, 2, 5, 5}}) {
        const auto part = wide.read(box);
        ASSERT_TRUE(part.ok());
        ASSERT_EQ(part->planes[0].rows(), box.rows);
        ASSERT_EQ(part->planes[0].cols(), box.cols);
        for (std::int64_t r = 0; r < box.rows; ++r)
            for (std::int64_t c = 0; c < box.cols; ++c)
                EXPECT_EQ(part->planes[0](r, c),
                          raster.planes[0](std::max<std::int64_t>(box.row0 + r - 1, 0),
                                           std::max<std::int64_t>(box.col0 + c - 1, 0)));
    }
}

/// All that a file says of places takes the margin into account.
TEST(LatticeMargin, LevelsWindowsAndSurfacesLieWhereTheyShould) {
    const Raster raster = interpolated(150, 171, 1, 1);
    const auto file = RasterFile::open(encoded(raster, {Goal::Kind::Lossless, 0}).bytes);
    ASSERT_TRUE(file.ok());
    EXPECT_EQ(file->margin(), (LatticeMargin{1, 1}));
    EXPECT_EQ(file->description().rows, 150);
    EXPECT_EQ(file->layout().rows, 151);
    const Raster whole = *file->decode(0);
    const Grid<double>& samples = raster.planes[0];
    for (std::int64_t r = 0; r < 150; ++r)
        for (std::int64_t c = 0; c < 171; ++c) ASSERT_EQ(whole.planes[0](r, c), samples(r, c));
    EXPECT_EQ(whole.geo, raster.geo);

    const auto window = file->decode_window(0, {30, 0, 20, 9});
    ASSERT_TRUE(window.ok());
    EXPECT_EQ(window->raster.planes[0](4, 5), samples(34, 5));
    EXPECT_EQ((*window->raster.geo.transform)[3], 2000 - 30 * 10);

    for (const int level : {1, 2}) {
        const std::int64_t step = std::int64_t{1} << level;
        const Raster coarse = *file->decode(level);
        ASSERT_EQ(coarse.rows, (151 + step - 1) / step);
        for (std::int64_t r = 1; r < coarse.rows; ++r)
            for (std::int64_t c = 1; c < coarse.cols; ++c)
                ASSERT_EQ(coarse.planes[0](r, c), samples(r * step - 1, c * step - 1));
        // The centre of sample (1, 1) is that of sample (step - 1, step - 1) of the raster.
        const auto& t = *coarse.geo.transform;
        EXPECT_EQ(t[0] + 1.5 * t[1], 100 + 10 * (static_cast<double>(step) - 0.5));
        EXPECT_EQ(t[3] + 1.5 * t[5], 2000 - 10 * (static_cast<double>(step) - 0.5));
    }

    const auto surface = RasterSurface::create(*file, 0, {10, 0, 40, 30});
    ASSERT_TRUE(surface.ok());
    Grid<double> grid(3, 4);
    surface->evaluate_grid(0, 12, 1, 0, 1, grid.view());
    for (std::int64_t r = 0; r < 3; ++r)
        for (std::int64_t c = 0; c < 4; ++c) EXPECT_EQ(grid(r, c), samples(12 + r, c));
    EXPECT_EQ((*file->control_net())[0](77, 3), samples(77, 3));
}

/// A grid that begins between the coarser samples costs no more than one that begins with them, but
/// for the two rows and columns more of 300 that it has: 3 per cent is room enough.
TEST(LatticeMargin, SavesBytes) {
    const Raster aligned = interpolated(300, 300, 0, 0);
    const Raster between = interpolated(300, 300, 1, 1);
    for (const Goal& goal : {Goal{Goal::Kind::Lossless, 0}, Goal{Goal::Kind::MaxError, 2}}) {
        const auto best = static_cast<double>(encoded(aligned, goal).bytes.size());
        EXPECT_LT(static_cast<double>(encoded(between, goal).bytes.size()), 1.03 * best);
    }
}

}  // namespace
}  // namespace relief::codec
