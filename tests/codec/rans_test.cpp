#include "codec/rans.h"
#include "codec/bytes.h"

#include <numeric>
#include <random>

namespace relief::codec {
namespace {

constexpr std::size_t kSymbols = 8;
using Frequencies = std::array<std::uint16_t, kSymbols>;

/// Bytes of `symbols` with `states` states, the states first.
std::vector<std::uint8_t> encode(const std::vector<std::uint8_t>& symbols,
                                 const Frequencies& frequencies, std::size_t states) {
    std::array<RansSymbol, kSymbols> table;
    std::uint32_t start = 0;
    for (std::size_t s = 0; s < kSymbols; ++s) {
        if (frequencies[s] > 0) table[s] = RansSymbol(start, frequencies[s]);
        start += frequencies[s];
    }
    std::vector<std::uint16_t> words(symbols.size() + 2 * states);
    std::uint16_t* end = words.data() + words.size();
    std::vector<std::uint32_t> state(states, kRansLow);
    for (std::size_t k = symbols.size(); k-- > 0;)
        end = table[symbols[k]].encode(state[k % states], end);
    ByteWriter bytes;
    for (const std::uint32_t x : state) bytes.u32(x);
    for (; end != words.data() + words.size(); ++end) bytes.u16(*end);
    return bytes.take();
}

std::vector<std::uint8_t> decode(const std::vector<std::uint8_t>& bytes, std::size_t count,
                                 const Frequencies& frequencies, std::size_t states) {
    RansTable<kSymbols> table;
    table.set(frequencies);
    RansWords words(bytes);
    std::vector<std::uint32_t> state(states);
    for (std::uint32_t& x : state) {
        const std::uint32_t low = words.next();
        x = low | std::uint32_t{words.next()} << 16;
    }
    std::vector<std::uint8_t> symbols(count);
    for (std::size_t k = 0; k < count; ++k) {
        symbols[k] = table.decode(state[k % states]);
        words.refill<true>(state[k % states]);
    }
    EXPECT_TRUE(words.at_end());
    for (const std::uint32_t x : state) EXPECT_EQ(x, kRansLow);
    return symbols;
}

/// Symbols with exactly the shares of `frequencies`, in random order.
std::vector<std::uint8_t> typical_symbols(const Frequencies& frequencies, int repetitions) {
    std::vector<std::uint8_t> symbols;
    for (std::size_t s = 0; s < kSymbols; ++s)
        symbols.insert(symbols.end(), static_cast<std::size_t>(repetitions) * frequencies[s],
                       static_cast<std::uint8_t>(s));
    std::shuffle(symbols.begin(), symbols.end(), std::mt19937(7));
    return symbols;
}

TEST(Rans, ReachesTheEntropyOfItsFrequencies) {
    const std::vector<Frequencies> sources = {{4095, 1},
                                              {4000, 90, 4, 2},
                                              {2048, 2048},
                                              {2000, 1000, 500, 250, 200, 100, 40, 6},
                                              {512, 512, 512, 512, 512, 512, 512, 512}};
    for (const Frequencies& frequencies : sources) {
        const auto symbols = typical_symbols(frequencies, 100);
        double bits = 0;
        for (const std::uint8_t s : symbols) bits -= std::log2(frequencies[s] / 4096.0);
        for (const std::size_t states : {1U, 2U, 4U, 8U}) {
            const auto bytes = encode(symbols, frequencies, states);
            ASSERT_EQ(decode(bytes, symbols.size(), frequencies, states), symbols);
            // One percent, and the four bytes in which each state ends.
            EXPECT_LE(static_cast<double>(bytes.size()),
                      1.01 * bits / 8 + 4.0 * static_cast<double>(states));
        }
    }
}

TEST(Rans, ACertainSymbolCostsNothing) {
    const Frequencies certain = {0, 0, 4096};
    const std::vector<std::uint8_t> symbols(100000, 2);
    const auto bytes = encode(symbols, certain, 8);
    EXPECT_EQ(bytes.size(), 32U);
    EXPECT_EQ(decode(bytes, symbols.size(), certain, 8), symbols);
}

/// The reciprocals divide exactly for every frequency, at the largest and least states.
TEST(Rans, DecodesWhatItEncodesForEveryFrequency) {
    for (std::uint32_t f = 1; f <= kRansTotal; ++f) {
        const std::uint64_t limit = std::uint64_t{f} << 20;
        for (const std::uint64_t before : {limit - 1, limit - f, limit / 2 + 12345, limit / 16}) {
            auto state = static_cast<std::uint32_t>(before);
            const std::uint32_t start = (kRansTotal - f) / 3;
            std::uint16_t word = 0;
            ASSERT_EQ(RansSymbol(start, f).encode(state, &word + 1), &word + 1);
            const std::uint64_t expected = (before / f << 12) + before % f + start;
            ASSERT_EQ(state, expected) << f << " " << before;
        }
    }
}

}  // namespace
}  // namespace relief::codec
