#include "relief/codec/mask_coder.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

namespace relief::codec {
namespace {

using Mask = Grid<std::uint8_t>;

void expect_round_trip(const Mask& mask) {
    const auto bytes = encode_mask(mask.view());
    Mask decoded(mask.rows(), mask.cols(), 7);
    ASSERT_TRUE(decode_mask(bytes, decoded.view()).ok());
    for (std::int64_t r = 0; r < mask.rows(); ++r)
        for (std::int64_t c = 0; c < mask.cols(); ++c) ASSERT_EQ(decoded(r, c), mask(r, c) != 0);
}

/// Valid inside an ellipse, with holes.
Mask island(std::int64_t rows, std::int64_t cols) {
    Mask mask(rows, cols);
    for (std::int64_t r = 0; r < rows; ++r)
        for (std::int64_t c = 0; c < cols; ++c) {
            const double y = 2.0 * static_cast<double>(r) / static_cast<double>(rows) - 1;
            const double x = 2.0 * static_cast<double>(c) / static_cast<double>(cols) - 1;
            mask(r, c) = x * x + y * y < 0.8 && (r / 9 * 5 + c / 13 * 3) % 17 != 0;
        }
    return mask;
}

TEST(MaskCoder, RoundTripsAnyImage) {
    EXPECT_TRUE(rc::check([] {
        std::mt19937 engine(*rc::gen::arbitrary<std::uint32_t>());
        const std::uint32_t density = *rc::gen::inRange(0U, 11U);
        Mask mask(*rc::gen::inRange(0, 60), *rc::gen::inRange(0, 60));
        for (std::int64_t r = 0; r < mask.rows(); ++r)
            for (std::int64_t c = 0; c < mask.cols(); ++c)
                mask(r, c) =
                    engine() % 10 < density ? static_cast<std::uint8_t>(1 + engine() % 255) : 0;
        expect_round_trip(mask);
    }));
}

TEST(MaskCoder, UniformImagesCostAFewBytes) {
    EXPECT_LE(encode_mask(Mask(1000, 1000, 1).view()).size(), 4U);
    EXPECT_LE(encode_mask(Mask(1000, 1000, 0).view()).size(), 8U);
    EXPECT_TRUE(encode_mask(Mask().view()).empty());
}

/// An outline of about 2700 pixels and 150 holes in 250000 pixels: codec-closed-loop.md section 5
/// measures 0.005 to 0.015 bits a pixel on real masks, which have fewer borders.
TEST(MaskCoder, BordersCostLittle) {
    const Mask mask = island(500, 500);
    expect_round_trip(mask);
    EXPECT_LT(8.0 * static_cast<double>(encode_mask(mask.view()).size()) / 250000, 0.05);
}

bool equal(const Mask& a, const Mask& b) {
    for (std::int64_t r = 0; r < a.rows(); ++r)
        if (!std::equal(a.row(r), a.row(r) + a.cols(), b.row(r))) return false;
    return true;
}

/// The last byte names any number in the last interval, so some of its bits may not matter.
TEST(MaskCoder, DamagedBytesNeverPassForTheWhole) {
    const Mask mask = island(40, 60);
    const auto bytes = encode_mask(mask.view());
    Mask decoded(40, 60);
    for (std::size_t n = 0; n < bytes.size(); ++n) {
        const Status status = decode_mask(std::span(bytes).first(n), decoded.view());
        EXPECT_FALSE(status.ok() && equal(mask, decoded)) << n;
    }
    for (std::size_t bit = 0; bit < 8 * (bytes.size() - 1); ++bit) {
        auto altered = bytes;
        altered[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
        const Status status = decode_mask(altered, decoded.view());
        EXPECT_FALSE(status.ok() && equal(mask, decoded)) << "bit " << bit;
    }
    auto longer = bytes;
    longer.resize(bytes.size() + 8, 1);
    EXPECT_FALSE(decode_mask(longer, decoded.view()).ok());
}

TEST(MaskCoder, GoldenStreamIsUnchanged) {
    std::ifstream file(RELIEF_TEST_DATA "/codec_streams.json");
    const nlohmann::json golden = nlohmann::json::parse(file);
    EXPECT_EQ(encode_mask(island(20, 30).view()), golden["mask"].get<std::vector<std::uint8_t>>());
}

}  // namespace
}  // namespace relief::codec
