#include <fmt/format.h>

#include <map>

#include "rational.h"
#include "relief/multires/curve.h"
#include "reproduce.h"
#include "reverse.h"

/// The filters of boundary curves, section 9 and appendix A, derived in exact arithmetic: A as the
/// least squares solution of AP = I on so many taps, Q as what A takes to 0, T as the left inverse
/// of Q, and B = T (I - P A).
namespace relief::reproduce::reverse {

namespace {

namespace rules = multires::rules;

/// A row or a column: weights of fine points, 3 k being the old ones.
using Taps = std::map<int, Rational>;

Rational at(const Taps& taps, int point) {
    const auto found = taps.find(point);
    return found == taps.end() ? Rational() : found->second;
}

Rational product(const Taps& a, const Taps& b) {
    Rational sum;
    for (const auto& [point, weight] : a) sum = sum + weight * at(b, point);
    return sum;
}

Taps shifted(const Taps& taps, int by) {
    Taps result;
    for (const auto& [point, weight] : taps) result[point + by] = weight;
    return result;
}

/// The column of P of coarse point k.
Taps subdivision(int k) {
    Taps taps;
    for (int j = -4; j <= 4; ++j) {
        const rules::Fraction& mask =
            rules::kTernaryCurveMask[static_cast<std::size_t>(std::abs(j))];
        taps[3 * k + j] = Rational(mask.numerator, mask.denominator);
    }
    return taps;
}

/// Coarse points beyond these have nothing in common with filters around point 0.
constexpr int kReach = 6;

/// The shortest row on taps -width .. width with AP = I: A = y P^T restricted to these taps.
Taps reversal(int width) {
    std::vector<Taps> columns;
    std::vector<Rational> wanted;
    for (int k = -kReach; k <= kReach; ++k) {
        Taps cut;
        for (const auto& [point, weight] : subdivision(k))
            if (std::abs(point) <= width) cut[point] = weight;
        if (cut.empty()) continue;
        columns.push_back(cut);
        wanted.emplace_back(k == 0 ? 1 : 0);
    }
    std::vector<std::vector<Rational>> gram;
    for (const Taps& row : columns) {
        auto& products = gram.emplace_back();
        for (const Taps& column : columns) products.push_back(product(row, column));
    }
    const auto y = solve(gram, wanted);
    Taps result;
    for (std::size_t i = 0; y && i < columns.size(); ++i)
        for (const auto& [point, weight] : columns[i])
            result[point] = at(result, point) + (*y)[i] * weight;
    return result;
}

/// The column of Q of the detail at point 1, on taps -1 .. 3, with 1 at its own point.
Taps correction(const Taps& a) {
    const int points[] = {-1, 0, 2, 3};
    std::vector<std::vector<Rational>> rows;
    std::vector<Rational> wanted;
    for (int k = -kReach; k <= kReach; ++k) {
        const Taps row = shifted(a, 3 * k);
        auto& weights = rows.emplace_back();
        for (const int point : points) weights.push_back(at(row, point));
        wanted.push_back(-at(row, 1));
    }
    Taps q{{1, 1}};
    if (const auto x = solve(rows, wanted))
        for (std::size_t i = 0; i < x->size(); ++i) q[points[i]] = (*x)[i];
    return q;
}

/// The column of Q of any new point: those before old ones are mirror images.
Taps correction_at(const Taps& q, int point) {
    const bool before = ((point % 3) + 3) % 3 == 2;
    if (!before) return shifted(q, point - 1);
    Taps mirrored;
    for (const auto& [tap, weight] : q) mirrored[point + 1 - tap] = weight;
    return mirrored;
}

/// The row of B of the detail at point 1.
Taps detail(const Taps& a, const Taps& q) {
    constexpr int kFirst = -2;
    constexpr int kLast = 4;
    std::vector<std::vector<Rational>> rows;
    std::vector<Rational> wanted;
    for (int point = -3 * kReach; point <= 3 * kReach; ++point) {
        if (point % 3 == 0) continue;
        const Taps column = correction_at(q, point);
        auto& weights = rows.emplace_back();
        bool any = false;
        for (int tap = kFirst; tap <= kLast; ++tap) {
            weights.push_back(at(column, tap));
            any = any || !weights.back().is_zero();
        }
        wanted.emplace_back(point == 1 ? 1 : 0);
        if (any) continue;
        rows.pop_back();
        wanted.pop_back();
    }
    const auto solution = solve(rows, wanted);
    if (!solution) return {};
    Taps t;
    for (std::size_t i = 0; i < solution->size(); ++i)
        t[kFirst + static_cast<int>(i)] = (*solution)[i];
    Taps b = t;
    for (int k = -kReach; k <= kReach; ++k) {
        const Rational share = product(t, subdivision(k));
        for (const auto& [point, weight] : shifted(a, 3 * k))
            b[point] = at(b, point) - share * weight;
    }
    return b;
}

void compare(Rows& rows, const std::string& item, const std::string& name,
             const rules::Fraction& printed, const Rational& derived) {
    const Rational paper(printed.numerator, printed.denominator);
    rows.add(item, name, printed.value(), derived.value(),
             paper == derived ? "exactly " + derived.text() : "derived " + derived.text());
}

/// How many of the products that should be 0 or 1 are so exactly.
void identities(Rows& rows, const Taps& a, const Taps& q, const Taps& b) {
    int wrong = 0;
    for (int k = -kReach; k <= kReach; ++k) {
        wrong += !(product(a, subdivision(k)) == Rational(k == 0 ? 1 : 0));
        wrong += !product(b, subdivision(k)).is_zero();
    }
    for (int point = -3 * kReach; point <= 3 * kReach; ++point) {
        if (point % 3 == 0) continue;
        wrong += !product(a, correction_at(q, point)).is_zero();
        wrong += !(product(b, correction_at(q, point)) == Rational(point == 1 ? 1 : 0));
    }
    rows.add("appendix A", "products of AP, AQ, BP, BQ that are not 0 or 1", 0, wrong,
             "in exact arithmetic");
}

}  // namespace

void add_fractions(Rows& rows) {
    const Taps a = reversal(4);
    const Taps q = correction(a);
    const Taps b = detail(a, q);
    for (int j = 0; j <= 4; ++j)
        compare(rows, "figure 20", fmt::format("a_{}", j),
                rules::kPaperReversal[static_cast<std::size_t>(j)], at(a, j));
    for (int j = 0; j < 5; ++j)
        compare(rows, "appendix (A.2)", fmt::format("q_{}", 5 - j),
                rules::kPaperCorrection[static_cast<std::size_t>(j)], at(q, j - 1));
    for (int j = 0; j < 12; ++j)
        compare(rows, "appendix (A.1)", fmt::format("b_{}", j + 1),
                rules::kPaperDetail[static_cast<std::size_t>(j)], at(b, j - 4));
    identities(rows, a, q, b);
    for (const auto& [width, taps] :
         {std::pair{1, std::vector(rules::kTernaryReversal.begin(), rules::kTernaryReversal.end())},
          {3, std::vector(rules::kWideReversal.begin(), rules::kWideReversal.end())}}) {
        const Taps narrow = reversal(width);
        for (int j = 0; j <= width; ++j)
            rows.add("section 9", fmt::format("{} taps on each side: a_{}", width, j), {},
                     at(narrow, j).value(),
                     (at(narrow, j) == Rational(taps[static_cast<std::size_t>(j)].numerator,
                                                taps[static_cast<std::size_t>(j)].denominator)
                          ? "exactly "
                          : "derived ") +
                         at(narrow, j).text());
    }
}

}  // namespace relief::reproduce::reverse
