#include "relief/multires/cubic_window.h"

#include "cubic_support.h"
#include "support.h"

namespace relief::multires::cubic {
namespace {

using test::noise_grid;

template <class T>
Grid<T> part(const Grid<T>& whole, const LatticeBox& box) {
    Grid<T> out(box.rows, box.cols);
    for (std::int64_t r = 0; r < box.rows; ++r)
        std::copy_n(whole.row(box.row0 + r) + box.col0, box.cols, out.row(r));
    return out;
}

/// Windows inside rows x cols: all of it, its corners, single values, strips, and random ones.
std::vector<LatticeBox> windows_of(std::int64_t rows, std::int64_t cols, std::uint64_t seed) {
    std::vector<LatticeBox> windows = {{0, 0, rows, cols},
                                       {0, 0, 1, 1},
                                       {rows - 1, cols - 1, 1, 1},
                                       {rows / 2, cols / 2, 1, 1},
                                       {rows / 3, 0, (rows + 2) / 3, cols},
                                       {0, cols / 2, rows, 1}};
    test::Noise noise(seed);
    const auto below = [&](std::int64_t n) {
        return static_cast<std::int64_t>((noise() + 1) / 2 * static_cast<double>(n));
    };
    for (int k = 0; k < 12; ++k) {
        const std::int64_t row0 = below(rows);
        const std::int64_t col0 = below(cols);
        windows.push_back({row0, col0, 1 + below(rows - row0), 1 + below(cols - col0)});
    }
    return windows;
}

struct Case {
    std::int64_t rows;
    std::int64_t cols;
    int levels;
};
constexpr Case kCases[] = {{1, 1, 0},   {1, 90, 3},  {61, 1, 2},   {2, 3, 2},     {9, 14, 2},
                           {40, 33, 3}, {77, 64, 4}, {130, 45, 2}, {201, 230, 3}, {7, 400, 1}};

template <class T>
class CubicWindows : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(CubicWindows, Scalars);

TYPED_TEST(CubicWindows, SynthesisHasTheBitsOfTheWhole) {
    using T = TypeParam;
    for (const auto& [rows, cols, levels] : kCases)
        for (const bool exact : {false, true}) {
            const auto pyramid = analysed(noise_grid<T>(rows, cols, 8), spec_of(levels, exact));
            for (int level = 0; level <= levels; ++level) {
                const auto whole = coefficients(pyramid, 0, level);
                for (const LatticeBox& window : windows_of(whole.rows(), whole.cols(), 3)) {
                    const auto needed = needed_boxes(pyramid.layout, level, window);
                    std::vector<Grid<T>> parts;
                    std::vector<GridView<const T>> views;
                    for (std::size_t k = 0; k < needed.size(); ++k)
                        parts.push_back(part(pyramid.bands[k][0], needed[k]));
                    for (const Grid<T>& grid : parts) views.push_back(grid.view());
                    const auto values = synthesise_window<T>(pyramid.layout, level, window, views);
                    ASSERT_TRUE(values.ok()) << values.error().text();
                    EXPECT_TRUE(same_bytes(*values, part(whole, window)))
                        << rows << " x " << cols << " level " << level << " window " << window.row0
                        << ' ' << window.col0 << ' ' << window.rows << ' ' << window.cols;
                }
            }
        }
}

TYPED_TEST(CubicWindows, AnalysisHasTheBitsOfTheWhole) {
    using T = TypeParam;
    for (const auto& [rows, cols, levels] : kCases)
        for (const bool exact : {false, true}) {
            const auto finest = noise_grid<T>(rows, cols, 9);
            for (int level = 1; level <= levels; ++level) {
                // Values of level - 1 are a scaling band, and so are those of `level`.
                const auto finer = analysed(finest, spec_of(level - 1, exact));
                const auto pyramid = analysed(finest, spec_of(level, exact));
                const LatticeBox& lattice = pyramid.layout.bands[0].box;
                for (const LatticeBox& window : windows_of(lattice.rows, lattice.cols, 5)) {
                    const auto boxes = analysis_boxes(pyramid.layout, level, window);
                    const auto values = part(finer.bands[0][0], boxes.finer);
                    const auto bands =
                        analyse_window<T>(pyramid.layout, level, window, values.view());
                    ASSERT_TRUE(bands.ok()) << bands.error().text();
                    for (std::size_t k = 0; k < 4; ++k)
                        EXPECT_TRUE(
                            same_bytes((*bands)[k], part(pyramid.bands[k][0], boxes.bands[k])))
                            << rows << " x " << cols << " level " << level << " band " << k;
                }
            }
        }
}

TEST(CubicWindow, NeedsAHaloOfTwelveALevel) {
    const auto bands = *layout(spec_of(2), 1000, 1000, 1);
    const auto boxes = needed_boxes(bands, 0, {400, 500, 100, 50});
    ASSERT_EQ(boxes.size(), 7U);
    // Pairs 200 .. 249 and 250 .. 274 of level 1, of level 2 those of rows 194 .. 255, columns 244
    // .. 280.
    EXPECT_EQ(boxes[4], (LatticeBox{194, 238, 62, 49})) << "odd-x of level 1";
    EXPECT_EQ(boxes[5], (LatticeBox{188, 244, 74, 37})) << "odd-y";
    EXPECT_EQ(boxes[6], (LatticeBox{188, 238, 74, 49})) << "odd-xy";
    EXPECT_EQ(boxes[0], (LatticeBox{91, 116, 43, 31})) << "scaling";
    EXPECT_EQ(boxes[3], (LatticeBox{85, 110, 55, 43})) << "odd-xy of level 2";
    EXPECT_EQ(needed_boxes(bands, 1, {3, 3, 5, 5})[6], (LatticeBox{0, 0, 0, 0})) << "finer";
    EXPECT_EQ(needed_boxes(bands, 1, {3, 3, 5, 5})[3], (LatticeBox{0, 0, 16, 16}))
        << "cut at the border";
    const auto analysis = analysis_boxes(bands, 1, {100, 0, 10, 500});
    EXPECT_EQ(analysis.finer, (LatticeBox{176, 0, 68, 1000}));
    EXPECT_EQ(analysis.bands[3], (LatticeBox{100, 0, 10, 500}));
}

TEST(CubicWindow, RefusesWhatDoesNotExist) {
    const auto bands = *layout(spec_of(2), 50, 60, 1);
    const std::vector<GridView<const float>> none(7);
    const auto code = [&](int level, const LatticeBox& window) {
        return synthesise_window<float>(bands, level, window, none).error().code;
    };
    EXPECT_EQ(code(3, {0, 0, 1, 1}), ErrorCode::InvalidArgument);
    EXPECT_EQ(code(-1, {0, 0, 1, 1}), ErrorCode::InvalidArgument);
    EXPECT_EQ(code(0, {0, 0, 0, 1}), ErrorCode::InvalidArgument);
    EXPECT_EQ(code(0, {0, 55, 1, 6}), ErrorCode::InvalidArgument);
    EXPECT_EQ(code(0, {-1, 0, 2, 2}), ErrorCode::InvalidArgument);
    EXPECT_EQ(code(0, {0, 0, 4, 4}), ErrorCode::InvalidArgument) << "bands of no size";
    EXPECT_EQ(code(0, {1, 1, INT64_MAX, INT64_MAX}), ErrorCode::InvalidArgument);
    EXPECT_FALSE(synthesise_window<float>(bands, 0, {0, 0, 1, 1}, {}).ok());
    EXPECT_FALSE(analyse_window<float>(bands, 0, {0, 0, 1, 1}, none[0]).ok());
    EXPECT_FALSE(analyse_window<float>(bands, 1, {0, 0, 1, 1}, none[0]).ok());
}

}  // namespace
}  // namespace relief::multires::cubic
