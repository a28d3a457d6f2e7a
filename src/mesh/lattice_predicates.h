#pragma once

#include <cmath>
#include <cstdint>

#include "relief/core/vec2.h"

/// Signs of determinants of points whose coordinates are integers of up to 51 bits, held in double.
/// Their differences are exact. Rounded determinants decide when they are larger than their error
/// can be; integers do otherwise.
namespace relief::mesh {

__extension__ using Int128 = __int128;
__extension__ using UInt128 = unsigned __int128;

namespace detail {

inline Int128 whole(double difference) {
    return static_cast<std::int64_t>(difference);
}

inline Int128 exact_cross(Vec2 a, Vec2 b) {
    return whole(a.x) * whole(b.y) - whole(a.y) * whole(b.x);
}

inline Int128 exact_squared_length(Vec2 a) {
    return whole(a.x) * whole(a.x) + whole(a.y) * whole(a.y);
}

/// A sum of products of two integers of up to 2^105: limbs of 64 bits, of which the carries wait.
class WideSum {
  public:
    void add_product(Int128 a, Int128 b) {
        const auto a_low = static_cast<std::uint64_t>(a);
        const auto b_low = static_cast<std::uint64_t>(b);
        const Int128 a_high = a >> 64;
        const Int128 b_high = b >> 64;
        const UInt128 low = UInt128{a_low} * b_low;
        low_ += static_cast<std::uint64_t>(low);
        middle_ += a_high * b_low + b_high * a_low + static_cast<Int128>(low >> 64);
        high_ += a_high * b_high;
    }
    [[nodiscard]] int sign() const {
        const Int128 middle = middle_ + static_cast<Int128>(low_ >> 64);
        const Int128 high = high_ + (middle >> 64);
        if (high < 0) return -1;
        return high > 0 || static_cast<std::uint64_t>(middle) != 0 ||
               static_cast<std::uint64_t>(low_) != 0;
    }

  private:
    UInt128 low_ = 0;
    Int128 middle_ = 0;
    Int128 high_ = 0;
};

inline int sign_of(Int128 value) {
    return (value > 0) - (value < 0);
}

}  // namespace detail

/// Of orient(a, b, c): 1 if they run counter-clockwise, 0 on a line.
inline int exact_orient(Vec2 a, Vec2 b, Vec2 c) {
    constexpr double kError = 4e-16;  // more than 3 x 2^-53: two products and a difference
    const Vec2 ab = b - a;
    const Vec2 ac = c - a;
    const double left = ab.x * ac.y;
    const double right = ab.y * ac.x;
    const double error = kError * (std::abs(left) + std::abs(right));
    if (left - right > error) return 1;
    if (left - right < -error) return -1;
    return detail::sign_of(detail::exact_cross(ab, ac));
}

/// 1 if p lies inside the circle through a, b, c, which run counter-clockwise, 0 on it, -1 outside.
inline int exact_in_circle(Vec2 a, Vec2 b, Vec2 c, Vec2 p) {
    constexpr double kError = 1.2e-15;  // more than 10 x 2^-53, the depth of the expression
    const Vec2 pa = a - p;
    const Vec2 pb = b - p;
    const Vec2 pc = c - p;
    const double sum =
        dot(pa, pa) * cross(pb, pc) + dot(pb, pb) * cross(pc, pa) + dot(pc, pc) * cross(pa, pb);
    const auto size = [](Vec2 u, Vec2 v) { return std::abs(u.x * v.y) + std::abs(u.y * v.x); };
    const double error = kError * (dot(pa, pa) * size(pb, pc) + dot(pb, pb) * size(pc, pa) +
                                   dot(pc, pc) * size(pa, pb));
    if (sum > error) return 1;
    if (sum < -error) return -1;
    detail::WideSum exact;
    exact.add_product(detail::exact_squared_length(pa), detail::exact_cross(pb, pc));
    exact.add_product(detail::exact_squared_length(pb), detail::exact_cross(pc, pa));
    exact.add_product(detail::exact_squared_length(pc), detail::exact_cross(pa, pb));
    return exact.sign();
}

/// The sign of |b| - |a|.
inline int exact_compare_lengths(Vec2 a, Vec2 b) {
    return detail::sign_of(detail::exact_squared_length(b) - detail::exact_squared_length(a));
}

}  // namespace relief::mesh
