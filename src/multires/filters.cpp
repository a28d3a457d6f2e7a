#include "relief/multires/filters.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

namespace relief::multires {

namespace {

double binomial(int n, int k) {
    if (k < 0 || k > n) return 0;
    double value = 1;
    for (int i = 1; i <= k; ++i) value = value * (n - k + i) / i;
    return value;
}

Sequence convolve(const Sequence& x, const Sequence& y) {
    Sequence z{x.first + y.first, std::vector<double>(x.taps.size() + y.taps.size() - 1, 0.0)};
    for (std::size_t i = 0; i < x.taps.size(); ++i)
        for (std::size_t j = 0; j < y.taps.size(); ++j) z.taps[i + j] += x.taps[i] * y.taps[j];
    return z;
}

/// p_d: the two-scale sequence of the centred B-spline of order d.
Sequence spline_sequence(int d) {
    Sequence p{d % 2 == 0 ? -d / 2 : -(d - 1) / 2, {}};
    for (int k = 0; k <= d; ++k) p.taps.push_back(std::ldexp(binomial(d, k), 1 - d));
    return p;
}

/// (-1)^n f(1 - n) * scale: the conjugate mirror that turns a low-pass sequence into its dual's
/// high-pass one.
Sequence modulate(const Sequence& f, double scale) {
    Sequence g{1 - f.last(), {}};
    for (int n = g.first; n <= 1 - f.first; ++n)
        g.taps.push_back((n % 2 == 0 ? scale : -scale) * f(1 - n));
    return g;
}

FilterBank compact_bank(int d, int dual) {
    const int order = (d + dual) / 2;
    const Sequence s{-1, {-0.25, 0.5, -0.25}};
    Sequence power{0, {1.0}};
    Sequence sum{-(order - 1), std::vector<double>(static_cast<std::size_t>(2 * order - 1), 0.0)};
    for (int n = 0; n < order; ++n) {
        for (int k = power.first; k <= power.last(); ++k)
            sum.taps[static_cast<std::size_t>(k - sum.first)] +=
                binomial(order - 1 + n, n) * power(k);
        power = convolve(power, s);
    }
    FilterBank bank;
    bank.p = spline_sequence(d);
    bank.a = convolve(spline_sequence(dual), sum);
    for (double& tap : bank.a.taps) tap /= 2;
    const double sign = d % 2 == 1 ? 1 : -1;
    const double kappa = d % 2 == 1 ? 0.5 : 1;
    bank.b = modulate(bank.p, sign * kappa);
    bank.q = modulate(bank.a, sign / kappa);
    return bank;
}

/// (m - 1)! N_m(k), an integer, for the B-spline N_m on [0, m].
std::int64_t scaled_spline_at(int m, int k) {
    if (k <= 0 || k >= m) return m == 1 && k == 0 ? 1 : 0;
    if (m == 2) return 1;
    return k * scaled_spline_at(m - 1, k) + (m - k) * scaled_spline_at(m - 1, k - 1);
}

/// The Chui-Wang wavelet sequence of order d with its centre at 1 (d even) or 1/2 (d odd).
Sequence chui_wang_sequence(int d) {
    double factorial = 1;
    for (int k = 2; k < 2 * d; ++k) factorial *= k;
    Sequence q{d % 2 == 0 ? 1 - (3 * d - 2) / 2 : -(3 * d - 3) / 2, {}};
    for (int k = 0; k <= 3 * d - 2; ++k) {
        double sum = 0;
        for (int l = 0; l <= d; ++l)
            sum += binomial(d, l) * static_cast<double>(scaled_spline_at(2 * d, k - l + 1));
        q.taps.push_back((k % 2 == 0 ? 1 : -1) * std::ldexp(sum, 1 - d) / factorial);
    }
    const int centre = d % 2 == 0 ? 1 : 0;
    if (q(centre) < 0)
        for (double& tap : q.taps) tap = -tap;
    return q;
}

/// Real roots inside the unit circle of the symmetric polynomial with the right half `half` (centre
/// first): bisection of its cosine form on the negative axis, where every D of the family has all
/// of its zeros.
std::vector<double> roots_inside(const std::vector<double>& half) {
    const auto value = [&](double z) {
        double sum = half[0];
        double power = 1;
        for (std::size_t k = 1; k < half.size(); ++k) {
            power *= z;
            sum += half[k] * (power + 1 / power);
        }
        return sum;
    };
    std::vector<double> roots;
    constexpr int steps = 20000;
    double right = -1e-4;
    for (int s = 1; s <= steps; ++s) {
        double left = -static_cast<double>(s) / steps;
        double high = right;
        right = left;
        if ((value(left) < 0) == (value(high) < 0)) continue;
        for (int bisection = 0; bisection < 100; ++bisection) {
            const double middle = (left + high) / 2;
            ((value(middle) < 0) == (value(left) < 0) ? left : high) = middle;
        }
        roots.push_back((left + high) / 2);
    }
    return roots;
}

FilterBank chui_wang_bank(int d) {
    FilterBank bank;
    bank.p = spline_sequence(d);
    bank.q = chui_wang_sequence(d);
    const auto product_at = [](const Sequence& x, const Sequence& y, int shift) {
        double sum = 0;
        for (int n = x.first; n <= x.last(); ++n) sum += x(n) * y(n + shift);
        return sum;
    };
    bank.a = modulate(bank.q, 1);
    if (product_at(bank.a, bank.p, 0) < 0) bank.a = modulate(bank.q, -1);
    bank.b = modulate(bank.p, 1);
    if (product_at(bank.b, bank.q, 0) < 0) bank.b = modulate(bank.p, -1);

    std::vector<double> half;
    for (int k = 0; k < d; ++k) half.push_back(product_at(bank.a, bank.p, 2 * k));
    if (d == 1) {
        for (Sequence* filter : {&bank.a, &bank.b})
            for (double& tap : filter->taps) tap /= half[0];
        return bank;
    }
    bank.poles = roots_inside(half);
    // The sum of D's taps is D(1) = gain * product of (1 - pole)^2.
    bank.gain = half[0];
    for (std::size_t k = 1; k < half.size(); ++k) bank.gain += 2 * half[k];
    double slowest = 0;
    for (const double pole : bank.poles) {
        bank.gain /= (1 - pole) * (1 - pole);
        slowest = std::max(slowest, std::abs(pole));
    }
    bank.margin = static_cast<int>(std::ceil(std::log(1e-16) / std::log(slowest)));
    return bank;
}

/// The taps printed in the paper's appendix B (specification section 4.4): exact synthesis,
/// truncated analysis.
FilterBank truncated_bank(bool corrected) {
    const std::vector<double> a = {0.6830127, 0.3169873,  -0.1160254, -0.0849365, 0.0310889,
                                   0.0227587, -0.0083302, -0.0060982, 0.0022321,  0.0016340};
    std::vector<double> b = {0.8660254, -0.3169873, -0.2320508, 0.0849365,
                             0.0621778, -0.0227587, -0.0166605};
    if (corrected)
        b.insert(b.end(), {0.0060982, 0.0044642});
    else
        b.insert(b.end(), {0.0044642, -0.0016340});
    const auto symmetric = [](const std::vector<double>& half, int centre) {
        const int reach = static_cast<int>(half.size()) - 1;
        Sequence s{centre - reach, {}};
        for (int n = -reach; n <= reach; ++n)
            s.taps.push_back(half[static_cast<std::size_t>(std::abs(n))]);
        return s;
    };
    FilterBank bank = chui_wang_bank(2);
    bank.a = symmetric(a, 0);
    bank.b = symmetric(b, 1);
    bank.poles.clear();
    bank.gain = 1;
    bank.margin = 0;
    return bank;
}

constexpr std::array<std::array<bool, 3>, 8> kLetters = {{{false, false, false},
                                                          {false, false, true},
                                                          {false, true, false},
                                                          {true, false, false},
                                                          {false, true, true},
                                                          {true, false, true},
                                                          {true, true, false},
                                                          {true, true, true}}};

}  // namespace

Result<FilterBank> filter_bank(int order, Family family, int dual_order) {
    if (order < 1 || order > 4)
        return Error{ErrorCode::InvalidArgument,
                     "order " + std::to_string(order) +
                         " does not exist; scheme barycentric has orders 1 to 4",
                     ""};
    if (family == Family::SemiOrthogonal) return chui_wang_bank(order);
    if (family != Family::Compact) {
        if (order != 2)
            return Error{ErrorCode::InvalidArgument,
                         "the paper's truncated filters exist for order 2 only", ""};
        return truncated_bank(family == Family::TruncatedCorrect);
    }
    const int dual = dual_order == 0 ? order : dual_order;
    constexpr std::array<std::array<int, 2>, 9> pairs = {
        {{1, 1}, {1, 3}, {1, 5}, {2, 2}, {2, 4}, {3, 1}, {3, 3}, {4, 2}, {4, 4}}};
    if (std::none_of(pairs.begin(), pairs.end(),
                     [&](auto pair) { return pair[0] == order && pair[1] == dual; }))
        return Error{ErrorCode::InvalidArgument,
                     "dual order " + std::to_string(dual) + " does not exist for order " +
                         std::to_string(order) + "; pairs are 1,1 1,3 1,5 2,2 2,4 3,1 3,3 4,2 4,4",
                     ""};
    return compact_bank(order, dual);
}

std::array<bool, 3> channel_letters(int channel) {
    return kLetters[static_cast<std::size_t>(channel)];
}

const char* channel_name(int channel) {
    constexpr std::array<const char*, 8> names = {"aaa", "aab", "aba", "baa",
                                                  "abb", "bab", "bba", "bbb"};
    return names[static_cast<std::size_t>(channel)];
}

HexKernel project(const Sequence& f, const Sequence& g, const Sequence& h, double scale) {
    HexKernel kernel;
    kernel.box = {f.first - h.last(), g.first - h.last(),
                  f.last() - h.first - (f.first - h.last()) + 1,
                  g.last() - h.first - (g.first - h.last()) + 1};
    kernel.taps.assign(static_cast<std::size_t>(kernel.box.count()), 0.0);
    std::size_t k = 0;
    for (auto i = static_cast<int>(kernel.box.row0); i < kernel.box.row0 + kernel.box.rows; ++i)
        for (auto j = static_cast<int>(kernel.box.col0); j < kernel.box.col0 + kernel.box.cols;
             ++j, ++k)
            for (int l = h.first; l <= h.last(); ++l)
                kernel.taps[k] += scale * f(i + l) * g(j + l) * h(l);
    return kernel;
}

HexKernel analysis_kernel(const FilterBank& bank, int channel) {
    const auto high = channel_letters(channel);
    const auto pick = [&](bool b) -> const Sequence& { return b ? bank.b : bank.a; };
    return project(pick(high[0]), pick(high[1]), pick(high[2]), 1);
}

HexKernel synthesis_kernel(const FilterBank& bank, int channel) {
    const auto high = channel_letters(channel);
    const auto pick = [&](bool b) -> const Sequence& { return b ? bank.q : bank.p; };
    return project(pick(high[0]), pick(high[1]), pick(high[2]), 0.5);
}

}  // namespace relief::multires
