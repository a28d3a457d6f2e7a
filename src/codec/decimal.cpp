#include "codec/decimal.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace relief::codec {

namespace {

struct Decimal {
    double value = 0;  ///< the nearest one
    double last = 0;   ///< what one in the last digit is worth
};

Decimal nearest(double x, int digits) {
    if (!std::isfinite(x) || x == 0) return {x, 0};
    std::array<char, 64> text;
    char* const first = text.data();
    char* const end = first + text.size();
    Decimal decimal{x, 0};
    const char* written =
        std::to_chars(first, end, x, std::chars_format::scientific, digits - 1).ptr;
    std::from_chars(first, written, decimal.value);
    // All digits of x, and the power of ten of the first.
    written = std::to_chars(first, end, x, std::chars_format::scientific).ptr;
    const char* sign = std::find(first, end, 'e') + 1;
    int exponent = 0;
    std::from_chars(sign + 1, written, exponent);
    decimal.last = std::pow(10.0, (*sign == '-' ? -exponent : exponent) - digits + 1);
    return decimal;
}

}  // namespace

double rounded(double x, int digits) {
    return nearest(x, digits).value;
}

double rounded_up(double x, int digits) {
    const Decimal decimal = nearest(x, digits);
    return decimal.value >= x ? decimal.value : rounded(decimal.value + decimal.last, digits);
}

double rounded_down(double x, int digits) {
    const Decimal decimal = nearest(x, digits);
    return decimal.value <= x ? decimal.value : rounded(decimal.value - decimal.last, digits);
}

}  // namespace relief::codec
