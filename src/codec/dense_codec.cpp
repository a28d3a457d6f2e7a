#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "codec/dense_forecast.h"
#include "codec/dense_least_squares.h"
#include "codec/dense_model.h"
#include "codec/dense_rules.h"
#include "codec/lattice_level.h"
#include "codec/range_coder.h"

namespace relief::codec {

namespace {

using namespace dense;

/// The mean error of predictions in one context, in steps.
class Bias {
  public:
    [[nodiscard]] float mean() const { return mean_; }

    void update(float error) {
        mean_ += (error - mean_) * kRates[visits_];
        if (visits_ + 1 < kRates.size()) ++visits_;
    }

  private:
    static constexpr auto kRates = [] {
        std::array<float, kBias.memory - kBias.prior + 1> rates{};
        for (std::size_t n = 0; n < rates.size(); ++n)
            rates[n] = 1 / static_cast<float>(n + kBias.prior);
        return rates;
    }();

    float mean_ = 0;
    std::uint32_t visits_ = 0;
};

/// All that a tile learns from its samples: cheap to copy against coding it.
struct DenseState {
    DenseModel model;
    std::array<RidgeRegression, kKinds> regressions = {RidgeRegression(kStencils[0].weights),
                                                       RidgeRegression(kStencils[1].weights),
                                                       RidgeRegression(kStencils[2].weights)};
    /// [kind][which nearest samples are higher][scale][signs]
    std::array<std::array<std::array<std::array<Bias, kSignPairs>, kCoarseScales>, 16>, kKinds>
        biases;
    std::array<InterpolationRules::Scores, kKinds> rule_scores = {};
    std::uint32_t candidates = 0;  ///< samples that might teach the regressions, in all

    void begin_level() {
        for (RidgeRegression& regression : regressions) regression.fade();
        model.contexts.trust_at_most(kInheritedVisits);
    }
};

static_assert(sizeof(DenseState) < 300 * 1024);

/// floor(x + 0.5) for |x| < 2^30.
std::int32_t nearest_integer(double x) {
    constexpr std::int32_t shift = 1 << 30;
    return static_cast<std::int32_t>(x + (shift + 0.5)) - shift;
}

std::size_t sign_class(std::int32_t q) {
    return static_cast<std::size_t>((q > 0) - (q < 0) + 1);
}

/// Codes one level. One text for encoder and decoder: see range_coder.h.
template <class Coder>
class LevelPass {
  public:
    LevelPass(Coder& coder, DenseState& state, LatticeLevel& level,
              GridView<const std::int32_t> source)
        : coder_(coder),
          quotients_(coder, state.model),
          state_(state),
          level_(level),
          source_(source),
          half_(level.step / 2),
          step_(modelled_step(level)),
          per_step_(1.0 / step_),
          exact_(step_ == 1) {
        if (!exact_) return;
        for (InterpolationRules::Scores& scores : state.rule_scores)
            rules_.emplace_back((level.cols() + 1) / 2, scores);
    }

    void run() {
        state_.begin_level();
        // Margins need no sample of their own pass, and predictors read them.
        fill_diagonal_margins(level_);
        for (std::int64_t r = 1; r < level_.rows(); r += 2) code_row(Kind::Diagonal, r);
        fill_edge_margins(level_);
        for (std::int64_t r = 0; r < level_.rows(); ++r)
            code_row(r % 2 == 0 ? Kind::Horizontal : Kind::Vertical, r);
    }

  private:
    /// Rows of the level, from column 0.
    struct Row {
        std::int64_t index;
        Kind kind;
        const Stencil& stencil;
        double west_weight;
        std::int32_t* values;
        std::int16_t* quotients;
        std::array<const std::int32_t*, 4> nearest;
        std::array<const std::int16_t*, 2> signs;
        InterpolationRules* rules;  ///< null where they do not apply

        [[nodiscard]] std::size_t number() const { return static_cast<std::size_t>(kind); }
    };

    struct Lesson {
        std::int64_t column;
        double weight;
    };

    Row row_of(Kind kind, std::int64_t r) {
        const auto number = static_cast<std::size_t>(kind);
        Row row{.index = r,
                .kind = kind,
                .stencil = kStencils[number],
                .west_weight = state_.regressions[number].weights()[0],
                .values = level_.values.row(r),
                .quotients = level_.quotients.row(r),
                .nearest = {},
                .signs = {},
                .rules = rules_.empty() || kind == Kind::Diagonal ? nullptr : &rules_[number]};
        for (std::size_t n = 0; n < 4; ++n) {
            const Offset offset = row.stencil.nearest[n];
            row.nearest[n] = level_.values.row(r + offset.row) + offset.col;
        }
        for (std::size_t n = 0; n < 2; ++n) {
            const Offset offset = row.stencil.signs[n];
            row.signs[n] = level_.quotients.row(r + offset.row) + offset.col;
        }
        return row;
    }

    void code_row(Kind kind, std::int64_t r) {
        if constexpr (Coder::kDecodes)
            if (coder_.ran_out()) return;
        const Row row = row_of(kind, r);
        forecast_.make(level_, kind, r, state_.regressions[row.number()].weights());
        lessons_.clear();
        if (row.rules) row.rules->begin_row();
        const std::uint8_t* valid = level_.valid.row(r);
        for (std::int64_t k = 0; k < forecast_.count; ++k) {
            const std::int64_t c = forecast_.first + 2 * k;
            const double learnt =
                forecast_.line[static_cast<std::size_t>(k)] + row.west_weight * row.values[c - 2];
            if (valid[c]) {
                code_sample(row, k, learnt);
            } else {
                row.values[c] = nearest_integer(in_range(learnt));
                row.quotients[c] = 0;
                if (row.rules) row.rules->skip(k);
            }
        }
        learn(row);
    }

    [[nodiscard]] double in_range(double p) const {
        return std::clamp<double>(p, level_.lowest, level_.highest);
    }

    void code_sample(const Row& row, std::int64_t k, double learnt) {
        const std::int64_t c = forecast_.first + 2 * k;
        Situation s;
        const float scale = describe(row, k, learnt, s);
        InterpolationRules::Predictions interpolated{};
        std::optional<std::size_t> rule;
        if (row.rules) {
            interpolated = interpolate(row, c);
            rule = row.rules->find(k);
        }
        Bias* bias = nullptr;
        double p = learnt;
        if (rule) {
            p = static_cast<double>(interpolated[*rule]) / 2;
            s.scale = *rule;  // a class below that of kScale.least
        } else {
            bias = &bias_of(row, c, learnt, s);
            p += kBias.share * bias->mean() * step_;
        }
        const std::int32_t q = code_quotient(row, k, p, s);

        // A sample that repeats its prediction says nothing new, unless it is exact.
        const bool echo = q == 0 && !s.exact && level_.raw_bits == 0;
        const auto error = static_cast<float>((row.values[c] - p) * per_step_);
        if (bias) bias->update(echo ? 0 : std::clamp(error, -kBias.error_limit, kBias.error_limit));
        if (row.rules) row.rules->learn(k, row.values[c], interpolated, learnt);
        if (teaches(row, c, q != 0 && !s.exact && scale < kLearning.surprising_below)) {
            const double m = scale;
            const double weight = per_step_ * per_step_ / (m * m + 1);
            lessons_.push_back({c, echo ? kLearning.echo * weight : weight});
        }
    }

    /// Fills all of `s` but what depends on the rounding of the prediction; returns the expected
    /// magnitude.
    float describe(const Row& row, std::int64_t k, double p, Situation& s) const {
        const std::int64_t c = forecast_.first + 2 * k;
        const auto i = static_cast<std::size_t>(k);
        const std::int32_t around =
            forecast_.around[i] + row.stencil.west_share * std::abs(row.quotients[c - 2]);
        const float gap = steps(forecast_.second[i] - p);
        const float scale = forecast_.calm[i] + kScale.around * static_cast<float>(around) +
                            kScale.gap * std::abs(gap);
        s.kind = row.number();
        s.scale = octave_class(scale);
        s.texture = forecast_.texture[i];
        s.sums = sum_class(around >> 1) * kSums + forecast_.inherited[i];
        s.signs = sign_class(row.signs[0][c]) + 3 * sign_class(row.signs[1][c]);
        s.exact = exact_;
        return scale;
    }

    Bias& bias_of(const Row& row, std::int64_t c, double p, const Situation& s) {
        std::size_t higher = 0;
        for (const std::int32_t* nearest : row.nearest) higher = 2 * higher + (nearest[c] > p);
        return state_.biases[s.kind][higher][coarse_scale(s.scale)][s.signs];
    }

    std::int32_t code_quotient(const Row& row, std::int64_t k, double p, Situation& s) {
        const std::int64_t c = forecast_.first + 2 * k;
        const double bounded = in_range(p);
        const std::int32_t predicted = nearest_integer(bounded);
        s.lost = steps(bounded - predicted);
        s.dispute = steps(forecast_.second[static_cast<std::size_t>(k)] - p);
        const int raw_bits = level_.raw_bits;
        const std::int32_t middle = raw_bits > 0 ? 1 << (raw_bits - 1) : 0;
        std::int32_t wanted = middle;
        if constexpr (!Coder::kDecodes) wanted += quotient(source_(row.index, c) - predicted);
        const std::int32_t q = quotients_.code(wanted >> raw_bits, s);
        const std::uint32_t low =
            code_low_bits(coder_, static_cast<std::uint32_t>(wanted), raw_bits);
        row.values[c] = value(predicted, (std::int64_t{q} << raw_bits) + low - middle);
        row.quotients[c] = static_cast<std::int16_t>(std::clamp(q, -kMostStored, kMostStored));
        return q;
    }

    [[nodiscard]] float steps(double distance) const {
        return static_cast<float>(distance) * static_cast<float>(per_step_);
    }

    [[nodiscard]] InterpolationRules::Predictions interpolate(const Row& row,
                                                              std::int64_t c) const {
        const std::array<std::int64_t, 4> n = {row.nearest[0][c], row.nearest[1][c],
                                               row.nearest[2][c], row.nearest[3][c]};
        const Offset d = row.stencil.nearest[1];
        return {n[0] + n[3], n[1] + n[2],
                2 * (2 * n[1] - level_.values(row.index + 2 * d.row, c + 2 * d.col))};
    }

    [[nodiscard]] std::int32_t quotient(std::int32_t residual) const {
        const std::int32_t size = std::abs(residual);
        if (size <= half_) return 0;
        const auto sum = static_cast<std::uint32_t>(size) + static_cast<std::uint32_t>(half_);
        const auto q = static_cast<std::int32_t>(sum / static_cast<std::uint32_t>(level_.step));
        return residual < 0 ? -q : q;
    }

    /// Within what a source can need: altered bytes can ask for more.
    [[nodiscard]] std::int32_t value(std::int32_t predicted, std::int64_t steps) const {
        constexpr std::int64_t most = INT32_MAX;
        steps = std::clamp(steps, -most, most);
        return static_cast<std::int32_t>(std::clamp<std::int64_t>(
            predicted + steps * level_.step, std::int64_t{level_.lowest} - half_,
            std::int64_t{level_.highest} + half_));
    }

    /// Whether the regression learns from a sample.
    bool teaches(const Row& row, std::int64_t c, bool surprising) {
        if (row.index < 2 || c < 2 || c + 1 >= level_.cols()) return false;
        if (surprising || level_.level >= kLearning.every_sample_from) return true;
        return ++state_.candidates % kLearning.stride == 0;
    }

    void learn(const Row& row) {
        const std::int64_t stride = level_.values.stride();
        std::array<std::int64_t, kFeatures> first;
        std::array<std::int64_t, kFeatures> second;
        for (std::size_t j = 0; j < kFeatures; ++j) {
            const Feature& feature = row.stencil.features[j];
            first[j] = feature.first.row * stride + feature.first.col;
            second[j] = feature.second.row * stride + feature.second.col;
        }
        equations_.resize(lessons_.size());
        for (std::size_t k = 0; k < lessons_.size(); ++k) {
            const std::int64_t c = lessons_[k].column;
            const double weight = lessons_[k].weight;
            const std::int32_t* const value = row.values + c;
            double base = 0;
            for (const std::int32_t* nearest : row.nearest) base += nearest[c];
            base *= .25;
            std::array<double, kFeatures> features;
            for (std::size_t j = 0; j < kFeatures; ++j) features[j] = value[first[j]] - base;
            for (std::size_t j = row.stencil.singles; j < kFeatures; ++j)
                features[j] += value[second[j]] - base;
            for (std::size_t j = 0; j < kFeatures; ++j)
                equations_[k].weighted[j] = weight * features[j];
            equations_[k].features = features;
            equations_[k].weighted[kFeatures] = weight * (*value - base);
        }
        state_.regressions[row.number()].learn(equations_);
    }

    static constexpr std::int32_t kMostStored = 30000;

    Coder& coder_;
    QuotientCoder<Coder> quotients_;
    DenseState& state_;
    LatticeLevel& level_;
    GridView<const std::int32_t> source_;
    std::int32_t half_;  ///< the largest error that needs no quotient
    double step_;        ///< of modelled quotients
    double per_step_;
    bool exact_;  ///< q = 0 leaves no doubt, and rules apply
    RowForecast forecast_;
    std::vector<InterpolationRules> rules_;  ///< of each kind, where exact
    std::vector<Lesson> lessons_;
    std::vector<Equation> equations_;
};

class DenseCodec final : public LevelCodec {
  public:
    DenseCodec() : state_(std::make_unique<DenseState>()) {}
    DenseCodec(const DenseCodec& other)
        : LevelCodec(other), state_(std::make_unique<DenseState>(*other.state_)) {}

    bool encode(LatticeLevel& level, GridView<const std::int32_t> source,
                std::vector<std::uint8_t>& out) override {
        CheckedEncoder encoder;
        LevelPass(encoder, *state_, level, source).run();
        const std::vector<std::uint8_t> bytes = encoder.finish();
        out.insert(out.end(), bytes.begin(), bytes.end());
        return encoder.decodes_from(bytes);
    }

    Status decode(LatticeLevel& level, std::span<const std::uint8_t> bytes) override {
        RangeDecoder decoder(bytes);
        LevelPass(decoder, *state_, level, {}).run();
        if (decoder.at_end()) return {};
        return Error{ErrorCode::BadFile,
                     "does not end where its samples end; the file is damaged or cut off",
                     "level data of " + std::to_string(bytes.size()) + " bytes"};
    }

    [[nodiscard]] std::unique_ptr<LevelCodec> descendant() const override {
        return std::make_unique<DenseCodec>(*this);
    }

  private:
    std::unique_ptr<DenseState> state_;
};

}  // namespace

std::unique_ptr<LevelCodec> make_dense_codec() {
    return std::make_unique<DenseCodec>();
}

}  // namespace relief::codec
