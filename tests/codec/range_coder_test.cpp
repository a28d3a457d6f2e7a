#include "codec/range_coder.h"

#include <random>

#include "codec/probability.h"

namespace relief::codec {
namespace {

struct Decision {
    bool bit;
    std::uint32_t one;
};

std::vector<Decision> draw_decisions(std::size_t count, std::uint32_t least, std::uint32_t most) {
    std::mt19937 engine(17);
    std::vector<Decision> decisions(count);
    for (Decision& d : decisions) {
        d.one = least + engine() % (most - least + 1);
        d.bit = engine() % 65536 < d.one;
    }
    return decisions;
}

TEST(RangeCoder, RoundTripsAtTheCostOfItsProbabilities) {
    const std::pair<std::uint32_t, std::uint32_t> ranges[] = {
        {1, 65535}, {1, 20}, {65500, 65535}, {32768, 32768}};
    for (const auto& [least, most] : ranges) {
        const auto decisions = draw_decisions(50000, least, most);
        RangeEncoder encoder;
        CostCounter counter;
        for (const Decision& d : decisions) {
            encoder.code(d.bit, d.one);
            counter.code(d.bit, d.one);
        }
        const auto bytes = encoder.finish();
        // Cutting a range of at least 2^32 at 16 bits loses under 2^-15 of it; the end costs up to
        // 5 bytes.
        EXPECT_NEAR(8.0 * static_cast<double>(bytes.size()), counter.bits(),
                    1e-4 * counter.bits() + 40);
        RangeDecoder decoder(bytes);
        for (const Decision& d : decisions) ASSERT_EQ(decoder.code(false, d.one), d.bit);
        EXPECT_TRUE(decoder.at_end());
    }
}

/// Unlikely zeros push the interval against its upper end, where carries travel through bytes of
/// 0xff.
TEST(RangeCoder, CarriesTravel) {
    EXPECT_TRUE(rc::check([] {
        const auto bits = *rc::gen::container<std::vector<bool>>(200, rc::gen::arbitrary<bool>());
        const auto one = *rc::gen::element(1U, 2U, 32767U, 65534U, 65535U);
        RangeEncoder encoder;
        for (const bool bit : bits) encoder.code(bit, one);
        const auto bytes = encoder.finish();
        RangeDecoder decoder(bytes);
        for (const bool bit : bits) RC_ASSERT(decoder.code(false, one) == bit);
        RC_ASSERT(decoder.at_end());
    }));
}

/// What was coded before a point decodes from the bytes up to it, whatever was coded afterwards.
TEST(RangeCoder, CutsDecodeUpToTheirPoint) {
    EXPECT_TRUE(rc::check([] {
        const auto bits = *rc::gen::container<std::vector<bool>>(150, rc::gen::arbitrary<bool>());
        const auto one = *rc::gen::element(1U, 300U, 32768U, 65000U, 65535U);
        RangeEncoder encoder;
        CostCounter counter;
        std::vector<CodePoint> points;
        std::vector<double> costs;
        for (const bool bit : bits) {
            encoder.code(bit, one);
            counter.code(bit, one);
            points.push_back(encoder.point());
            costs.push_back(counter.bits());
        }
        const auto bytes = encoder.finish();
        for (std::size_t n = 0; n < points.size(); ++n) {
            const std::size_t needed = bytes_up_to(bytes, points[n]);
            // The bytes written lag behind by up to 4; the rest of the 64 bits may be needed too.
            RC_ASSERT(8.0 * static_cast<double>(needed) <= costs[n] + 64);
            RangeDecoder decoder({bytes.data(), needed});
            for (std::size_t k = 0; k <= n; ++k) RC_ASSERT(decoder.code(false, one) == bits[k]);
        }
    }));
}

TEST(RangeCoder, RawBitsMixWithDecisions) {
    std::mt19937 engine(4);
    std::vector<std::pair<std::uint32_t, int>> values;
    RangeEncoder encoder;
    for (int k = 0; k < 5000; ++k) {
        const int count = 1 + static_cast<int>(engine() % 16);
        const auto value = static_cast<std::uint32_t>(engine() & ((1U << count) - 1));
        values.emplace_back(value, count);
        encoder.code_raw(value, count);
        encoder.code(value & 1, 60000);
    }
    const auto bytes = encoder.finish();
    RangeDecoder decoder(bytes);
    for (const auto& [value, count] : values) {
        ASSERT_EQ(decoder.code_raw(0, count), value);
        ASSERT_EQ(decoder.code(false, 60000), (value & 1) != 0);
    }
    EXPECT_TRUE(decoder.at_end());
}

TEST(Probability, TablesAreTheLogisticFunction) {
    for (std::int32_t odds = -kOddsLimit; odds <= kOddsLimit; ++odds) {
        const double p = 65536 / (1 + std::exp(-odds / 256.0));
        // Linear interpolation over steps of 1/4 is off by at most max |f''| / 128 = 0.00076, and
        // one for rounding.
        EXPECT_NEAR(kOdds.squash[static_cast<std::size_t>(odds + kOddsLimit)], p,
                    65536 * 0.00076 + 1);
    }
    for (std::size_t k = 1; k < 4096; ++k) EXPECT_GE(kOdds.stretch[k], kOdds.stretch[k - 1]);
    for (std::size_t k = 8; k < 4088; ++k) {
        const double p = (static_cast<double>(k) + 0.5) / 4096;
        EXPECT_NEAR(kOdds.stretch[k] / 256.0, std::log(p / (1 - p)), 0.02) << k;
    }
    for (const std::size_t n : {1, 10, 255})
        EXPECT_EQ(kOdds.rate[n],
                  static_cast<std::uint16_t>(65536 / (static_cast<double>(n) + 1.6)));
}

TEST(Probability, SlotsLearnAProbability) {
    std::mt19937 engine(2);
    Slot slot;
    double slow = 0;
    double fast = 0;
    for (int k = 0; k < 20000; ++k) {
        slot.update(engine() % 100 < 7);
        if (k < 10000) continue;
        slow += slot.slow / 4294967296.0 / 10000;
        fast += slot.fast / 65536.0 / 10000;
    }
    // Means over 10000 draws have a standard deviation of 0.0026; 16 bits round the fast one down
    // by up to 0.0005.
    EXPECT_NEAR(slow, 0.07, 0.009);
    EXPECT_NEAR(fast, 0.07, 0.009);
}

}  // namespace
}  // namespace relief::codec
