#include "relief/multires/curve.h"

#include <algorithm>
#include <string>

#include "relief/core/vec3.h"

namespace relief::multires {

namespace {

/// Of normal equations: rows of P reach three coarse points on, and those of its transpose over old
/// points, beside knots, from two before to two behind.
constexpr std::size_t kHalfWidth = 4;

void add_weight(CurveStep::Row& row, std::size_t point, double weight) {
    for (auto& w : row)
        if (w.point == point) {
            w.weight += weight;
            return;
        }
    row.push_back({point, weight});
}

Error invalid_parameter(const char* text) {
    return {ErrorCode::InvalidArgument, std::string("invalid_parameter: ") + text, "curve"};
}

template <class V>
V weighted(const CurveStep::Row& row, const std::vector<V>& points) {
    V sum{};
    for (const auto& w : row) sum += w.weight * points[w.point];
    return sum;
}

/// Weights of a coarse point, from its own place on.
std::vector<double> mask_of(CurveSplit split) {
    std::vector<double> mask;
    if (split == CurveSplit::Dyadic)
        for (const rules::Fraction& weight : rules::kDyadicCurveMask)
            mask.push_back(weight.value());
    else
        for (const rules::Fraction& weight : rules::kTernaryCurveMask)
            mask.push_back(weight.value());
    return mask;
}

/// The basis functions of coarse knots that make up fine point i of the source paper's ends:
/// discrete B-splines, by the Oslo algorithm.
CurveStep::Row knot_row(std::size_t coarse_count, std::size_t i) {
    const auto count = static_cast<std::ptrdiff_t>(coarse_count);
    const std::ptrdiff_t length = 3 * count - 5;
    const auto coarse = [&](std::ptrdiff_t j) {
        if (j < 4) return std::ptrdiff_t{0};
        return j < count ? 3 * j - 7 : length;
    };
    const auto fine = [&](std::ptrdiff_t j) {
        return std::clamp<std::ptrdiff_t>(j - 3, 0, length);
    };
    const auto first = static_cast<std::ptrdiff_t>(i);
    const std::ptrdiff_t span = fine(first) < 5 ? 3 : std::min(count - 1, (fine(first) + 7) / 3);
    std::array<double, 4> weights{1};
    for (std::ptrdiff_t degree = 1; degree <= 3; ++degree) {
        const std::ptrdiff_t knot = fine(first + degree);
        double carried = 0;
        for (std::ptrdiff_t r = 0; r < degree; ++r) {
            const std::ptrdiff_t low = coarse(span + 1 + r - degree);
            const std::ptrdiff_t high = coarse(span + 1 + r);
            double& weight = weights[static_cast<std::size_t>(r)];
            const double part = weight / static_cast<double>(high - low);
            weight = carried + static_cast<double>(high - knot) * part;
            carried = static_cast<double>(knot - low) * part;
        }
        weights[static_cast<std::size_t>(degree)] = carried;
    }
    CurveStep::Row row;
    for (std::size_t r = 0; r < weights.size(); ++r)
        if (weights[r] != 0) row.push_back({static_cast<std::size_t>(span) - 3 + r, weights[r]});
    return row;
}

}  // namespace

Result<CurveStep> CurveStep::create(std::size_t coarse_count, const CurveOptions& options) {
    const bool closed = options.ends == CurveEnds::Closed;
    const bool ternary = options.split == CurveSplit::Ternary;
    const bool knots = options.ends == CurveEnds::Knots;
    const bool wide =
        options.reversal == CurveReversal::Wide || options.reversal == CurveReversal::Paper;
    if (coarse_count < (closed ? 3U : knots ? 4U : 2U))
        return invalid_parameter("curves need 3 coarse points if closed, 2, or 4 with knots");
    if (wide && !(closed && ternary))
        return invalid_parameter("wide reversal is for closed ternary curves");
    if (knots && !(ternary && options.reversal == CurveReversal::LeastSquares))
        return invalid_parameter("curves with knots are ternary and reversed by least squares");
    return CurveStep(coarse_count, options);
}

CurveStep::CurveStep(std::size_t coarse_count, const CurveOptions& options)
    : coarse_count_(coarse_count), options_(options) {
    if (options.ends == CurveEnds::Knots)
        subdivide_by_knots();
    else
        subdivide_by_mask();
    add_gathering();
    if (is_paper()) {
        add_paper_details();
        return;
    }
    if (options.reversal == CurveReversal::LeastSquares) fit_ = factored(subdivision_);
    for (const Row& row : gathering_) {
        Row& old = old_rows_.emplace_back();
        for (const Weight& w : row)
            if (!is_new(w.point)) old.push_back({w.point / arity(), w.weight});
    }
    old_fit_ = factored(old_rows_);
}

/// Closed curves from both ends in turn, so that neighbours are near.
std::size_t CurveStep::place(std::size_t k) const {
    if (!closed()) return k;
    return 2 * k < coarse_count_ ? 2 * k : 2 * (coarse_count_ - 1 - k) + 1;
}

/// The normal equations of rows over coarse points; ends are fixed.
BandedCholesky CurveStep::factored(const std::vector<Row>& rows) const {
    BandedCholesky matrix(coarse_count_, closed() ? 2 * kHalfWidth : kHalfWidth);
    for (const Row& row : rows)
        for (std::size_t i = 0; i < row.size(); ++i)
            for (std::size_t j = 0; j <= i; ++j)
                if (is_free(row[i].point) && is_free(row[j].point))
                    matrix.add(place(row[i].point), place(row[j].point),
                               row[i].weight * row[j].weight);
    for (std::size_t k = 0; k < coarse_count_; ++k)
        if (!is_free(k)) matrix.add(place(k), place(k), 1);
    // P has independent columns, and its old rows are independent: their condition is below 4.
    [[maybe_unused]] const bool positive = matrix.factor();
    return matrix;
}

/// Symmetric taps on the fine points around an old one.
template <class Taps>
CurveStep::Row CurveStep::taps_around(std::size_t k, const Taps& taps) const {
    const std::size_t count = fine_count();
    Row row;
    for (std::size_t j = 0; j < taps.size(); ++j) {
        add_weight(row, (arity() * k + j) % count, taps[j].value());
        if (j > 0) add_weight(row, (arity() * k + 4 * count - j) % count, taps[j].value());
    }
    return row;
}

void CurveStep::subdivide_by_mask() {
    const std::size_t n = coarse_count_;
    const std::vector<double> mask = mask_of(options_.split);
    // Coarse point k - 1. Beyond the ends points go on straight: 2 c_0 - c_1.
    const auto add_before = [&](Row& row, std::size_t k, double weight) {
        if (closed()) return add_weight(row, (k + n - 1) % n, weight);
        if (k >= 1 && k <= n) return add_weight(row, k - 1, weight);
        add_weight(row, k == 0 ? 0 : n - 1, 2 * weight);
        add_weight(row, k == 0 ? 1 : n - 2, -weight);
    };
    subdivision_.resize(closed() ? arity() * n : arity() * (n - 1) + 1);
    for (std::size_t i = 0; i < subdivision_.size(); ++i) {
        if (!is_new(i) && !is_free(i / arity())) {
            subdivision_[i] = {{i / arity(), 1}};
            continue;
        }
        for (std::size_t r = 0; r < 4; ++r) {
            const std::size_t from = arity() + i % arity();
            const std::size_t to = arity() * r;
            const std::size_t tap = from > to ? from - to : to - from;
            if (tap < mask.size()) add_before(subdivision_[i], i / arity() + r, mask[tap]);
        }
    }
}

void CurveStep::subdivide_by_knots() {
    for (std::size_t i = 0; i < 3 * coarse_count_ - 2; ++i)
        subdivision_.push_back(knot_row(coarse_count_, i));
}

void CurveStep::add_gathering() {
    gathering_.resize(coarse_count_);
    if (options_.reversal == CurveReversal::LeastSquares) {
        for (std::size_t i = 0; i < fine_count(); ++i)
            for (const Weight& w : subdivision_[i])
                if (is_free(w.point)) gathering_[w.point].push_back({i, w.weight});
        return;
    }
    for (std::size_t k = 0; k < coarse_count_; ++k) {
        if (!is_free(k)) continue;
        if (options_.reversal == CurveReversal::Wide)
            gathering_[k] = taps_around(k, rules::kWideReversal);
        else if (is_paper())
            gathering_[k] = taps_around(k, rules::kPaperReversal);
        else if (options_.split == CurveSplit::Ternary)
            gathering_[k] = taps_around(k, rules::kTernaryReversal);
        else
            gathering_[k] = taps_around(k, rules::kDyadicReversal);
    }
}

void CurveStep::add_paper_details() {
    const std::size_t count = fine_count();
    // Taps from 3 k + `from` on, for the detail at 3 k + 1, or mirrored for that at 3 k - 1.
    const auto row = [&](const auto& taps, std::size_t k, std::ptrdiff_t from, bool mirrored) {
        Row result;
        for (std::size_t j = 0; j < taps.size(); ++j) {
            const std::ptrdiff_t offset = from + static_cast<std::ptrdiff_t>(j);
            const std::ptrdiff_t tap =
                static_cast<std::ptrdiff_t>(3 * k + 3 * count) + (mirrored ? -offset : offset);
            add_weight(result, static_cast<std::size_t>(tap) % count, taps[j].value());
        }
        return result;
    };
    for (std::size_t k = 0; k < coarse_count_; ++k)
        for (const bool mirrored : {false, true}) {
            const std::size_t of = mirrored ? (k + 1) % coarse_count_ : k;
            details_.push_back(row(rules::kPaperDetail, of, -4, mirrored));
            corrections_.push_back(row(rules::kPaperCorrection, of, -1, mirrored));
        }
}

template <class V>
std::vector<V> CurveStep::subdivide(const std::vector<V>& coarse) const {
    std::vector<V> fine;
    fine.reserve(fine_count());
    for (const Row& row : subdivision_) fine.push_back(weighted(row, coarse));
    return fine;
}

template <class V>
std::vector<V> CurveStep::gathered(const std::vector<V>& fine) const {
    std::vector<V> sums;
    sums.reserve(coarse_count_);
    for (const Row& row : gathering_) sums.push_back(weighted(row, fine));
    return sums;
}

template <class V>
void CurveStep::solve(const BandedCholesky& matrix, std::vector<V>& coarse) const {
    std::vector<V> x(coarse_count_);
    for (std::size_t k = 0; k < coarse_count_; ++k) x[place(k)] = coarse[k];
    matrix.solve(x.data());
    for (std::size_t k = 0; k < coarse_count_; ++k) coarse[k] = x[place(k)];
}

template <class V>
CurveCoefficients<V> CurveStep::analyse(const std::vector<V>& fine) const {
    // Ends stay, what they say of the others is taken off.
    std::vector<V> ends(coarse_count_);
    if (!closed()) {
        ends.front() = fine.front();
        ends.back() = fine.back();
    }
    std::vector<V> rest = subdivide(ends);
    for (std::size_t i = 0; i < fine.size(); ++i) rest[i] = fine[i] - rest[i];
    CurveCoefficients<V> result{gathered(rest), {}};
    if (options_.reversal == CurveReversal::LeastSquares) solve(fit_, result.coarse);
    for (std::size_t k = 0; k < coarse_count_; ++k) result.coarse[k] += ends[k];
    if (is_paper()) {
        for (const Row& row : details_) result.details.push_back(weighted(row, fine));
        return result;
    }
    const std::vector<V> near = subdivide(result.coarse);
    for (std::size_t i = 0; i < fine.size(); ++i)
        if (is_new(i)) result.details.push_back(fine[i] - near[i]);
    return result;
}

template <class V>
std::vector<V> CurveStep::synthesise(const CurveCoefficients<V>& coefficients) const {
    std::vector<V> fine = subdivide(coefficients.coarse);
    for (std::size_t x = 0; x < corrections_.size(); ++x)
        for (const Weight& w : corrections_[x]) fine[w.point] += w.weight * coefficients.details[x];
    if (is_paper()) return fine;
    std::vector<V> residuals(fine.size());
    for (std::size_t i = 0, x = 0; i < fine.size(); ++i)
        if (is_new(i)) residuals[i] = coefficients.details[x++];
    // Those of old points from (gathering) (residuals) = 0.
    const std::vector<V> known = gathered(residuals);
    std::vector<V> old(coarse_count_);
    for (std::size_t k = 0; k < coarse_count_; ++k)
        for (const Weight& w : old_rows_[k])
            if (is_free(w.point)) old[w.point] += -w.weight * known[k];
    solve(old_fit_, old);
    for (std::size_t k = 0; k < coarse_count_; ++k) residuals[arity() * k] = old[k];
    for (std::size_t i = 0; i < fine.size(); ++i) fine[i] += residuals[i];
    return fine;
}

#define RELIEF_CURVE_OF(V)                                                         \
    template std::vector<V> CurveStep::subdivide(const std::vector<V>&) const;     \
    template CurveCoefficients<V> CurveStep::analyse(const std::vector<V>&) const; \
    template std::vector<V> CurveStep::synthesise(const CurveCoefficients<V>&) const
RELIEF_CURVE_OF(double);
RELIEF_CURVE_OF(Vec3<double>);
#undef RELIEF_CURVE_OF

}  // namespace relief::multires
