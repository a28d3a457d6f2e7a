#include <fstream>
#include <random>

#include "codec/fast_bits.h"
#include "codec/fast_terrain.h"
#include "codec/fast_tokens.h"
#include "codec/lattice_fill.h"
#include "codec/lattice_level.h"
#include "relief/core/simd.h"

namespace relief::codec {
namespace {

using Samples = Grid<std::int32_t>;
using Mask = Grid<std::uint8_t>;
using Chunk = std::vector<std::uint8_t>;

/// A raster of integers, its mask, and how it is to be coded.
struct Source {
    Samples samples;
    Mask mask;
    int levels = 0;
    std::int32_t step = 1;
    std::int32_t lowest = 0;
    std::int32_t highest = 0;

    [[nodiscard]] std::int64_t rows(int level) const { return ((samples.rows() - 1) >> level) + 1; }
    [[nodiscard]] std::int64_t cols(int level) const { return ((samples.cols() - 1) >> level) + 1; }
};

/// Hills of `relief` and noise of `noise` around `origin`; `holes` of 16 samples are invalid, and
/// hold anything.
struct Terrain {
    std::int64_t rows = 33;
    std::int64_t cols = 41;
    int levels = 3;
    std::int32_t step = 3;
    double relief = 200;
    double noise = 4;
    double origin = 0;
    std::uint32_t holes = 0;
    std::uint32_t seed = 1;
};

Source make_source(const Terrain& t) {
    Source s{Samples(t.rows, t.cols), Mask(t.rows, t.cols), t.levels, t.step};
    std::mt19937 engine(t.seed);
    s.lowest = INT32_MAX;
    s.highest = INT32_MIN;
    for (std::int64_t r = 0; r < t.rows; ++r)
        for (std::int64_t c = 0; c < t.cols; ++c) {
            const double hills =
                std::sin(0.09 * static_cast<double>(r)) * std::cos(0.13 * static_cast<double>(c));
            const double noise = static_cast<double>(engine()) / 4294967296.0 - 0.5;
            const auto z =
                static_cast<std::int32_t>(t.origin + t.relief * hills + 2 * t.noise * noise);
            s.mask(r, c) = engine() % 16 >= t.holes;
            s.samples(r, c) = s.mask(r, c) ? z : static_cast<std::int32_t>(engine());
            if (!s.mask(r, c)) continue;
            s.lowest = std::min(s.lowest, z);
            s.highest = std::max(s.highest, z);
        }
    if (s.lowest > s.highest) s.lowest = s.highest = 0;
    return s;
}

Samples decimated(const Source& s, int level) {
    Samples out(s.rows(level), s.cols(level));
    for (std::int64_t r = 0; r < out.rows(); ++r)
        for (std::int64_t c = 0; c < out.cols(); ++c) out(r, c) = s.samples(r << level, c << level);
    return out;
}

void set_mask(LatticeLevel& level, const Source& s) {
    level.all_valid = true;
    for (std::int64_t r = 0; r < level.rows(); ++r)
        for (std::int64_t c = 0; c < level.cols(); ++c) {
            level.valid(r, c) = s.mask(r << level.level, c << level.level);
            level.all_valid &= level.valid(r, c) != 0;
        }
}

LatticeLevel coarsest_level(const Source& s) {
    LatticeLevel level;
    level.level = s.levels;
    level.values = MarginGrid<std::int32_t>(s.rows(s.levels), s.cols(s.levels));
    level.quotients = MarginGrid<std::int16_t>(s.rows(s.levels), s.cols(s.levels));
    level.valid = MarginGrid<std::uint8_t>(s.rows(s.levels), s.cols(s.levels));
    level.step = s.step;
    level.lowest = s.lowest;
    level.highest = s.highest;
    set_mask(level, s);
    const Samples samples = decimated(s, s.levels);
    for (std::int64_t r = 0; r < level.rows(); ++r)
        for (std::int64_t c = 0; c < level.cols(); ++c)
            level.values(r, c) = level.valid(r, c) ? samples(r, c) : s.lowest;
    return level;
}

LatticeLevel finer_level(LatticeLevel& coarse, const Source& s) {
    LatticeLevel fine = refine(coarse, s.rows(coarse.level - 1), s.cols(coarse.level - 1));
    fine.step = s.step;
    set_mask(fine, s);
    return fine;
}

struct Encoded {
    std::vector<Chunk> chunks;
    std::vector<LatticeLevel> levels;  ///< from the coarsest
};

Encoded encode(const Source& s, LevelCodec& codec) {
    Encoded out;
    out.levels.push_back(coarsest_level(s));
    for (int l = s.levels - 1; l >= 0; --l) {
        LatticeLevel fine = finer_level(out.levels.back(), s);
        const Samples samples = decimated(s, l);
        EXPECT_TRUE(codec.encode(fine, samples.view(), out.chunks.emplace_back()));
        out.levels.push_back(std::move(fine));
    }
    return out;
}

Encoded encode(const Source& s) {
    return encode(s, *make_fast_codec());
}

/// Values to two cells out, as the next level and the neighbours see them.
void expect_equal(const LatticeLevel& a, const LatticeLevel& b) {
    for (std::int64_t r = -2; r < a.rows() + 2; ++r)
        for (std::int64_t c = -2; c < a.cols() + 2; ++c) {
            ASSERT_EQ(a.values(r, c), b.values(r, c)) << a.level << ": " << r << " " << c;
            ASSERT_EQ(a.quotients(r, c), b.quotients(r, c)) << a.level << ": " << r << " " << c;
        }
}

void expect_bound(const LatticeLevel& level, const Source& s) {
    const std::int64_t bound = (level.step - 1) / 2;
    for (std::int64_t r = 0; r < level.rows(); ++r)
        for (std::int64_t c = 0; c < level.cols(); ++c) {
            const std::int64_t sample = s.samples(r << level.level, c << level.level);
            if (!level.valid(r, c)) continue;
            ASSERT_LE(std::abs(level.values(r, c) - sample), bound) << r << " " << c;
        }
}

void expect_round_trip(const Source& s) {
    const auto encoder = make_fast_codec();
    const auto decoder = make_fast_codec();
    LatticeLevel coarse = coarsest_level(s);
    LatticeLevel decoded_coarse = coarsest_level(s);
    for (int l = s.levels - 1; l >= 0; --l) {
        LatticeLevel fine = finer_level(coarse, s);
        LatticeLevel decoded = finer_level(decoded_coarse, s);
        Chunk chunk;
        EXPECT_TRUE(encoder->encode(fine, decimated(s, l).view(), chunk));
        const Status status = decoder->decode(decoded, chunk);
        ASSERT_TRUE(status.ok()) << status.error().text();
        expect_equal(fine, decoded);
        expect_bound(decoded, s);
        coarse = std::move(fine);
        decoded_coarse = std::move(decoded);
    }
}

TEST(FastCodec, RoundTripsAllSmallSizes) {
    for (std::int64_t rows = 1; rows <= 9; ++rows)
        for (std::int64_t cols = 1; cols <= 9; ++cols)
            expect_round_trip(make_source({.rows = rows, .cols = cols, .levels = 3}));
}

TEST(FastCodec, RoundTripsAnyTerrain) {
    EXPECT_TRUE(rc::check([] {
        Terrain t;
        t.rows = *rc::gen::inRange(1, 90);
        t.cols = *rc::gen::inRange(1, 90);
        t.levels = *rc::gen::inRange(1, 6);
        t.step = 2 * *rc::gen::inRange(0, 60) + 1;
        t.relief = std::exp2(*rc::gen::inRange(0, 20));
        t.noise = std::exp2(*rc::gen::inRange(-3, 12));
        t.origin = *rc::gen::inRange(-100000, 100000);
        t.holes = *rc::gen::inRange(0U, 17U);
        t.seed = *rc::gen::arbitrary<std::uint32_t>();
        expect_round_trip(make_source(t));
    }));
}

/// Up to the limits of the format: spans of 2^30, quotients of 2^29, steps as large as the span.
TEST(FastCodec, RoundTripsHugeRanges) {
    for (const double size : {16.7e6 / 4, 16.8e6 / 2, 1e8, 5.3e8})
        for (const std::int32_t step : {1, 63, 65537, 100000001, 1000000001})
            for (const std::uint32_t holes : {0U, 4U}) {
                Terrain t{.rows = 40, .cols = 75, .step = step, .holes = holes};
                t.relief = size / 2;
                t.noise = size / 2;
                t.origin = size == 1e8 ? -4e8 : 0;
                expect_round_trip(make_source(t));
            }
}

TEST(FastCodec, ScalarAndVectorGiveTheSameBytes) {
    for (const double relief : {300.0, 3e7})
        for (const std::uint32_t holes : {0U, 3U}) {
            const Source s = make_source(
                {.rows = 130, .cols = 203, .levels = 4, .relief = relief, .holes = holes});
            const Encoded vector = encode(s);
            set_simd_enabled(false);
            const Encoded scalar = encode(s);
            set_simd_enabled(true);
            EXPECT_EQ(vector.chunks, scalar.chunks);
            for (std::size_t k = 0; k < vector.levels.size(); ++k)
                expect_equal(vector.levels[k], scalar.levels[k]);
        }
}

TEST(FastCodec, ALevelAsPredictedNeedsNoBytes) {
    const Source s = make_source({.step = 1001, .relief = 200});
    for (const Chunk& chunk : encode(s).chunks) EXPECT_TRUE(chunk.empty());
    expect_round_trip(s);
    const Source holes = make_source({.holes = 16});
    for (const Chunk& chunk : encode(holes).chunks) EXPECT_TRUE(chunk.empty());
}

/// What was learnt on one level is known on the next: fewer bytes than when each begins anew.
TEST(FastCodec, CarriesItsTablesFromLevelToLevel) {
    const Source s = make_source({.rows = 129, .cols = 129, .levels = 5, .noise = 60});
    const auto codec = make_fast_codec();
    LatticeLevel coarse = coarsest_level(s);
    std::size_t carried = 0;
    std::size_t anew = 0;
    for (int l = s.levels - 1; l >= 0; --l) {
        LatticeLevel fine = finer_level(coarse, s);
        LatticeLevel again = finer_level(coarse, s);
        const Samples samples = decimated(s, l);
        Chunk chunk;
        codec->encode(fine, samples.view(), chunk);
        carried += chunk.size();
        chunk.clear();
        make_fast_codec()->encode(again, samples.view(), chunk);
        anew += chunk.size();
        coarse = std::move(fine);
    }
    EXPECT_LT(carried, anew);
}

TEST(FastCodec, DescendantsStartEqualAndLeaveTheirParentAlone) {
    const Source tile = make_source({.rows = 64, .cols = 64, .noise = 30});
    const Source other = make_source({.rows = 64, .cols = 64, .noise = 3, .seed = 2});
    const auto parent = make_fast_codec();
    encode(tile, *parent);
    const auto first = parent->descendant();
    const Encoded a = encode(other, *first);
    encode(tile, *first);
    const Encoded b = encode(other, *parent->descendant());
    EXPECT_EQ(a.chunks, b.chunks);
    EXPECT_NE(a.chunks, encode(other).chunks);
}

/// Decodes a chunk of the finest level in its place.
Status decode_last(const Source& s, const Encoded& encoded, std::span<const std::uint8_t> bytes) {
    const auto decoder = make_fast_codec();
    LatticeLevel level = coarsest_level(s);
    for (std::size_t k = 0; k + 1 < encoded.chunks.size(); ++k) {
        LatticeLevel fine = finer_level(level, s);
        EXPECT_TRUE(decoder->decode(fine, encoded.chunks[k]).ok());
        level = std::move(fine);
    }
    LatticeLevel fine = finer_level(level, s);
    // An own allocation: sanitizers see reads past it.
    const Chunk copy(bytes.begin(), bytes.end());
    return decoder->decode(fine, copy);
}

TEST(FastCodec, RejectsEveryTruncation) {
    for (const double noise : {2.0, 100.0}) {
        const Source s = make_source({.rows = 30, .cols = 50, .noise = noise, .holes = 1});
        const Encoded encoded = encode(s);
        const Chunk& last = encoded.chunks.back();
        ASSERT_TRUE(decode_last(s, encoded, last).ok());
        for (std::size_t n = 1; n < last.size(); ++n)
            EXPECT_FALSE(decode_last(s, encoded, std::span(last).first(n)).ok()) << n;
        Chunk longer = last;
        longer.push_back(0);
        EXPECT_FALSE(decode_last(s, encoded, longer).ok());
    }
}

/// Damage ends in an error or in other values, never in a crash; checksums find it elsewhere.
TEST(FastCodec, SurvivesFlippedBits) {
    for (const double relief : {200.0, 3e8}) {
        const Source s = make_source({.rows = 30, .cols = 50, .relief = relief, .noise = 60});
        const Encoded encoded = encode(s);
        Chunk damaged = encoded.chunks.back();
        int errors = 0;
        for (std::size_t k = 0; k < damaged.size(); ++k)
            for (int bit = 0; bit < 8; bit += 3) {
                damaged[k] ^= static_cast<std::uint8_t>(1 << bit);
                errors += !decode_last(s, encoded, damaged).ok();
                damaged[k] ^= static_cast<std::uint8_t>(1 << bit);
            }
        EXPECT_GT(errors, 0);
        std::mt19937 engine(3);
        for (int k = 0; k < 300; ++k) {
            Chunk random(engine() % 200 + 1);
            for (std::uint8_t& byte : random) byte = static_cast<std::uint8_t>(engine());
            EXPECT_FALSE(decode_last(s, encoded, random).ok());
        }
    }
}

/// The formula of the specification, sample by sample.
std::int32_t predicted(const LatticeLevel& level, std::int64_t r, std::int64_t c,
                       const std::array<std::array<int, 2>, 4>& near,
                       const std::array<std::array<int, 2>, 8>& far) {
    std::int64_t sum = 16;
    for (const auto& [dr, dc] : near) sum += 10 * std::int64_t{level.values(r + dr, c + dc)};
    for (const auto& [dr, dc] : far) sum -= level.values(r + dr, c + dc);
    const auto floored = static_cast<std::int64_t>(std::floor(static_cast<double>(sum) / 32));
    return static_cast<std::int32_t>(
        std::clamp<std::int64_t>(floored, level.lowest, level.highest));
}

void fill_naively(LatticeLevel& level) {
    for (std::int64_t r = 1; r < level.rows(); r += 2)
        for (std::int64_t c = 1; c < level.cols(); c += 2)
            level.values(r, c) = predicted(
                level, r, c, {{{-1, -1}, {-1, 1}, {1, -1}, {1, 1}}},
                {{{-1, -3}, {-1, 3}, {1, -3}, {1, 3}, {-3, -1}, {-3, 1}, {3, -1}, {3, 1}}});
    fill_diagonal_margins(level);
    for (std::int64_t r = 0; r < level.rows(); ++r)
        for (std::int64_t c = 1 - r % 2; c < level.cols(); c += 2)
            level.values(r, c) = predicted(
                level, r, c, {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}},
                {{{-2, -1}, {-2, 1}, {2, -1}, {2, 1}, {-1, -2}, {-1, 2}, {1, -2}, {1, 2}}});
    fill_edge_margins(level);
    for (std::int64_t r = 0; r < level.rows(); ++r)
        for (std::int64_t c = 1 - r % 2; c < level.cols(); c += 2 - r % 2)
            level.quotients(r, c) = 0;
}

TEST(FillLevel, IsTheFormulaSampleBySample) {
    for (const double relief : {500.0, 4e8})
        for (const std::int64_t rows : {1, 2, 7, 64, 81})
            for (const std::int64_t cols : {1, 2, 8, 33, 150}) {
                const Source s = make_source(
                    {.rows = rows, .cols = cols, .levels = 1, .relief = relief, .noise = 50});
                LatticeLevel coarse = coarsest_level(s);
                LatticeLevel expected = finer_level(coarse, s);
                LatticeLevel filled = finer_level(coarse, s);
                LatticeLevel scalar = finer_level(coarse, s);
                fill_naively(expected);
                fill_level(filled);
                set_simd_enabled(false);
                fill_level(scalar);
                set_simd_enabled(true);
                expect_equal(expected, filled);
                expect_equal(expected, scalar);
            }
}

/// Errors found row by row are those of the filled level, with holes and without.
TEST(FillLevel, LargestErrorIsThatOfTheLevel) {
    for (const std::uint32_t holes : {0U, 5U})
        for (const std::int64_t rows : {1, 2, 7, 64, 81})
            for (const std::int64_t cols : {1, 2, 8, 33, 150}) {
                Source s = make_source(
                    {.rows = rows, .cols = cols, .levels = 1, .noise = 50, .holes = holes});
                for (std::int64_t r = 0; r < rows; ++r)
                    for (std::int64_t c = 0; c < cols; ++c)
                        s.samples(r, c) = s.mask(r, c) ? s.samples(r, c) - s.lowest : 0;
                s.highest -= s.lowest;
                s.lowest = 0;
                LatticeLevel coarse = coarsest_level(s);
                LatticeLevel filled = finer_level(coarse, s);
                fill_level(filled);
                std::int32_t expected = 0;
                for (std::int64_t r = 0; r < rows; ++r)
                    for (std::int64_t c = 0; c < cols; ++c)
                        if (s.mask(r, c))
                            expected =
                                std::max(expected, std::abs(filled.values(r, c) - s.samples(r, c)));
                const Mask none;
                EXPECT_EQ(largest_filling_error(coarse, s.samples.view(), holes ? s.mask : none),
                          expected)
                    << rows << " x " << cols;
            }
}

/// Away from borders, whose margins are reflected: planes are exact, and so is any quadratic whose
/// Laplacian the predictor cancels.
TEST(FillLevel, KeepsQuadraticSurfaces) {
    Source s = make_source({.rows = 40, .cols = 40, .levels = 1});
    s.lowest = -10000;
    s.highest = 10000;
    const auto surface = [](std::int64_t r, std::int64_t c) {
        return static_cast<std::int32_t>(3 * r * r - 2 * c * c + r * c + 5 * r - 11 * c);
    };
    for (std::int64_t r = 0; r < 40; ++r)
        for (std::int64_t c = 0; c < 40; ++c) s.samples(r, c) = surface(r, c);
    s.mask = Mask(40, 40, 1);
    LatticeLevel coarse = coarsest_level(s);
    LatticeLevel level = finer_level(coarse, s);
    fill_level(level);
    for (std::int64_t r = 6; r < 34; ++r)
        for (std::int64_t c = 6; c < 34; ++c) ASSERT_EQ(level.values(r, c), surface(r, c));
}

using fast::TokenWeights;

TEST(TokenFrequencies, AlwaysAddUpAndKeepWhatOccurs) {
    EXPECT_TRUE(rc::check([] {
        std::mt19937 engine(*rc::gen::arbitrary<std::uint32_t>());
        TokenWeights weights{};
        for (std::uint8_t& weight : weights)
            weight = static_cast<std::uint8_t>(engine() % 3 == 0 ? 0 : engine() % 64);
        weights[engine() % weights.size()] = fast::kLargestWeight;
        const auto frequencies = fast::frequencies_of(weights);
        int sum = 0;
        for (std::size_t t = 0; t < weights.size(); ++t) {
            RC_ASSERT((frequencies[t] > 0) == (weights[t] > 0));
            sum += frequencies[t];
        }
        RC_ASSERT(sum == 4096);
    }));
}

TEST(TokenModel, ReadsTheChoiceItWrote) {
    std::mt19937 engine(5);
    fast::TokenModel encoder;
    fast::TokenModel decoder;
    for (int round = 0; round < 20; ++round) {
        fast::ClassCounts counts{};
        for (auto& row : counts)
            for (std::uint32_t& count : row)
                count = engine() % 3 ? 0 : static_cast<std::uint32_t>(engine() >> (engine() % 32));
        fast::BitWriter bits;
        encoder.adapt(counts, bits);
        fast::BitReader reader(bits.bytes());
        ASSERT_TRUE(decoder.read(reader));
        EXPECT_TRUE(reader.at_end());
        for (std::size_t c = 0; c < fast::kClasses; ++c) {
            const auto frequencies = encoder.frequencies(c);
            ASSERT_EQ(frequencies, decoder.frequencies(c));
            for (std::size_t t = 0; t < frequencies.size(); ++t)
                EXPECT_GE(frequencies[t] > 0, counts[c][t] > 0);
        }
    }
}

/// The bytes of the format, which must not change: three levels of integers, with a hole.
TEST(FastCodec, WritesTheBytesOfTheFormat) {
    Source s{Samples(11, 13), Mask(11, 13, 1), 3, 3, 0, 200};
    for (std::int64_t r = 0; r < 11; ++r)
        for (std::int64_t c = 0; c < 13; ++c)
            s.samples(r, c) = static_cast<std::int32_t>(100 + 3 * r - c * c / 2 + r * c * 7 % 11);
    s.mask(3, 4) = 0;
    std::string text;
    for (const Chunk& chunk : encode(s).chunks) {
        for (const std::uint8_t byte : chunk)
            for (const int digit : {byte >> 4, byte & 15}) text += "0123456789abcdef"[digit];
        text += ' ';
    }
    EXPECT_EQ(text,
              "3008e58f4100f90f0f0c5202 300adb4e8e18883d62ec89bce0eb15 "
              "401c618fbe185fdf645c34af7376755e1315fe2911dc3f893cafeac70c4d109fd12c0faaae20a619 ");
}

/// 48 samples, most of them 0: tables and states take less than 10 bytes.
TEST(FastCodec, TinyLevelsPayLittleForTables) {
    const Source s = make_source({.rows = 8, .cols = 8, .levels = 1, .step = 41, .noise = 25});
    const Encoded encoded = encode(s);
    EXPECT_GT(encoded.chunks[0].size(), 0U);
    EXPECT_LE(encoded.chunks[0].size(), 24U);
    expect_round_trip(s);
}

/// The weights to begin with are part of the format.
TEST(FastCodec, FirstWeightsAreTheDocumentedOnes) {
    std::ifstream file(std::string(RELIEF_TEST_DATA) + "/../../docs/fast-tokens.txt");
    for (const fast::TokenWeights& weights : fast::kTerrain)
        for (const std::uint8_t weight : weights) {
            int documented = -1;
            file >> documented;
            EXPECT_EQ(documented, weight);
        }
    std::string more;
    EXPECT_FALSE(file >> more);
}

}  // namespace
}  // namespace relief::codec
