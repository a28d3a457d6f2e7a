#include "codec/goal_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace relief::codec {
namespace {

constexpr SearchLimits kLimits = {.trials = 30, .close_enough = 0.99, .narrow = 1.0001};

bool never(double) {
    return false;
}

/// Shares grow with a power of the unit: the goal is met up to `last`.
auto power_law(double last, double power, std::vector<double>* units = nullptr) {
    return [=](double unit) -> Result<Tried<double>> {
        if (units) units->push_back(unit);
        return Tried<double>{10 * unit, unit, std::pow(unit / last, power)};
    };
}

TEST(GoalSearch, LargestUnitComesCloseForAnyPower) {
    for (const double power : {0.5, 1.0, 1.5})
        for (const double first : {1e-3, 1.0, 400.0}) {
            const auto found =
                largest_unit<double>(first, 0, kLimits, {}, power_law(7, power), never);
            ASSERT_TRUE(found.ok() && *found);
            const double share = std::pow(**found / 10 / 7, power);
            EXPECT_LE(share, 1) << power << ' ' << first;
            EXPECT_GE(share, 0.99) << power << ' ' << first;
        }
}

TEST(GoalSearch, LargestUnitEndsAtAJump) {
    // Shares of 0.5 below 7 and of 2 above: the bracket narrows to it.
    const auto jump = [](double unit) -> Result<Tried<double>> {
        return Tried<double>{unit, unit, unit < 7 ? 0.5 : 2};
    };
    const auto found = largest_unit<double>(1, 0, kLimits, {}, jump, never);
    ASSERT_TRUE(found.ok() && *found);
    EXPECT_LT(**found, 7);
    EXPECT_GT(**found, 7 / 1.0001);
}

TEST(GoalSearch, LargestUnitFindsNothingBelowTheLeast) {
    std::vector<double> units;
    const auto found = largest_unit<double>(8, 3, kLimits, {}, power_law(1, 1, &units), never);
    ASSERT_TRUE(found.ok());
    EXPECT_FALSE(*found);
    for (const double unit : units) EXPECT_GE(unit, 3);
}

TEST(GoalSearch, LargestUnitTakesNoShareThatIsNoNumber) {
    const auto nothing = [](double unit) -> Result<Tried<double>> {
        return Tried<double>{unit, unit, std::numeric_limits<double>::quiet_NaN()};
    };
    const auto found = largest_unit<double>(1, 1e-3, kLimits, {}, nothing, never);
    ASSERT_TRUE(found.ok());
    EXPECT_FALSE(*found);
}

TEST(GoalSearch, BisectionWorksUpwardsAndDownwards) {
    const SearchLimits halvings = {.trials = 60, .close_enough = HUGE_VAL, .narrow = 1.0001};
    const auto larger = bisect(Tried<double>{0, 1, 0}, 1e6, halvings, power_law(7, 1), never);
    ASSERT_TRUE(larger.ok());
    EXPECT_LE(larger->unit, 7);
    EXPECT_GE(larger->unit, 7 / 1.0001);
    EXPECT_EQ(larger->candidate, 10 * larger->unit);
    const auto smaller = bisect(Tried<double>{0, 1e6, 0}, 1, halvings, power_law(7, -1), never);
    ASSERT_TRUE(smaller.ok());
    EXPECT_GE(smaller->unit, 7);
    EXPECT_LE(smaller->unit, 7 * 1.0001);
}

TEST(GoalSearch, BisectionEndsCloseEnough) {
    std::vector<double> units;
    const SearchLimits limits = {.trials = 60, .close_enough = 0.5, .narrow = 1.0001};
    const auto found =
        bisect(Tried<double>{0, 1, 1.0 / 7}, 16, limits, power_law(7, 1, &units), never);
    ASSERT_TRUE(found.ok());
    EXPECT_EQ(units, std::vector<double>({4.0}));  // sqrt(1 x 16), of which 4 / 7 is enough
    EXPECT_EQ(found->unit, 4);
}

TEST(GoalSearch, BothAreCancelled) {
    const auto at_half = [](double done) { return done >= 0.5; };
    const auto stuck = [](double unit) -> Result<Tried<double>> {
        return Tried<double>{unit, unit, 2};
    };
    const auto largest = largest_unit<double>(1, 0, kLimits, {}, stuck, at_half);
    ASSERT_FALSE(largest.ok());
    EXPECT_EQ(largest.error().code, ErrorCode::Cancelled);
    const SearchLimits long_search = {.trials = 10, .close_enough = 1, .narrow = 1};
    const auto nearest = bisect(Tried<double>{0, 1, 0}, 1e9, long_search, stuck, at_half);
    ASSERT_FALSE(nearest.ok());
    EXPECT_EQ(nearest.error().code, ErrorCode::Cancelled);
}

TEST(GoalSearch, GoalsAreChecked) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(check_goal({Goal::Kind::Lossless, nan}).ok());
    EXPECT_TRUE(check_goal({Goal::Kind::MaxError, 0}).ok());
    EXPECT_TRUE(check_goal({Goal::Kind::Bytes, 1}).ok());
    for (const Goal& goal : {Goal{Goal::Kind::MaxError, -1}, Goal{Goal::Kind::RmsError, nan},
                             Goal{Goal::Kind::Keep, HUGE_VAL}, Goal{Goal::Kind::Bytes, 0.5}}) {
        const Status status = check_goal(goal);
        ASSERT_FALSE(status.ok());
        EXPECT_EQ(status.error().code, ErrorCode::InvalidArgument);
    }
}

}  // namespace
}  // namespace relief::codec
