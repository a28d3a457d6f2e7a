#include "codec/sample_rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "relief/core/simd.h"

namespace relief::codec {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Heights with holes and zeros of both signs, long enough for whole vectors and a rest.
struct Row {
    std::vector<double> samples;
    std::vector<std::uint8_t> valid;

    explicit Row(std::size_t n) : samples(n), valid(n) {
        std::mt19937 engine(static_cast<unsigned>(n));
        for (std::size_t k = 0; k < n; ++k) {
            samples[k] = 0.125 * static_cast<double>(engine() % 9000) - 300;
            if (engine() % 7 == 0) samples[k] = engine() % 2 ? 0.0 : -0.0;
            valid[k] = engine() % 5 != 0;
            if (!valid[k]) samples[k] = kNan;
        }
    }
    [[nodiscard]] std::int64_t size() const { return static_cast<std::int64_t>(samples.size()); }
};

/// Calls fn with vectors and without: results must be equal.
template <class Function>
auto on_both(Function fn) {
    const auto vector = fn();
    set_simd_enabled(false);
    const auto scalar = fn();
    set_simd_enabled(true);
    EXPECT_EQ(vector, scalar);
    return vector;
}

TEST(SampleRows, IntegersAreNearestAndClampedAndBack) {
    IntegerDomain domain;
    domain.unit = 0.25;
    domain.origin = -1000;
    domain.highest = 3000;
    for (const std::size_t n : {1U, 7U, 8U, 37U, 200U}) {
        const Row row(n);
        const auto integers = on_both([&] {
            std::vector<std::int32_t> v(n);
            integer_row(row.samples.data(), row.size(), domain, v.data());
            return v;
        });
        const auto values = on_both([&] {
            std::vector<double> back(n);
            value_row(integers.data(), row.size(), domain, back.data());
            return back;
        });
        for (std::size_t k = 0; k < n; ++k) {
            const double exact = row.samples[k] / 0.25 + 1000;
            const double expected = std::isnan(exact) ? 0 : std::clamp(exact, 0.0, 3000.0);
            EXPECT_EQ(integers[k], std::nearbyint(expected));
            EXPECT_EQ(values[k], 0.25 * (integers[k] - 1000));
        }
    }
}

TEST(SampleRows, ErrorsAreZeroInHolesAndJudgedByTheBound) {
    const Row row(77);
    std::vector<double> decoded = row.samples;
    for (double& value : decoded) value += 0.5;
    const auto judge = [&](const std::vector<double>& from, double bound) {
        return on_both([&] {
            std::vector<double> errors(77);
            const RowErrors found = error_row(from.data(), row.samples.data(), row.valid.data(), 77,
                                              bound, errors.data());
            errors.push_back(found.largest);
            errors.push_back(found.within);
            return errors;
        });
    };
    const auto loose = judge(decoded, 0.5);
    for (std::size_t k = 0; k < 77; ++k) EXPECT_EQ(loose[k], row.valid[k] ? 0.5 : 0);
    EXPECT_EQ(loose[77], 0.5);
    EXPECT_EQ(loose[78], 1);
    EXPECT_EQ(judge(decoded, 0.4999)[78], 0);
    EXPECT_EQ(judge(row.samples, 0)[78], 1);
    std::vector<double> flipped = row.samples;
    for (std::size_t k = 0; k < 77; ++k)
        if (row.valid[k] && flipped[k] == 0) flipped[k] = -flipped[k];
    EXPECT_EQ(judge(flipped, 0)[78], 0) << "zeros of another sign are not the same bits";
}

TEST(SampleRows, RangesLeaveHolesOut) {
    Row row(60);
    for (const bool infinite : {false, true}) {
        if (infinite) row.samples[58] = std::numeric_limits<double>::infinity();
        row.valid[58] = 1;
        const auto found = on_both([&] {
            const RowRange range = range_of_row(row.samples.data(), row.valid.data(), 60);
            return std::vector<double>{range.lowest, range.highest, range.finite ? 1.0 : 0.0};
        });
        double lowest = 1e300;
        double highest = -1e300;
        for (std::size_t k = 0; k < 60; ++k)
            if (row.valid[k]) {
                lowest = std::min(lowest, row.samples[k]);
                highest = std::max(highest, row.samples[k]);
            }
        EXPECT_EQ(found, (std::vector<double>{lowest, highest, infinite ? 0.0 : 1.0}));
    }
}

TEST(SampleRows, SamplesOffALatticeAreCounted) {
    Row row(50);
    std::int64_t expected = 0;
    for (std::size_t k = 0; k < 50; ++k) {
        if (k % 4 == 0) row.samples[k] += 0.0625;
        expected += row.valid[k] && std::fmod(row.samples[k], 0.125) != 0;
    }
    ASSERT_GT(expected, 3);
    const auto off = [&](double bound) {
        return on_both([&] {
            std::vector<double> on(50);
            lattice_row(row.samples.data(), 50, 0.125, on.data());
            // A lattice gives no negative zeros back but those that it had.
            return count_off(on.data(), row.samples.data(), row.valid.data(), 50, bound);
        });
    };
    EXPECT_EQ(off(0), expected);
    EXPECT_EQ(off(1), expected) << "a loose bound is no licence: only rounding is";
}

TEST(SampleRows, SquaresAreOfTheDistanceFromALine) {
    const Row row(45);
    const auto squares = [&](const std::uint8_t* valid) {
        return on_both([&] {
            PartialSums sums{};
            std::vector<double> samples = row.samples;
            for (std::size_t k = 0; k < 45; ++k)
                if (!valid && std::isnan(samples[k])) samples[k] = 7;
            add_squares(samples.data(), valid, 45, 10, 0.5, sums);
            return sums;
        });
    };
    for (const std::uint8_t* valid :
         {row.valid.data(), static_cast<const std::uint8_t*>(nullptr)}) {
        PartialSums expected{};
        for (std::size_t k = 0; k < 45; ++k) {
            if (valid && !valid[k]) continue;
            const double sample = std::isnan(row.samples[k]) ? 7 : row.samples[k];
            // Samples are eighths and the line halves: all sums are exact.
            expected[k % 8] += std::pow(sample - (10 + 0.5 * static_cast<double>(k)), 2);
        }
        EXPECT_EQ(squares(valid), expected);
    }
}

TEST(SampleRows, LargestDifferenceLeavesHolesOut) {
    std::vector<std::int32_t> a(70, 5);
    std::vector<std::int32_t> b(70, -2);
    std::vector<std::uint8_t> valid(70, 1);
    a[33] = 1000;
    b[69] = -50;
    const auto largest = [&](const std::uint8_t* mask) {
        return on_both([&] { return largest_difference(a.data(), b.data(), mask, 70); });
    };
    EXPECT_EQ(largest(nullptr), 1002);
    valid[33] = 0;
    EXPECT_EQ(largest(valid.data()), 55);
    valid[69] = 0;
    EXPECT_EQ(largest(valid.data()), 7);
}

}  // namespace
}  // namespace relief::codec
