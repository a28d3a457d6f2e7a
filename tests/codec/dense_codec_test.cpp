#include <algorithm>
#include <memory>
#include <random>

#include "codec/dense_forecast.h"
#include "codec/dense_least_squares.h"
#include "codec/dense_model.h"
#include "codec/dense_rules.h"
#include "codec/lattice_level.h"
#include "relief/core/simd.h"
#include "support.h"

namespace relief::codec {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Integers = Grid<std::int32_t>;

/// Samples with holes, and how coarsely they are kept.
struct Surface {
    Integers samples;
    Grid<std::uint8_t> valid;
    std::int32_t step = 1;
    std::int32_t lowest = 0;
    std::int32_t highest = 0;

    Surface(Integers values, std::int32_t step_size)
        : samples(std::move(values)),
          valid(samples.rows(), samples.cols(), 1),
          step(step_size),
          lowest(samples(0, 0)),
          highest(lowest) {
        for (std::int64_t r = 0; r < samples.rows(); ++r)
            for (std::int64_t c = 0; c < samples.cols(); ++c) {
                lowest = std::min(lowest, samples(r, c));
                highest = std::max(highest, samples(r, c));
            }
    }

    [[nodiscard]] std::int64_t rows_at(int level) const {
        return ((samples.rows() - 1) >> level) + 1;
    }
    [[nodiscard]] std::int64_t cols_at(int level) const {
        return ((samples.cols() - 1) >> level) + 1;
    }

    [[nodiscard]] Integers samples_at(int level) const {
        Integers out(rows_at(level), cols_at(level));
        for (std::int64_t r = 0; r < out.rows(); ++r)
            for (std::int64_t c = 0; c < out.cols(); ++c)
                out(r, c) = samples(r << level, c << level);
        return out;
    }

    /// The level that all others refine, as if it had been decoded.
    [[nodiscard]] LatticeLevel coarsest(int level) const {
        LatticeLevel out;
        out.level = level;
        out.values = MarginGrid<std::int32_t>(rows_at(level), cols_at(level));
        out.quotients = MarginGrid<std::int16_t>(rows_at(level), cols_at(level));
        out.lowest = lowest;
        out.highest = highest;
        for (std::int64_t r = 0; r < out.rows(); ++r)
            for (std::int64_t c = 0; c < out.cols(); ++c) {
                const std::int64_t above = std::int64_t{samples(r << level, c << level)} - lowest;
                out.values(r, c) =
                    static_cast<std::int32_t>(lowest + (above + step / 2) / step * step);
            }
        return out;
    }

    [[nodiscard]] LatticeLevel refined(LatticeLevel& coarse) const {
        const int level = coarse.level - 1;
        LatticeLevel fine = refine(coarse, rows_at(level), cols_at(level));
        fine.step = step;
        for (std::int64_t r = 0; r < fine.rows(); ++r)
            for (std::int64_t c = 0; c < fine.cols(); ++c) {
                fine.valid(r, c) = valid(r << level, c << level);
                fine.all_valid = fine.all_valid && fine.valid(r, c);
            }
        return fine;
    }
};

struct Coded {
    std::vector<Bytes> chunks;
    LatticeLevel finest;

    [[nodiscard]] std::size_t size() const {
        std::size_t sum = 0;
        for (const Bytes& chunk : chunks) sum += chunk.size();
        return sum;
    }
};

Coded encode(LevelCodec& codec, const Surface& surface, int levels) {
    Coded coded{{}, surface.coarsest(levels)};
    for (int level = levels - 1; level >= 0; --level) {
        LatticeLevel fine = surface.refined(coded.finest);
        EXPECT_TRUE(
            codec.encode(fine, surface.samples_at(level).view(), coded.chunks.emplace_back()));
        fill_edge_margins(fine);
        coded.finest = std::move(fine);
    }
    return coded;
}

Coded encode(const Surface& surface, int levels) {
    return encode(*make_dense_codec(), surface, levels);
}

Result<LatticeLevel> decode(const Surface& surface, const std::vector<Bytes>& chunks) {
    const std::unique_ptr<LevelCodec> codec = make_dense_codec();
    LatticeLevel level = surface.coarsest(static_cast<int>(chunks.size()));
    for (const Bytes& chunk : chunks) {
        LatticeLevel fine = surface.refined(level);
        RELIEF_CHECK(codec->decode(fine, chunk));
        fill_edge_margins(fine);
        level = std::move(fine);
    }
    return level;
}

template <class T>
bool same(const MarginGrid<T>& a, const MarginGrid<T>& b) {
    for (std::int64_t r = 0; r < a.rows(); ++r)
        if (!std::equal(a.row(r), a.row(r) + a.cols(), b.row(r))) return false;
    return a.rows() == b.rows() && a.cols() == b.cols();
}

/// Of the samples where the mask has one.
std::int64_t largest_error(const Surface& surface, const LatticeLevel& finest) {
    std::int64_t largest = 0;
    for (std::int64_t r = 0; r < finest.rows(); ++r)
        for (std::int64_t c = 0; c < finest.cols(); ++c)
            if (surface.valid(r, c))
                largest = std::max(
                    largest, std::abs(std::int64_t{finest.values(r, c)} - surface.samples(r, c)));
    return largest;
}

/// Smooth hills `height` high and noise of `rough` around them.
Integers hills(std::int64_t rows, std::int64_t cols, double height, double rough,
               std::uint64_t seed = 1) {
    test::Noise noise(seed);
    Integers grid(rows, cols);
    for (std::int64_t r = 0; r < rows; ++r)
        for (std::int64_t c = 0; c < cols; ++c) {
            const double x = static_cast<double>(c) / 31;
            const double y = static_cast<double>(r) / 23;
            const double z = std::sin(x) * std::cos(y) + std::sin(.3 * x + 2 * y) / 3;
            grid(r, c) = static_cast<std::int32_t>(std::floor(height * z + rough * noise() + .5));
        }
    return grid;
}

TEST(DenseCodec, RoundTripsWithinTheBound) {
    EXPECT_TRUE(rc::check([] {
        const auto rows = *rc::gen::inRange<std::int64_t>(1, 40);
        const auto cols = *rc::gen::inRange<std::int64_t>(1, 40);
        const auto levels = *rc::gen::inRange(1, 6);
        const auto step = *rc::gen::element(1, 3, 7, 63, 100001);
        const auto height = *rc::gen::element(0.0, 3.0, 1000.0, 0x1p27);
        const auto rough = *rc::gen::element(0.0, 2.0, 500.0, 0x1p26);
        const auto holes = *rc::gen::element(0, 5, 50, 100);
        Surface surface(hills(rows, cols, height, rough), step);
        std::mt19937 engine(5);
        for (std::int64_t r = 0; r < rows; ++r)
            for (std::int64_t c = 0; c < cols; ++c)
                surface.valid(r, c) = static_cast<int>(engine() % 100) >= holes;
        const Coded coded = encode(surface, levels);
        RC_ASSERT(2 * largest_error(surface, coded.finest) <= step - 1);
        const auto decoded = decode(surface, coded.chunks);
        RC_ASSERT(decoded.ok());
        RC_ASSERT(same(decoded->values, coded.finest.values));
        RC_ASSERT(same(decoded->quotients, coded.finest.quotients));
    }));
}

TEST(DenseCodec, KeepsQuotientsOfAnySize) {
    std::mt19937 engine(3);
    Integers samples(33, 47);
    for (std::int64_t r = 0; r < samples.rows(); ++r)
        for (std::int64_t c = 0; c < samples.cols(); ++c)
            samples(r, c) = static_cast<std::int32_t>(engine() >> 2) - (1 << 29);
    samples(0, 0) = -(1 << 29) + 1;
    samples(32, 45) = (1 << 29) - 1;
    const Surface surface(std::move(samples), 1);
    const Coded coded = encode(surface, 5);
    EXPECT_EQ(largest_error(surface, coded.finest), 0);
    const auto decoded = decode(surface, coded.chunks);
    ASSERT_TRUE(decoded.ok()) << decoded.error().text();
    EXPECT_TRUE(same(decoded->values, coded.finest.values));
}

TEST(DenseCodec, ConstantsCostNothing) {
    const Surface surface(hills(200, 300, 0, 0), 1);
    const Coded coded = encode(surface, 7);
    // A decision costs at least 0.0004 bits: 60000 of them 3 bytes; learning that takes some more.
    EXPECT_LE(coded.size(), 80U);
    EXPECT_EQ(largest_error(surface, coded.finest), 0);
}

TEST(DenseCodec, HolesAreBridged) {
    Surface surface(hills(60, 70, 300, 2), 3);
    for (std::int64_t r = 20; r < 45; ++r)
        for (std::int64_t c = 10; c < 50; ++c) surface.valid(r, c) = 0;
    const Coded coded = encode(surface, 5);
    for (std::int64_t r = 20; r < 45; ++r)
        for (std::int64_t c = 10; c < 50; ++c) {
            if (r % 32 == 0 && c % 32 == 0) continue;  // of the coarsest level, not coded here
            EXPECT_EQ(coded.finest.quotients(r, c), 0);
            EXPECT_GE(coded.finest.values(r, c), surface.lowest);
            EXPECT_LE(coded.finest.values(r, c), surface.highest);
            surface.samples(r, c) = 1 << 28;
        }
    EXPECT_EQ(encode(surface, 5).chunks, coded.chunks) << "holes may hold anything";
}

/// Independent samples of nine equally likely values have log2(9) = 3.17 bits. Predictions from
/// some ten equally noisy samples raise the variance of what is coded by a tenth to a fourth and
/// make it bell-shaped, 3.4 to 3.6 bits; learning 65536 samples takes the rest. With a step of 15
/// an error below 7.5 of standard deviation 2.9 needs no quotient, which leaves few.
TEST(DenseCodec, CodesNoiseNearItsEntropy) {
    const auto bits = [](std::int32_t step) {
        const Surface surface(hills(256, 256, 100, 4.5), step);
        return 8.0 * static_cast<double>(encode(surface, 7).size()) / 65536;
    };
    EXPECT_LE(bits(1), 3.65);
    EXPECT_LE(bits(15), 0.25);
}

/// The finest samples of every odd row are means of those above and below, rounded down. Coded as
/// noise like the others they would cost log2(2000) = 11 bits each.
TEST(DenseCodec, FindsSamplesThatWereInterpolated) {
    Surface surface(hills(128, 128, 0, 1000), 1);
    for (std::int64_t r = 1; r < 127; r += 2)
        for (std::int64_t c = 0; c < 128; ++c)
            surface.samples(r, c) = (surface.samples(r - 1, c) + surface.samples(r + 1, c)) >> 1;
    const Coded coded = encode(surface, 1);
    EXPECT_EQ(largest_error(surface, coded.finest), 0);
    const auto decoded = decode(surface, coded.chunks);
    ASSERT_TRUE(decoded.ok()) << decoded.error().text();
    EXPECT_TRUE(same(decoded->values, coded.finest.values));
    // A quarter of the samples is given, a quarter (D) is noise of half the variance, 10.5 bits. Of
    // the E samples one half are means, and the other half are told by the D samples to within one;
    // both cost up to 2 bits, and what it takes to notice.
    const double bits = 8.0 * static_cast<double>(coded.size());
    EXPECT_LE(bits, 64 * 64 * (11 + 2.5 + 4));
}

TEST(DenseCodec, DescendantsUseWhatWasLearnt) {
    const std::unique_ptr<LevelCodec> codec = make_dense_codec();
    (void)encode(*codec, Surface(hills(256, 256, 900, 4.5), 3), 7);
    const Surface tile(hills(64, 64, 900, 4.5, 77), 3);
    const std::size_t learnt = encode(*codec->descendant(), tile, 2).size();
    const std::size_t fresh = encode(tile, 2).size();
    EXPECT_LT(static_cast<double>(learnt), 0.97 * static_cast<double>(fresh));
}

TEST(DenseCodec, DescendantsStartAlikeAndLeaveTheirParentAlone) {
    const Surface surface(hills(90, 100, 900, 3), 3);
    const std::unique_ptr<LevelCodec> codec = make_dense_codec();
    (void)encode(*codec, surface, 5);
    const std::unique_ptr<LevelCodec> first = codec->descendant();
    const std::unique_ptr<LevelCodec> second = codec->descendant();
    const Coded coded = encode(*first, surface, 5);
    EXPECT_EQ(encode(*second, surface, 5).chunks, coded.chunks);
    EXPECT_EQ(encode(*codec, surface, 5).chunks, coded.chunks);
}

TEST(DenseCodec, DamagedBytesAreRefusedOrGiveFiniteNonsense) {
    const Surface surface(hills(50, 60, 900, 9), 3);
    const Coded coded = encode(surface, 2);
    std::vector<Bytes> half = coded.chunks;
    half[1].resize(half[1].size() / 2);
    const auto cut = decode(surface, half);
    ASSERT_FALSE(cut.ok());
    EXPECT_EQ(cut.error().code, ErrorCode::BadFile);

    std::mt19937 engine(8);
    for (int trial = 0; trial < 400; ++trial) {
        std::vector<Bytes> damaged = coded.chunks;
        Bytes& chunk = damaged[engine() % 2];
        for (int edits = 0; edits < 3; ++edits) {
            if (engine() % 8 == 0) chunk.resize(engine() % (chunk.size() + 1));
            if (!chunk.empty()) chunk[engine() % chunk.size()] ^= 1U << engine() % 8;
        }
        const auto decoded = decode(surface, damaged);
        if (!decoded.ok()) continue;
        for (std::int64_t r = 0; r < decoded->rows(); ++r)
            for (std::int64_t c = 0; c < decoded->cols(); ++c) {
                ASSERT_GE(decoded->values(r, c), surface.lowest - surface.step);
                ASSERT_LE(decoded->values(r, c), surface.highest + surface.step);
            }
    }
}

TEST(DenseCodec, VectorsAndScalarsWriteTheSameBytes) {
    const Surface surface(hills(70, 111, 5000, 20), 9);
    const Coded vectors = encode(surface, 6);
    set_simd_enabled(false);
    const Coded scalars = encode(surface, 6);
    set_simd_enabled(true);
    EXPECT_EQ(vectors.chunks, scalars.chunks);
    EXPECT_TRUE(same(vectors.finest.values, scalars.finest.values));
}

}  // namespace

namespace dense {
namespace {

TEST(DenseKernels, WeightedSumIsTheSumOfItsTaps) {
    test::Noise noise(4);
    std::vector<std::int32_t> samples(400);
    for (std::int32_t& sample : samples) sample = static_cast<std::int32_t>(noise() * 0x1p29);
    std::vector<Tap> taps;
    for (int t = 0; t < 21; ++t) taps.push_back({samples.data() + t, noise()});
    for (const std::size_t count : {1U, 3U, 8U, 13U, 150U}) {
        std::vector<double> vectors(count + kSlack);
        weighted_sum(taps, count, vectors.data());
        for (std::size_t k = 0; k < count; ++k) {
            double sum = 0;
            for (const Tap& tap : taps) sum += tap.weight * tap.samples[2 * k];
            ASSERT_EQ(vectors[k], sum) << k;
        }
    }
}

TEST(RidgeRegression, VectorsAndScalarsLearnTheSame) {
    test::Noise noise(9);
    std::vector<Equation> equations(100);
    for (Equation& equation : equations) {
        const double weight = 1 + noise();
        for (std::size_t j = 0; j < kFeatures; ++j) {
            equation.features[j] = 1e4 * noise();
            equation.weighted[j] = weight * equation.features[j];
        }
        equation.weighted[kFeatures] = weight * 1e4 * noise();
    }
    RidgeRegression vectors(kStencils[0].weights);
    RidgeRegression scalars(kStencils[0].weights);
    vectors.learn(equations);
    set_simd_enabled(false);
    scalars.learn(equations);
    set_simd_enabled(true);
    EXPECT_EQ(vectors.weights(), scalars.weights());
    EXPECT_NE(vectors.weights(), kStencils[0].weights);
}

/// With one feature that is not zero the problem is (a + r) w = b + r start.
TEST(RidgeRegression, SolvesTheNormalEquations) {
    constexpr std::size_t n = 5;
    const Weights start = kStencils[1].weights;
    RidgeRegression regression(start);
    std::vector<Equation> equations(kLearning.batch);
    double a = 0;
    double b = 0;
    for (std::size_t k = 0; k < equations.size(); ++k) {
        const double feature = 1 + static_cast<double>(k % 7);
        const double target = 3 * feature + static_cast<double>(k % 3);
        equations[k].features[n] = feature;
        equations[k].weighted[n] = 2 * feature;
        equations[k].weighted[kFeatures] = 2 * target;
        a += 2 * feature * feature;
        b += 2 * feature * target;
    }
    regression.learn(equations);
    const double r = kLearning.trace_ridge * a / kFeatures + kLearning.ridge;
    for (std::size_t k = 0; k < kFeatures; ++k) {
        const double expected = k == n ? (b + r * start[n]) / (a + r) : start[k];
        // Roundings of a square root and a few divisions.
        EXPECT_NEAR(regression.weights()[k], expected, 1e-14) << k;
    }
}

TEST(RowForecast, SumsBaseAndFeatures) {
    LatticeLevel level;
    level.values = MarginGrid<std::int32_t>(9, 40);
    level.quotients = MarginGrid<std::int16_t>(9, 40);
    level.step = 3;
    test::Noise noise(2);
    for (std::int64_t r = -4; r < 13; ++r)
        for (std::int64_t c = -4; c < 44; ++c)
            level.values(r, c) = static_cast<std::int32_t>(1000 * noise());
    for (const Kind kind : {Kind::Diagonal, Kind::Vertical, Kind::Horizontal}) {
        const std::int64_t row = kind == Kind::Horizontal ? 4 : 5;
        const Stencil& stencil = kStencils[static_cast<std::size_t>(kind)];
        RowForecast forecast;
        forecast.make(level, kind, row, stencil.weights);
        ASSERT_EQ(forecast.count, 20);
        for (std::int64_t k = 0; k < forecast.count; ++k) {
            const std::int64_t c = forecast.first + 2 * k;
            const auto at = [&](Offset o) { return level.values(row + o.row, c + o.col); };
            double base = 0;
            for (const Offset& nearest : stencil.nearest) base += at(nearest) / 4.0;
            double expected = base;
            for (std::size_t j = 0; j < kFeatures; ++j) {
                const Feature& feature = stencil.features[j];
                expected += stencil.weights[j] * (at(feature.first) - base);
                if (j >= stencil.singles)
                    expected += stencil.weights[j] * (at(feature.second) - base);
            }
            double second = base;
            for (std::size_t j = 0; j < stencil.ring_size; ++j)
                second += stencil.second_weight * (at(stencil.ring[j]) - base);
            const auto i = static_cast<std::size_t>(k);
            // Some forty roundings of numbers up to 4000.
            EXPECT_NEAR(forecast.line[i] + stencil.weights[0] * at(kWest), expected, 1e-10);
            EXPECT_NEAR(forecast.second[i], second, 1e-10);
        }
    }
}

/// A rule is trusted once it did better than what was learnt where it had held four times.
TEST(InterpolationRules, TellsWhichRuleHolds) {
    InterpolationRules::Scores scores = {};
    InterpolationRules rules(5, scores);
    const auto code_row = [&] {
        std::vector<std::optional<std::size_t>> found;
        rules.begin_row();
        for (std::int64_t k = 0; k < 5; ++k) {
            found.push_back(rules.find(k));
            rules.learn(k, 100, {140, 201, 300}, 104);  // twice 70, 100.5 and 150
        }
        return found;
    };
    const std::vector<std::optional<std::size_t>> none(5);
    EXPECT_EQ(code_row(), none) << "nothing is known above the first row";
    // Columns 0 and 4 have no neighbours to the west or east, column 1 is the first success.
    const std::vector<std::optional<std::size_t>> second = {{}, {}, 1, 1, {}};
    EXPECT_EQ(code_row(), second);
    const std::vector<std::optional<std::size_t>> third = {{}, 1, 1, 1, {}};
    EXPECT_EQ(code_row(), third);
    // Each success: what was learnt is 8 halves off, beyond rounding 7; the rule is not.
    EXPECT_EQ(scores[1], 6 * 7);

    rules.begin_row();
    for (std::int64_t k = 0; k < 5; ++k) {
        (void)rules.find(k);
        rules.skip(k);
    }
    EXPECT_EQ(code_row(), none) << "holes tell nothing";
}

TEST(DenseTables, FeaturesAreDecodedBeforeTheirSample) {
    for (const Stencil& stencil : kStencils) {
        EXPECT_EQ(stencil.features[0].first.col, kWest.col);
        const bool diagonal = stencil.nearest[0].row != 0 && stencil.nearest[0].col != 0;
        for (const Feature& feature : stencil.features)
            for (const Offset& o : {feature.first, feature.second}) {
                // D samples know the EE ones (odd, odd away), E samples EE and D (odd sum).
                const bool coarser =
                    diagonal ? o.row % 2 != 0 && o.col % 2 != 0 : (o.row + o.col) % 2 != 0;
                const bool before = o.row < 0 || (o.row == 0 && o.col <= 0);
                EXPECT_TRUE(coarser || before) << o.row << ' ' << o.col;
                EXPECT_LE(std::max(std::abs(o.row), std::abs(o.col)), 3);
            }
    }
}

TEST(DenseTables, ScalesHaveFourClassesAnOctave) {
    EXPECT_EQ(octave_class(0), 0U);
    EXPECT_EQ(octave_class(1.0F / 64), 0U);
    EXPECT_EQ(octave_class(1.0F / 32), 1U);
    EXPECT_EQ(octave_class(1.0F / 16), 5U);
    EXPECT_EQ(octave_class(0.99F), 20U);
    EXPECT_EQ(octave_class(1.0F), 21U);
    EXPECT_EQ(octave_class(1.25F), 22U);
    EXPECT_EQ(octave_class(1e30F), kScales - 1);
    EXPECT_EQ(sum_class(0), 0U);
    EXPECT_EQ(sum_class(44), kSums - 1);
    EXPECT_EQ(sum_class(1 << 20), kSums - 1);
}

TEST(Estimate, ApproachesTheFrequencyOfItsDecisions) {
    Estimate estimate;
    EXPECT_EQ(estimate.twelve_bits(), 2048U);
    std::mt19937 engine(1);
    for (int k = 0; k < 20000; ++k) estimate.update(engine() % 8 == 0);
    // A mean over some 1024 decisions: its deviation is sqrt(7 / 64 / 2048) = 0.0073, 30 / 4096.
    EXPECT_NEAR(estimate.twelve_bits(), 512, 4 * 30);
    Estimate same = estimate;
    same.trust_at_most(8);
    EXPECT_EQ(same.twelve_bits(), estimate.twelve_bits());
    same.update(true);
    estimate.update(true);
    // One decision of 8 moves it by 1 / 9.6 of the way, one of 1023 hardly.
    EXPECT_NEAR(same.twelve_bits(), 512 + 3584 / 9.6, 4 * 30);
    EXPECT_NEAR(estimate.twelve_bits(), 512, 4 * 30);
}

}  // namespace
}  // namespace dense
}  // namespace relief::codec
