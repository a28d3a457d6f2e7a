#include "codec/probability.h"

namespace relief::codec {

namespace {

/// 65536 / (1 + exp(-k / 4)), k = 0 .. 48, rounded; the last is 65535 so that all fit 16 bits.
constexpr int kKnotStep = 64;
constexpr std::array<std::uint16_t, 49> kSquashKnots = {
    32768, 36843, 40793, 44511, 47911, 50941, 53581, 55834, 57724, 59287, 60565, 61598, 62428,
    63090, 63615, 64030, 64357, 64614, 64816, 64974, 65097, 65194, 65269, 65328, 65374, 65410,
    65438, 65459, 65476, 65489, 65500, 65508, 65514, 65519, 65523, 65526, 65528, 65530, 65531,
    65532, 65533, 65534, 65534, 65535, 65535, 65535, 65535, 65535, 65535};

constexpr std::uint16_t squash(std::int32_t odds) {
    const auto size = static_cast<std::uint32_t>(odds < 0 ? -odds : odds);
    const std::uint32_t knot = std::min<std::uint32_t>(size / kKnotStep, kSquashKnots.size() - 2);
    const std::uint32_t part = size - knot * kKnotStep;
    const std::uint32_t value =
        (kSquashKnots[knot] * (kKnotStep - part) + kSquashKnots[knot + 1] * part + kKnotStep / 2) /
        kKnotStep;
    return static_cast<std::uint16_t>(odds < 0 ? 65536 - value : value);
}

constexpr OddsTables make_tables() {
    OddsTables tables{};
    for (std::size_t k = 0; k < tables.squash.size(); ++k)
        tables.squash[k] = squash(static_cast<std::int32_t>(k) - kOddsLimit);
    std::int32_t odds = -kOddsLimit;
    for (std::uint32_t p = 0; p < 4096; ++p) {
        while (odds < kOddsLimit && squash(odds) < 16 * p + 8) ++odds;
        tables.stretch[p] = static_cast<std::int16_t>(odds);
    }
    for (std::uint32_t n = 0; n < tables.rate.size(); ++n)
        tables.rate[n] =
            static_cast<std::uint16_t>(std::min(655360 / (10 * n + 16), std::uint32_t{32767}));
    return tables;
}

}  // namespace

constinit const OddsTables kOdds = make_tables();

}  // namespace relief::codec
