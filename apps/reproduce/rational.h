#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// Exact arithmetic, with which the fractions of the source papers are derived.
namespace relief::reproduce {

/// A fraction in lowest terms of numbers below 2^127, in which what is derived here has room:
/// overflow ends the program.
class Rational {
  public:
    __extension__ using Integer = __int128;

    Rational(std::int64_t n = 0, std::int64_t d = 1)
        : Rational(reduced(n, d)) {}  // NOLINT: implicit

    friend Rational operator+(const Rational& a, const Rational& b) {
        const Integer common = divisor(a.denominator_, b.denominator_);
        return reduced(sum(product(a.numerator_, b.denominator_ / common),
                           product(b.numerator_, a.denominator_ / common)),
                       product(a.denominator_, b.denominator_ / common));
    }
    friend Rational operator*(const Rational& a, const Rational& b) {
        const Rational left = reduced(a.numerator_, b.denominator_);
        const Rational right = reduced(b.numerator_, a.denominator_);
        return {Exact(), product(left.numerator_, right.numerator_),
                product(left.denominator_, right.denominator_)};
    }
    friend Rational operator-(const Rational& a) {
        return {Exact(), -a.numerator_, a.denominator_};
    }
    friend Rational operator-(const Rational& a, const Rational& b) { return a + -b; }
    /// Requires: b is not 0.
    friend Rational operator/(const Rational& a, const Rational& b) {
        return a * reduced(b.denominator_, b.numerator_);
    }
    friend bool operator==(const Rational& a, const Rational& b) = default;

    [[nodiscard]] bool is_zero() const { return numerator_ == 0; }
    [[nodiscard]] double value() const {
        return static_cast<double>(numerator_) / static_cast<double>(denominator_);
    }
    /// "3/8", "-2".
    [[nodiscard]] std::string text() const;

  private:
    struct Exact {};
    Rational(Exact, Integer n, Integer d) : numerator_(n), denominator_(d) {}

    /// The greatest common one, with the sign of b.
    static Integer divisor(Integer a, Integer b);
    static Rational reduced(Integer n, Integer d) {
        const Integer common = divisor(n, d);
        return {Exact(), n / common, d / common};
    }
    static Integer sum(Integer a, Integer b);
    static Integer product(Integer a, Integer b);

    Integer numerator_;
    Integer denominator_;  ///< above 0
};

/// Solves A x = b, where x is unique; none where it is not, or where there is none. Rows of A have
/// one length; there may be more rows than unknowns.
[[nodiscard]] std::optional<std::vector<Rational>> solve(std::vector<std::vector<Rational>> a,
                                                         const std::vector<Rational>& b);

}  // namespace relief::reproduce
