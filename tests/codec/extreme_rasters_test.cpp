#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "relief/codec/raster_codec.h"

/// Rasters at the ends of what sample types hold: bounds hold in the type, and lossless is the same
/// bits.
namespace relief::codec {
namespace {

using Kind = Goal::Kind;
constexpr std::array kTypes = {SampleType::UInt8,  SampleType::UInt16, SampleType::Int16,
                               SampleType::UInt32, SampleType::Int32,  SampleType::Float32,
                               SampleType::Float64};

/// value(r, c) as the type stores it.
template <class Value>
Raster make_raster(std::int64_t rows, std::int64_t cols, SampleType type, Value value) {
    Raster raster;
    raster.rows = rows;
    raster.cols = cols;
    raster.type = type;
    Grid<double> plane(rows, cols);
    for (std::int64_t r = 0; r < rows; ++r)
        for (std::int64_t c = 0; c < cols; ++c) plane(r, c) = stored_value(value(r, c), type, {});
    raster.planes.push_back(std::move(plane));
    return raster;
}

void make_hole(Raster& raster, std::int64_t r, std::int64_t c) {
    if (raster.mask.empty()) raster.mask = Grid<std::uint8_t>(raster.rows, raster.cols, 1);
    raster.mask(r, c) = 0;
    for (Grid<double>& plane : raster.planes) plane(r, c) = std::nan("");
}

/// Largest error of the valid samples; infinite when masks differ or, for bound 0, a bit does.
double error_of(const Raster& decoded, const Raster& wanted, bool lossless) {
    double largest = 0;
    for (std::size_t p = 0; p < wanted.planes.size(); ++p)
        for (std::int64_t r = 0; r < wanted.rows; ++r)
            for (std::int64_t c = 0; c < wanted.cols; ++c) {
                if (decoded.valid(r, c) != wanted.valid(r, c))
                    return std::numeric_limits<double>::infinity();
                if (!wanted.valid(r, c)) continue;
                const double have = decoded.planes[p](r, c);
                const double want = wanted.planes[p](r, c);
                if (lossless &&
                    std::bit_cast<std::uint64_t>(have) != std::bit_cast<std::uint64_t>(want))
                    return std::numeric_limits<double>::infinity();
                largest = std::max(largest, std::abs(have - want));
            }
    return largest;
}

/// Encodes and decodes again; bound 0 is lossless. Returns what the encoder reports.
EncodeReport check(const Raster& raster, double bound, Profile profile) {
    const Goal goal = bound == 0 ? Goal{Kind::Lossless, 0} : Goal{Kind::MaxError, bound};
    const auto encoded = encode_raster(raster, {.goal = goal, .profile = profile});
    EXPECT_TRUE(encoded.ok()) << encoded.error().text();
    if (!encoded.ok()) return {};
    const auto file = RasterFile::open(encoded->bytes);
    EXPECT_TRUE(file.ok()) << file.error().text();
    const auto decoded = file->decode(0);
    EXPECT_TRUE(decoded.ok()) << decoded.error().text();
    const double error = error_of(*decoded, raster, bound == 0);
    EXPECT_LE(error, bound);
    EXPECT_GE(encoded->report.max_error, error);
    EXPECT_LE(encoded->report.max_error, bound);
    return encoded->report;
}

void check_all(const Raster& raster, const std::vector<double>& bounds) {
    for (const Profile profile : {Profile::Fast, Profile::Dense})
        for (const double bound : bounds) {
            SCOPED_TRACE(std::string(sample_type_name(raster.type)) + " " + std::to_string(bound));
            check(raster, bound, profile);
        }
}

double noise(std::int64_t r, std::int64_t c) {
    std::uint32_t x = static_cast<std::uint32_t>(r * 7919 + c) * 2654435761U;
    x = (x ^ x >> 15) * 2246822519U;
    return (x >> 8) / 16777216.0;
}

TEST(ExtremeRasters, WithoutValidSamplesAreRefused) {
    Raster raster = make_raster(5, 7, SampleType::Int16, [](auto, auto) { return 3; });
    for (std::int64_t r = 0; r < 5; ++r)
        for (std::int64_t c = 0; c < 7; ++c) make_hole(raster, r, c);
    for (const Goal goal :
         {Goal{Kind::Lossless, 0}, Goal{Kind::MaxError, 1}, Goal{Kind::RmsError, 1}}) {
        const auto encoded = encode_raster(raster, {.goal = goal});
        ASSERT_FALSE(encoded.ok());
        EXPECT_EQ(encoded.error().code, ErrorCode::BadInput);
        EXPECT_NE(encoded.error().message.find("valid"), std::string::npos);
    }
}

TEST(ExtremeRasters, SamplesThatAreNoNumbersAreNamed) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    for (const double bad : {infinity, -infinity, std::nan("")})
        for (const Goal goal : {Goal{Kind::Lossless, 0}, Goal{Kind::MaxError, 1}}) {
            Raster raster =
                make_raster(9, 11, SampleType::Float32, [](auto r, auto c) { return r + c; });
            raster.planes[0](4, 6) = bad;
            const auto encoded = encode_raster(raster, {.goal = goal});
            ASSERT_FALSE(encoded.ok());
            EXPECT_EQ(encoded.error().code, ErrorCode::BadInput);
            EXPECT_NE(encoded.error().where.find("row 4, column 6"), std::string::npos)
                << encoded.error().text();
            make_hole(raster, 4, 6);  // as a hole it is no trouble
            raster.planes[0](4, 6) = bad;
            check(raster, goal.value, Profile::Dense);
        }
}

TEST(ExtremeRasters, SingleSamplesRowsAndColumns) {
    for (const SampleType type : kTypes)
        for (const auto& [rows, cols] : {std::pair{1, 1}, {1, 2}, {2, 1}, {1, 40}, {33, 1}, {2, 2}})
            check_all(
                make_raster(rows, cols, type, [](auto r, auto c) { return 90 * noise(r, c); }),
                {0, 2.5});
}

TEST(ExtremeRasters, ConstantOnesAreExactAndSmall) {
    for (const SampleType type : kTypes)
        for (const double value : {0.0, 17.0, 255.0}) {
            const Raster raster = make_raster(70, 90, type, [&](auto, auto) { return value; });
            for (const Profile profile : {Profile::Fast, Profile::Dense}) {
                const EncodeReport report = check(raster, 0, profile);
                EXPECT_TRUE(report.closed_loop);
                EXPECT_LT(report.bytes, 400U);  // of which most are the header
                EXPECT_EQ(check(raster, 2, profile).max_error, 0);
            }
        }
}

TEST(ExtremeRasters, WholeRangesOfIntegerTypes) {
    for (const SampleType type : kTypes) {
        if (!is_integer(type)) continue;
        const auto [low, high] = sample_range(type);
        check_all(make_raster(21, 34, type,
                              [low = low, high = high](auto r, auto c) {
                                  return low + (high - low) * noise(r, c);
                              }),
                  {0, 1, (high - low) / 300});
        check_all(make_raster(9, 9, type,
                              [low = low, high = high](auto r, auto c) {
                                  return (r + c) % 2 == 0 ? low : high;
                              }),
                  {0, 3});
    }
}

TEST(ExtremeRasters, FloatsNearTheEndsOfTheirRange) {
    for (const SampleType type : {SampleType::Float32, SampleType::Float64}) {
        const double top = sample_range(type).second;
        const Raster any =
            make_raster(20, 31, type, [&](auto r, auto c) { return top * (2 * noise(r, c) - 1); });
        const Raster ends =
            make_raster(6, 5, type, [&](auto r, auto c) { return (r + c) % 2 == 0 ? top : -top; });
        check_all(any, {top / 1000, top / 4});
        check_all(ends, {top / 100});
        if (type == SampleType::Float32) {
            check_all(any, {0});
            check_all(ends, {0});
        }
    }
}

/// Lossless doubles are a transform and corrections: sums of what is larger would overflow.
TEST(ExtremeRasters, LosslessDoublesBeyondTheTransformAreRefused) {
    const auto huge = [](double scale) {
        return make_raster(20, 31, SampleType::Float64,
                           [=](auto r, auto c) { return scale * (2 * noise(r, c) - 1); });
    };
    check_all(huge(1e45), {0});
    const auto encoded = encode_raster(huge(1e300), {.goal = {Kind::Lossless, 0}});
    ASSERT_FALSE(encoded.ok());
    EXPECT_EQ(encoded.error().code, ErrorCode::BadInput);
    EXPECT_NE(encoded.error().message.find("1e45"), std::string::npos) << encoded.error().text();
}

TEST(ExtremeRasters, Denormals) {
    for (const SampleType type : {SampleType::Float32, SampleType::Float64}) {
        const double least = type == SampleType::Float32
                                 ? std::numeric_limits<float>::denorm_min()
                                 : std::numeric_limits<double>::denorm_min();
        check_all(
            make_raster(20, 31, type,
                        [&](auto r, auto c) { return least * std::floor(300 * noise(r, c)); }),
            {0, least, 40 * least, 1});
    }
}

TEST(ExtremeRasters, NegativeZerosKeepTheirSign) {
    for (const SampleType type : {SampleType::Float32, SampleType::Float64})
        for (const int modulus : {2, 150}) {  // half of the samples, and few enough for repairs
            const Raster raster = make_raster(20, 31, type, [&](auto r, auto c) {
                return (r * 31 + c) % modulus == 0 ? -0.0 : std::floor(3 * noise(r, c));
            });
            ASSERT_TRUE(std::signbit(raster.planes[0](0, 0)));
            check_all(raster, {0, 0.4, 1});
        }
}

/// Far away, alone and few: repaired, and neither the domain nor the neighbours suffer.
TEST(ExtremeRasters, OutliersAreRepaired) {
    for (const double outlier : {1e30, -3e38, 2e10}) {
        const auto hills = [](auto r, auto c) {
            return 50 +
                   40 * std::sin(0.1 * static_cast<double>(r)) *
                       std::cos(0.07 * static_cast<double>(c)) +
                   noise(r, c);
        };
        const Raster smooth = make_raster(64, 80, SampleType::Float32, hills);
        const Raster raster = make_raster(64, 80, SampleType::Float32, [&](auto r, auto c) {
            const bool far = (r == 17 && c == 30) || (r == 40 && c == 24) || (r == 63 && c == 79);
            return far ? outlier : hills(r, c);
        });
        for (const Profile profile : {Profile::Fast, Profile::Dense}) {
            const EncodeReport report = check(raster, 0.1, profile);
            const EncodeReport plain = check(smooth, 0.1, profile);
            EXPECT_TRUE(report.closed_loop);
            EXPECT_EQ(report.corrected, 3);
            EXPECT_LT(report.bytes, plain.bytes + 3 * 40);
        }
    }
}

TEST(ExtremeRasters, OutliersOfPrefixesAreWithinTheirBounds) {
    const Raster raster = make_raster(64, 80, SampleType::Float32, [](auto r, auto c) {
        return r == 17 && c == 30 ? 1e30 : 90 * noise(r / 9, c / 9);
    });
    const auto encoded = encode_raster(raster, {.goal = {Kind::MaxError, 0.1}});
    ASSERT_TRUE(encoded.ok());
    const auto source = std::make_shared<MemorySource>(encoded->bytes);
    const auto whole = RasterFile::open(source);
    for (int level = 1; level <= whole->layout().levels(); ++level) {
        const auto prefix = RasterFile::open(source, whole->bytes_for(level));
        ASSERT_TRUE(prefix.ok());
        const auto decoded = prefix->decode_window(0, prefix->box(0));
        ASSERT_TRUE(decoded.ok());
        ASSERT_TRUE(decoded->bound.has_value());
        EXPECT_LE(error_of(decoded->raster, raster, false), *decoded->bound) << level;
        EXPECT_GE(*decoded->bound, 9e29) << level;
    }
}

TEST(ExtremeRasters, IntegerOutliersAreRepaired) {
    const Raster raster = make_raster(50, 60, SampleType::Int32, [](auto r, auto c) {
        return r == 20 && c == 21 ? -2147483648.0 : std::floor(90 * noise(r, c));
    });
    for (const double bound : {0.0, 3.0}) {
        const EncodeReport report = check(raster, bound, Profile::Dense);
        EXPECT_TRUE(report.closed_loop);
        EXPECT_EQ(report.corrected, 1);
    }
}

/// The largest magnitude that all goals take.
double most_of(SampleType type) {
    return std::min(sample_range(type).second, 1e45);
}

/// Samples spread over the whole range of the type, or over a few of its values.
double sample_of(SampleType type, std::mt19937& engine, int spread) {
    const double low = sample_range(type).first;
    const double high = most_of(type);
    const double u = engine() / 4294967296.0;
    if (is_integer(type))
        return spread == 0 ? low + (high - low) * u : std::clamp(low / 2 + spread * u, low, high);
    const double sign = engine() % 2 ? 1 : -1;
    if (spread == 0) return sign * std::exp2(std::log2(high) * (2 * u - 1)) * 0.99;
    return sign * spread * u;
}

TEST(ExtremeRasters, AnyTypeBoundAndMask) {
    EXPECT_TRUE(rc::check([] {
        const auto rows = *rc::gen::inRange<std::int64_t>(1, 30);
        const auto cols = *rc::gen::inRange<std::int64_t>(1, 30);
        const auto type = *rc::gen::elementOf(kTypes);
        const int spread = *rc::gen::element(0, 1, 50, 40000);
        const auto holes = *rc::gen::inRange<std::uint32_t>(0, 4);
        std::mt19937 engine(*rc::gen::arbitrary<std::uint32_t>());
        Raster raster = make_raster(rows, cols, type,
                                    [&](auto, auto) { return sample_of(type, engine, spread); });
        for (std::int64_t r = 0; r < rows; ++r)
            for (std::int64_t c = 0; c < cols; ++c)
                if (r + c > 0 && engine() % 8 < holes) make_hole(raster, r, c);
        const double scale = spread == 0 ? most_of(type) : spread;
        const double bound = *rc::gen::element(0.0, 1e-3, 0.02, 0.5) * scale;
        const auto profile = *rc::gen::element(Profile::Fast, Profile::Dense);
        const Goal goal = bound == 0 ? Goal{Kind::Lossless, 0} : Goal{Kind::MaxError, bound};
        const auto encoded = encode_raster(raster, {.goal = goal, .profile = profile});
        RC_ASSERT(encoded.ok());
        const auto decoded = RasterFile::open(encoded->bytes)->decode(0);
        RC_ASSERT(decoded.ok());
        RC_ASSERT(error_of(*decoded, raster, bound == 0) <= bound);
    }));
}

}  // namespace
}  // namespace relief::codec
