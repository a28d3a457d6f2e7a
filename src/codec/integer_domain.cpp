#include "codec/integer_domain.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "codec/decimal.h"

namespace relief::codec {

namespace {

/// Metres, feet of both kinds, and decimal fractions of them.
constexpr std::array<double, 14> kUnits = {1,    0.5,  0.3048, 1200.0 / 3937, 1 / 3.28084,
                                           0.25, 0.2,  0.1,    0.05,          0.03048,
                                           0.02, 0.01, 0.005,  0.001};
/// Samples without a lattice: so many units in a step make conversion to integers cost next to
/// nothing.
constexpr std::int32_t kFineStep = 63;
/// Enough that rounding lengthens no file, and short in the header.
constexpr int kUnitDigits = 6;
/// Predictions add up neighbours in 32 and 64 bits: samples have 29.
constexpr double kLargestInteger = (1 << 29) - 1;
/// Origins and multiples are exact in double up to here.
constexpr double kExact = 9007199254740992.0;

/// Distance from |x| to the next larger number of the type, of the largest one to the next smaller.
template <class T>
double spacing(T x) {
    x = std::abs(x);
    const T next = std::nextafter(x, std::numeric_limits<T>::infinity());
    return static_cast<double>(std::isfinite(next) ? next - x : x - std::nextafter(x, T{0}));
}

double spacing(double x, SampleType type) {
    return type == SampleType::Float32 ? spacing(static_cast<float>(x)) : spacing(x);
}

double largest_magnitude(const SampleStatistics& s) {
    return std::max(std::abs(s.lowest), std::abs(s.highest));
}

/// An odd step that keeps the bound on a lattice, in units.
double lattice_step(double bound, double unit, double rounding) {
    if (bound < unit) return 1;
    // All multiples of these units are exact floats: stored values are off by whole units.
    const bool exact = std::floor(unit * 1024) == unit * 1024;
    return 2 * std::floor((bound - (exact ? 0 : rounding)) / unit * (1 + 1e-9)) + 1;
}

}  // namespace

double ordinal_of_float(float value) {
    const auto bits = std::bit_cast<std::int32_t>(value);
    return bits < 0 ? ~(bits ^ INT32_MIN) : bits;
}

double float_of_ordinal(double ordinal) {
    constexpr double last = 0x7f7fffff;
    const auto place = static_cast<std::int32_t>(std::clamp(ordinal, -last - 1, last));
    return std::bit_cast<float>(place < 0 ? ~place ^ INT32_MIN : place);
}

void SampleStatistics::add(double sample) {
    if (count++ == 0) {
        lowest = highest = sample;
        return;
    }
    const double before = lowest;
    lowest = std::min(lowest, sample);
    highest = std::max(highest, sample);
    if (step == 1) return;
    const double difference = std::abs(sample - before);
    if (difference == 0) return;
    if (difference > kExact || difference != std::floor(difference)) {
        step = 1;
        return;
    }
    step = static_cast<double>(
        std::gcd(static_cast<std::int64_t>(step), static_cast<std::int64_t>(difference)));
}

void SampleStatistics::add(const SampleStatistics& other) {
    if (other.count == 0) return;
    const std::int64_t both = count + other.count;
    if (count == 0) {
        *this = other;
        return;
    }
    add(other.lowest);
    add(other.highest);
    if (other.step != 0 && step != 1) {
        const double inside = other.step;
        step = step == 0 ? inside
                         : static_cast<double>(std::gcd(static_cast<std::int64_t>(step),
                                                        static_cast<std::int64_t>(inside)));
    }
    count = both;
}

std::optional<double> lattice_candidate(int k) {
    if (k < 0 || k >= static_cast<int>(kUnits.size())) return {};
    return kUnits[static_cast<std::size_t>(k)];
}

std::optional<IntegerDomain> make_domain(const SampleStatistics& s, SampleType type, double unit,
                                         double bound) {
    const double rounding = is_integer(type) ? 0 : spacing(largest_magnitude(s), type);
    IntegerDomain domain;
    domain.rounding = rounding;
    const double fine_bound = bound - rounding / 2;  // the stored value is rounded once more
    if (unit > 0) {
        const double step = lattice_step(bound, unit, rounding);
        // A step that the lattice makes much shorter than the bound allows is worse than none.
        if (is_integer(type) || bound < unit || step * unit >= 2 * fine_bound) {
            domain.unit = unit;
            domain.lattice = true;
            domain.step = static_cast<std::int32_t>(std::min(step, kLargestInteger));
            domain.step |= 1;
        }
    }
    domain.floats = !domain.lattice && bound == 0 && type == SampleType::Float32;
    if (domain.floats) {
        domain.unit = rounding;
    } else if (!domain.lattice) {
        if (!(fine_bound > 0) || is_integer(type)) return {};
        domain.unit = rounded_down(2 * fine_bound / kFineStep, kUnitDigits);
        domain.step = kFineStep;
    }
    const auto integer = [&](double sample) {
        return domain.floats ? ordinal_of_float(static_cast<float>(sample))
                             : std::nearbyint(sample / domain.unit);
    };
    domain.origin = integer(s.lowest);
    const double highest = integer(s.highest) - domain.origin;
    const bool fits = domain.unit > 0 && std::isfinite(domain.unit) &&
                      std::abs(domain.origin) < kExact && highest >= 0 &&
                      highest <= kLargestInteger;
    if (!fits) return {};
    domain.highest = static_cast<std::int32_t>(highest);
    return domain;
}

}  // namespace relief::codec
