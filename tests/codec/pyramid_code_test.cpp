#include "codec/pyramid_code.h"

#include "relief/core/parallel.h"
#include "relief/multires/scheme.h"
#include "support.h"

/// Streams and layers of open-loop files.
namespace relief::codec {
namespace {

using multires::BandLayout;
using multires::Pyramid;
using multires::PyramidLayout;
using multires::SchemeId;
using multires::SchemeSpec;

Grid<double> terrain(std::int64_t rows, std::int64_t cols) {
    Grid<double> plane(rows, cols);
    test::Noise noise(3);
    for (std::int64_t r = 0; r < rows; ++r)
        for (std::int64_t c = 0; c < cols; ++c)
            plane(r, c) =
                700 + 90 * std::sin(0.03 * double(r)) * std::cos(0.05 * double(c)) + 4 * noise();
    return plane;
}

Pyramid<double> pyramid_of(const Grid<double>& plane, SchemeId id, int levels = -1) {
    return *multires::analyse<double>({plane.view()}, {.id = id, .levels = levels});
}

TEST(StreamLayout, HoldsEveryCoefficientOnceUnderItsParent) {
    for (const SchemeId id : {SchemeId::Cubic, SchemeId::Box, SchemeId::Barycentric})
        for (const auto& [rows, cols] : {std::pair<std::int64_t, std::int64_t>{1, 1},
                                         {5, 900},
                                         {767, 768},
                                         {1300, 2100},
                                         {5000, 4400}})
            for (const int levels : {-1, 0, 2}) {
                if (levels > 0 && std::min(rows, cols) < 8) continue;
                const PyramidLayout layout =
                    *multires::layout({.id = id, .levels = levels}, rows, cols, 1);
                const StreamLayout streams(layout);
                ASSERT_EQ(StreamLayout::count(layout), streams.streams());
                std::vector<Grid<std::uint8_t>> seen;
                for (const BandLayout& band : layout.bands)
                    seen.emplace_back(band.box.rows, band.box.cols, std::uint8_t{0});
                for (std::size_t s = 0; s < streams.streams(); ++s) {
                    for (const BandPart& part : streams.parts(s)) {
                        const LatticeBox& box = layout.bands[part.band].box;
                        for (std::int64_t r = 0; r < part.box.rows; ++r)
                            for (std::int64_t c = 0; c < part.box.cols; ++c)
                                ++seen[part.band](part.box.row0 - box.row0 + r,
                                                  part.box.col0 - box.col0 + c);
                    }
                    const auto parent = streams.parent(s);
                    EXPECT_EQ(parent.has_value(), streams.group_of(s) > 0);
                    if (!parent) continue;
                    // Samples of a tile lie in the tile above.
                    const LatticeBox inner = streams.samples(s);
                    const LatticeBox outer = streams.samples(*parent);
                    EXPECT_TRUE(outer.contains(inner.row0, inner.col0));
                    EXPECT_TRUE(
                        outer.contains(inner.row0 + inner.rows - 1, inner.col0 + inner.cols - 1));
                }
                for (const Grid<std::uint8_t>& band : seen)
                    for (std::int64_t r = 0; r < band.rows(); ++r)
                        for (std::int64_t c = 0; c < band.cols(); ++c) ASSERT_EQ(band(r, c), 1);
            }
}

TEST(StreamLayout, FindsStreamsByTheirCoefficients) {
    const PyramidLayout layout = *multires::layout({.id = SchemeId::Box}, 1300, 2100, 1);
    const StreamLayout streams(layout);
    for (std::size_t s = 0; s < streams.streams(); ++s)
        for (const BandPart& part : streams.parts(s)) {
            if (part.box.count() == 0) continue;
            const LatticeBox first{part.box.row0, part.box.col0, 1, 1};
            EXPECT_EQ(streams.meeting(streams.group_of(s), layout.bands[part.band].level, first),
                      std::vector<std::size_t>{s});
        }
}

TEST(PyramidCode, QuantisedValuesAreWithinTheDeadZone) {
    const Grid<double> plane = terrain(40, 55);
    const auto pyramid = pyramid_of(plane, SchemeId::Box, 3);
    const PyramidCoding coding{.step = 5, .means = {700}};
    auto back = Pyramid<double>::allocate(pyramid.layout);
    reconstruct(quantise(pyramid, coding), coding, 0, 0, back);
    for (std::size_t k = 0; k < pyramid.bands.size(); ++k)
        // The dead zone reaches to 0.55 steps; the mean costs a rounding.
        EXPECT_LE(test::largest_difference(pyramid.bands[k][0], back.bands[k][0]),
                  0.55 * coding.step_of(pyramid.layout, k) + 1e-12);
}

TEST(PyramidCode, FineStepsAreTwoToTheMinus24OfTheBand) {
    const Grid<double> plane = terrain(40, 40);
    const auto pyramid = pyramid_of(plane, SchemeId::Barycentric, 3);
    const PyramidCoding coding = fine_coding(pyramid, {0});
    auto back = Pyramid<double>::allocate(pyramid.layout);
    reconstruct(quantise(pyramid, coding), coding, 0, 0, back);
    for (std::size_t k = 0; k < pyramid.bands.size(); ++k)
        EXPECT_LE(test::largest_difference(pyramid.bands[k][0], back.bands[k][0]),
                  0.55 * std::ldexp(largest_magnitude(pyramid.bands[k][0], 0), -24));
}

TEST(PyramidCode, LeastStepLeavesThirtyBits) {
    const Grid<double> plane = terrain(40, 40);
    const auto pyramid = pyramid_of(plane, SchemeId::Cubic);
    const PyramidCoding coding{.step = least_step(pyramid, {0}), .means = {0}};
    QuantisedPyramid quantised = quantise(pyramid, coding);
    std::int32_t largest = 0;
    for (const auto& band : quantised.values)
        for (std::int64_t r = 0; r < band[0].rows(); ++r)
            for (std::int64_t c = 0; c < band[0].cols(); ++c)
                largest = std::max(largest, std::abs(band[0](r, c)));
    EXPECT_NEAR(largest, 0x1p29, 1);
    EXPECT_TRUE(encode_streams(pyramid.layout, StreamLayout(pyramid.layout), quantised).ok());
}

TEST(PyramidCode, LayersGrowAndEndWithPlaneZero) {
    const Grid<double> plane = terrain(300, 280);
    const auto pyramid = pyramid_of(plane, SchemeId::Cubic);
    const PyramidCoding coding{.step = 0.5, .means = {700}};
    const StreamLayout streams(pyramid.layout);
    std::vector<std::vector<Bytes>> runs;
    for (const int threads : {1, 3}) {
        set_thread_count(threads);
        QuantisedPyramid quantised = quantise(pyramid, coding);
        const auto coded = *encode_streams(pyramid.layout, streams, quantised);
        const std::vector<int> layers = choose_layers(coded);
        ASSERT_GE(layers.size(), 3U);
        EXPECT_EQ(layers.back(), 0);
        EXPECT_TRUE(std::is_sorted(layers.rbegin(), layers.rend()));
        runs.push_back(chunks_of(coded, layers));
        ASSERT_EQ(runs.back().size(), layers.size() * streams.streams());
        const ChunkOrder order{layers.size(), streams.streams()};
        std::size_t first = 0;  // of the first stream, which stands before all others
        std::size_t total = 0;  // of the others
        for (std::size_t k = 0; k < layers.size(); ++k) {
            EXPECT_EQ(order.place(k, 0), k);
            first += runs.back()[k].size();
            std::size_t layer = 0;
            for (std::size_t s = 1; s < streams.streams(); ++s)
                layer += runs.back()[order.place(k, s)].size();
            // A quarter more, but for the byte with the number of planes.
            EXPECT_GE(4 * (layer + streams.streams()), k == 0 ? 0 : total);
            total += layer;
        }
        EXPECT_EQ(order.end_of(layers.size() - 1) + 1, order.count());
        std::size_t coded_bytes = 0;
        for (const CodedStream& stream : coded) coded_bytes += stream[0].bytes.size() + 1;
        EXPECT_EQ(first + total, coded_bytes);
    }
    set_thread_count(0);
    EXPECT_EQ(runs[0], runs[1]);
}

}  // namespace
}  // namespace relief::codec
