#include "rational.h"

#include <algorithm>
#include <cstdlib>

namespace relief::reproduce {

Rational::Integer Rational::divisor(Integer a, Integer b) {
    const bool negative = b < 0;
    while (b != 0) {
        const Integer rest = a % b;
        a = b;
        b = rest;
    }
    return (a < 0) == negative ? a : -a;
}

Rational::Integer Rational::sum(Integer a, Integer b) {
    Integer result = 0;
    if (__builtin_add_overflow(a, b, &result)) std::abort();
    return result;
}

Rational::Integer Rational::product(Integer a, Integer b) {
    Integer result = 0;
    if (__builtin_mul_overflow(a, b, &result)) std::abort();
    return result;
}

std::string Rational::text() const {
    const auto digits = [](Integer n) {
        std::string reversed;
        for (Integer rest = n < 0 ? -n : n; rest != 0; rest /= 10)
            reversed += static_cast<char>('0' + static_cast<int>(rest % 10));
        if (reversed.empty()) reversed = "0";
        if (n < 0) reversed += '-';
        return std::string(reversed.rbegin(), reversed.rend());
    };
    return denominator_ == 1 ? digits(numerator_) : digits(numerator_) + "/" + digits(denominator_);
}

std::optional<std::vector<Rational>> solve(std::vector<std::vector<Rational>> a,
                                           const std::vector<Rational>& b) {
    const std::size_t unknowns = a.front().size();
    for (std::size_t i = 0; i < a.size(); ++i) a[i].push_back(b[i]);
    const auto subtract = [&](std::vector<Rational>& row, const std::vector<Rational>& pivot,
                              std::size_t column) {
        const Rational factor = row[column];
        if (factor.is_zero()) return;
        for (std::size_t k = column; k <= unknowns; ++k)
            if (!pivot[k].is_zero()) row[k] = row[k] - factor * pivot[k];
    };
    for (std::size_t c = 0; c < unknowns; ++c) {
        const auto from = a.begin() + static_cast<std::ptrdiff_t>(std::min(c, a.size()));
        const auto found =
            std::find_if(from, a.end(), [&](const auto& row) { return !row[c].is_zero(); });
        if (found == a.end()) return std::nullopt;
        std::swap(*from, *found);
        const Rational pivot = a[c][c];
        for (Rational& x : a[c]) x = x / pivot;
        for (std::size_t i = 0; i < a.size(); ++i)
            if (i != c) subtract(a[i], a[c], c);
    }
    std::vector<Rational> x;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (i < unknowns)
            x.push_back(a[i][unknowns]);
        else if (!a[i][unknowns].is_zero())
            return std::nullopt;
    }
    return x;
}

}  // namespace relief::reproduce
