#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "codec/integer_domain.h"
#include "codec/raster_header.h"
#include "relief/codec/container.h"

namespace relief::codec {
namespace {

/// Hills with so much noise, which is uniform between -noise and noise.
Raster rough_hills(SampleType type, double level, double noise) {
    std::mt19937 engine(11);
    std::uniform_real_distribution<double> uniform(-noise, noise);
    Raster raster;
    raster.rows = 140;
    raster.cols = 150;
    raster.type = type;
    raster.planes.emplace_back(raster.rows, raster.cols);
    for (std::int64_t r = 0; r < raster.rows; ++r)
        for (std::int64_t c = 0; c < raster.cols; ++c) {
            const double height =
                level +
                5 * std::sin(static_cast<double>(r) / 30) * std::cos(static_cast<double>(c) / 40) +
                uniform(engine);
            raster.planes[0](r, c) = stored_value(height, type, {});
        }
    return raster;
}

EncodedRaster lossless(const Raster& raster, Profile profile = Profile::Dense) {
    EncodeOptions options;
    options.goal = {Goal::Kind::Lossless, 0};
    options.profile = profile;
    return *encode_raster(raster, options);
}

IntegerDomain domain_of(const EncodedRaster& file) {
    return read_header(ContainerReader::open(file.bytes)->header())->lattice->domains[0];
}

void expect_same_bits(const Raster& raster, const EncodedRaster& file) {
    const Raster decoded = *RasterFile::open(file.bytes)->decode(0);
    for (std::int64_t r = 0; r < raster.rows; ++r)
        for (std::int64_t c = 0; c < raster.cols; ++c)
            ASSERT_EQ(std::bit_cast<std::uint64_t>(decoded.planes[0](r, c)),
                      std::bit_cast<std::uint64_t>(raster.planes[0](r, c)));
}

TEST(FloatOrdinals, CountFloatsInOrder) {
    constexpr float infinite = std::numeric_limits<float>::infinity();
    constexpr float largest = std::numeric_limits<float>::max();
    EXPECT_EQ(ordinal_of_float(0.0F), 0);
    EXPECT_EQ(ordinal_of_float(-0.0F), -1);
    for (const float x : {-largest, -1.5F, -1e-45F, -0.0F, 0.0F, 1e-45F, 1.0F, 1999.875F}) {
        EXPECT_EQ(float_of_ordinal(ordinal_of_float(x)), x);
        EXPECT_EQ(std::signbit(float_of_ordinal(ordinal_of_float(x))), std::signbit(x));
        if (x == 0) continue;
        EXPECT_EQ(ordinal_of_float(std::nextafter(x, infinite)), ordinal_of_float(x) + 1);
    }
    EXPECT_EQ(float_of_ordinal(1e15), largest);
    EXPECT_EQ(float_of_ordinal(-1e15), -largest);
}

/// Floats around 1000 are 2^-14 apart: noise of +-0.5 has 14 bits, and nothing is gained or lost on
/// them.
TEST(LosslessFloats, CostTheirNoise) {
    for (const Profile profile : {Profile::Dense, Profile::Fast}) {
        const Raster raster = rough_hills(SampleType::Float32, 990, 0.5);
        const EncodedRaster file = lossless(raster, profile);
        EXPECT_TRUE(file.report.closed_loop);
        EXPECT_EQ(file.report.max_error, 0);
        EXPECT_EQ(file.report.corrected, 0);
        EXPECT_TRUE(domain_of(file).floats);
        EXPECT_EQ(domain_of(file).raw_bits > 0, profile == Profile::Dense);
        expect_same_bits(raster, file);
        // Predictions from noisy neighbours add about 0.4 bits to the 14 of the noise.
        if (profile == Profile::Dense) {
            EXPECT_LT(file.report.bits_per_sample, 14.6);
        }
    }
}

TEST(LosslessFloats, KeepZerosOfBothSigns) {
    Raster raster = rough_hills(SampleType::Float32, 0, 0);
    for (std::int64_t r = 0; r < raster.rows; ++r)
        for (std::int64_t c = 0; c < raster.cols; ++c)
            raster.planes[0](r, c) = (r * c) % 5 == 0 ? -0.0 : static_cast<float>(1e-40 * (r % 3));
    const EncodedRaster file = lossless(raster);
    expect_same_bits(raster, file);
}

/// Range and holes: floats of both signs do not fit, and the value of holes may be among them.
TEST(LosslessFloats, ThatDoNotFitAreExactToo) {
    Raster raster = rough_hills(SampleType::Float32, 0, 3);
    raster.nodata = raster.planes[0](5, 6);
    expect_same_bits(rough_hills(SampleType::Float32, 0, 3),
                     lossless(rough_hills(SampleType::Float32, 0, 3)));
    const EncodedRaster file = lossless(raster);
    EXPECT_FALSE(file.report.closed_loop);
}

TEST(RawBits, AreThereWhereQuotientsAreLarge) {
    const Raster steep = rough_hills(SampleType::Int32, 100000, 4000);
    const EncodedRaster large = lossless(steep);
    EXPECT_GE(domain_of(large).raw_bits, 6);
    expect_same_bits(steep, large);
    // log2 8000 = 12.97 bits of noise.
    EXPECT_LT(large.report.bits_per_sample, 13.4);
    EXPECT_EQ(domain_of(lossless(rough_hills(SampleType::Int32, 100000, 5))).raw_bits, 0);
}

/// With a step over 1 they count steps, and the bound holds.
TEST(RawBits, KeepBounds) {
    const Raster steep = rough_hills(SampleType::Int32, 100000, 40000);
    EncodeOptions options;
    options.goal = {Goal::Kind::MaxError, 7};
    const EncodedRaster file = *encode_raster(steep, options);
    EXPECT_GT(domain_of(file).raw_bits, 0);
    EXPECT_EQ(domain_of(file).step, 15);
    EXPECT_EQ(file.report.max_error, 7);
    EXPECT_EQ(file.report.corrected, 0);
}

/// Headers are not trusted.
TEST(RawBits, HeaderMembersOutOfRangeAreNamed) {
    const EncodedRaster file = lossless(rough_hills(SampleType::Int32, 100000, 4000));
    const std::string header = ContainerReader::open(file.bytes)->header();
    for (const auto& [path, value, says] :
         std::vector<std::array<std::string, 3>>{{"/lattice/domains/0/raw_bits", "25", "raw bits"},
                                                 {"/lattice/domains/0/raw_bits", "-1", "raw bits"},
                                                 {"/lattice/domains/0/floats", "1", "floats"},
                                                 {"/lattice/margin", "[1]", "margin"},
                                                 {"/lattice/margin", "[0, 2]", "margin"},
                                                 {"/lattice/margin", "[0, -1]", "margin"},
                                                 {"/lattice/margin", "[\"0\", 0]", "margin"},
                                                 {"/lattice/margin", "1", "margin"}}) {
        auto json = nlohmann::json::parse(header);
        json[nlohmann::json::json_pointer(path)] = nlohmann::json::parse(value);
        const auto read = read_header(json.dump());
        ASSERT_FALSE(read.ok()) << path << " " << value;
        EXPECT_NE(read.error().text().find(says), std::string::npos) << read.error().text();
    }
}

}  // namespace
}  // namespace relief::codec
