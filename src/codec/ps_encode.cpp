#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "codec/decimal.h"
#include "codec/goal_search.h"
#include "codec/ps_chunks.h"
#include "codec/ps_measure.h"
#include "codec/ps_source.h"

namespace relief::codec {

namespace ps = multires::ps;
using Kind = Goal::Kind;
using ps::Update;

namespace {

/// Where searches for errors and for sizes end.
constexpr SearchLimits kOfErrors = {.trials = 16, .close_enough = 0.985, .narrow = 1.001};
constexpr SearchLimits kOfBytes = {.trials = 32, .close_enough = 0.985, .narrow = 1.002};
constexpr double kLeastShare = 1e-6;
/// Quotients are rounded towards zero where squared errors count: fewer bits at the same error.
constexpr double kTowardsZero = 0.42;
constexpr double kNearest = 0.5;
/// Files that keep coefficients: 2^-24 of the largest.
constexpr double kFine = 0x1p-24;
/// What numbers in the final header may take more than those of a trial.
constexpr std::uint64_t kHeaderSlack = 16;

/// A way to code, and what it decodes to.
struct Trial {
    PsHeader header;
    PsContents contents;
    std::vector<LevelHeights> levels;  ///< splines, from the coarsest level on
    VertexValues values;
    PsErrors errors;
    std::int64_t kept = 0;
    double unit = 0;  ///< the step, or the largest error of values

    [[nodiscard]] const LevelHeights& finest() const { return levels.back(); }
};

/// What files of values and of coefficients have in common.
class Encoder {
  public:
    Encoder(const PsSource& source, const PsEncodeOptions& options)
        : source_(source), options_(options) {
        if (!source.data.points.empty()) data_.emplace(source.finest(), source.data);
        for (const ps::Coefficients& spline : source.splines)
            for (const ps::Heights& heights : spline)
                for (const double height : heights) largest_ = std::max(largest_, std::abs(height));
    }
    Encoder(const Encoder&) = delete;
    Encoder& operator=(const Encoder&) = delete;
    virtual ~Encoder() = default;

    Result<EncodedPs> run() {
        RELIEF_CHECK(check_reachable());
        RELIEF_TRY(Trial best, choose());
        if (cancelled(0.95)) return cancelled_error();
        RELIEF_TRY(EncodedPs encoded, finish(std::move(best)));
        if (options_.progress) options_.progress(1);
        return encoded;
    }

  protected:
    [[nodiscard]] virtual Result<Trial> choose() = 0;
    /// Errors of a trial; only the largest one if nothing else is asked for.
    [[nodiscard]] virtual Result<PsErrors> errors_of(const Trial& trial, bool only_max) const = 0;
    /// Squared values or surface minus their coarsest level.
    [[nodiscard]] virtual Result<double> coarsest_square() const = 0;
    [[nodiscard]] virtual std::int64_t number_count() const = 0;

    [[nodiscard]] const ps::Hierarchy& hierarchy() const { return source_.hierarchy; }
    [[nodiscard]] std::size_t components() const { return source_.splines.size(); }

    bool cancelled(double done) {
        done_ = std::max(done_, done);
        return options_.progress && !options_.progress(done_);
    }

    [[nodiscard]] PsHeader header() const {
        PsHeader header;
        header.base = source_.base.header;
        header.components = static_cast<int>(components());
        header.levels = hierarchy().levels();
        header.goal = options_.goal;
        header.reference = source_.reference;
        return header;
    }

    [[nodiscard]] Result<Bytes> file_of(const Trial& trial) const {
        PsContents contents = trial.contents;
        contents.mesh = source_.base.chunk;
        contents.bounds.resize(contents.levels.size());
        return write_ps_file(trial.header, contents);
    }
    [[nodiscard]] std::uint64_t size_of(const Trial& trial) const {
        const auto file = file_of(trial);
        return file.ok() ? file->size() + kHeaderSlack : std::numeric_limits<std::uint64_t>::max();
    }

    /// How much a trial uses up of what the spline leaves of the goal; it is met up to 1. Without
    /// an error there is no more to be had.
    [[nodiscard]] Result<double> share_of(const Trial& trial) const {
        const Goal& goal = options_.goal;
        if (goal.kind == Kind::Bytes) return static_cast<double>(size_of(trial)) / goal.value;
        const bool of_max = goal.kind == Kind::MaxError;
        RELIEF_TRY(const PsErrors errors, errors_of(trial, of_max));
        const double error = of_max ? errors.max : errors.rms();
        if (error == 0) return 1;
        const double used = of_max ? error - missed_ : error * error - missed_ * missed_;
        const double room =
            of_max ? goal.value - missed_ : goal.value * goal.value - missed_ * missed_;
        const double share = of_max ? used / room : std::sqrt(std::max(used, 0.0) / room);
        // Neither roundings nor errors that cancel each other decide.
        return error <= goal.value ? std::clamp(share, kLeastShare, 1.0)
                                   : std::max(share, 1 + kLeastShare);
    }

    /// What `make` makes of a unit, as codec::Tried.
    template <class Make>
    [[nodiscard]] auto trying(Make make) const {
        return [this, make](double unit) -> Result<Tried<Trial>> {
            RELIEF_TRY(Trial trial, make(unit));
            RELIEF_TRY(const double share, share_of(trial));
            return Tried<Trial>{std::move(trial), unit, share};
        };
    }

    /// The trial with the largest unit that meets an error goal; none: no unit down to `least`.
    template <class Make>
    Result<std::optional<Trial>> search_error(double unit, double least, Make make) {
        return largest_unit<Trial>(unit, least, kOfErrors, {.least = 0.01, .most = 100},
                                   trying(make),
                                   [&](double done) { return cancelled(0.9 * done); });
    }

    /// The trial with the smallest unit that meets a goal of bytes.
    template <class Make>
    Result<Trial> search_bytes(double least, double most, Make make) {
        const auto try_unit = trying(make);
        RELIEF_TRY(Tried<Trial> coarsest, try_unit(most));
        if (coarsest.share > 1)
            return bad_argument(
                "no file is that small; the mesh and the numbers of its vertices "
                "take about " +
                std::to_string(size_of(coarsest.candidate)) + " bytes");
        RELIEF_TRY(Tried<Trial> best, bisect(std::move(coarsest), least, kOfBytes, try_unit,
                                             [&](double done) { return cancelled(0.9 * done); }));
        return std::move(best.candidate);
    }

    const PsSource& source_;
    const PsEncodeOptions& options_;
    std::optional<PsDataErrors> data_;
    double largest_ = 0;
    double missed_ = 0;  ///< by the spline before it is coded: the error at the data

  private:
    /// Data may be farther from the spline than the goal allows.
    [[nodiscard]] Status check_reachable() {
        const bool of_errors =
            options_.goal.kind == Kind::MaxError || options_.goal.kind == Kind::RmsError;
        if (!data_ || !of_errors) return {};
        RELIEF_TRY(const PsErrors errors, data_->of(source_.splines));
        missed_ = options_.goal.kind == Kind::MaxError ? errors.max : errors.rms();
        if (missed_ <= options_.goal.value) return {};
        return bad_argument("the spline itself misses the data by " +
                            std::to_string(rounded_up(missed_, 4)) +
                            "; fit it more closely or allow more");
    }

    /// Squared data minus their coarsest level, or their mean.
    [[nodiscard]] Result<double> reference_square() const {
        if (!data_ || hierarchy().levels() > 0) return coarsest_square();
        const PsData& data = source_.data;
        double square = 0;
        for (const std::vector<double>& values : data.values) {
            double sum = 0;
            double all = 0;
            const auto weight = [&](std::size_t k) {
                return data.weights.empty() ? 1 : data.weights[k];
            };
            for (std::size_t k = 0; k < values.size(); ++k) {
                sum += weight(k) * values[k];
                all += weight(k);
            }
            for (std::size_t k = 0; k < values.size() && all > 0; ++k)
                square += weight(k) * ((values[k] - sum / all) * (values[k] - sum / all));
        }
        return square;
    }

    /// What the file says must be what was meant.
    [[nodiscard]] Status verify(const Bytes& bytes, const Trial& trial) const {
        const Error differs{ErrorCode::BadInput,
                            "the decoded file differs from what was encoded; nothing was written. "
                            "Please report this spline",
                            "verification"};
        RELIEF_TRY(const PsFile file, PsFile::open(bytes));
        RELIEF_TRY(const PsSurface surface, file.surface(0));
        const mesh::Triangulation& mesh = file.base();
        if (mesh.origin != source_.base.mesh.origin || mesh.x != source_.base.mesh.x ||
            mesh.y != source_.base.mesh.y || mesh.triangles != source_.base.mesh.triangles)
            return differs;
        for (std::size_t c = 0; c < components(); ++c)
            for (std::size_t v = 0; v < trial.finest()[c].size(); ++v)
                for (std::size_t j = 0; j < 3; ++j)
                    if (ordinal_of(surface.components[c][v][j]) !=
                        ordinal_of(trial.finest()[c][v][j]))
                        return differs;
        if (trial.values.empty()) return {};
        RELIEF_TRY(const PsValues values, file.values());
        return values.components == trial.values ? Status() : differs;
    }

    /// Certified, for each level.
    [[nodiscard]] std::vector<double> bounds_of(const Trial& trial) const {
        std::vector<double> bounds;
        for (int m = 0; m <= hierarchy().levels(); ++m) {
            LevelHeights fine;
            for (const ps::Coefficients& spline : trial.levels[static_cast<std::size_t>(m)])
                fine.push_back(refined(hierarchy(), m, spline));
            bounds.push_back(largest_difference(fine, source_.splines));
        }
        return bounds;
    }

    Result<EncodedPs> finish(Trial trial) {
        RELIEF_TRY(trial.errors, errors_of(trial, false));
        trial.contents.mesh = source_.base.chunk;
        trial.contents.bounds = bounds_of(trial);
        trial.header.max_error = trial.errors.max;
        trial.header.rms_error = trial.errors.rms();
        trial.header.surface_error = trial.contents.bounds.back();
        EncodedPs encoded;
        RELIEF_TRY(encoded.bytes, write_ps_file(trial.header, trial.contents));
        RELIEF_CHECK(verify(encoded.bytes, trial));
        RELIEF_TRY(const double square, reference_square());
        PsReport& report = encoded.report;
        const mesh::Triangulation& base = source_.base.mesh;
        report.vertices = base.vertex_count();
        report.triangles = base.triangle_count();
        report.levels = hierarchy().levels();
        report.delaunay = source_.base.header.peel.has_value();
        report.coefficients = number_count();
        report.samples = data_
                             ? static_cast<std::int64_t>(components() * source_.data.points.size())
                             : report.coefficients;
        report.kept = trial.kept;
        report.bytes = encoded.bytes.size();
        report.base_bytes = source_.base.chunk.size();
        report.bits_per_sample =
            8 * static_cast<double>(report.bytes) / static_cast<double>(report.samples);
        report.max_error = trial.errors.max;
        report.rms_error = trial.errors.rms();
        report.energy_percent = square > 0 ? 100 * trial.errors.square / square : 0;
        report.bound =
            options_.goal.kind == Kind::MaxError ? options_.goal.value : trial.errors.max;
        report.surface_bound = trial.contents.bounds.back();
        return encoded;
    }

    double done_ = 0;
};

class ValueEncoder final : public Encoder {
  public:
    using Encoder::Encoder;

  private:
    [[nodiscard]] const VertexValues& values() const { return source_.values->components; }

    [[nodiscard]] std::int64_t number_count() const override {
        return static_cast<std::int64_t>(components() * values().front().size());
    }

    /// With values that are off by at most `tolerance`.
    [[nodiscard]] Result<Trial> trial(double tolerance) const {
        Trial trial;
        trial.unit = tolerance;
        trial.header = header();
        trial.header.gradients = source_.values->gradients;
        trial.kept = number_count();
        for (const std::vector<double>& component : values()) {
            const ValueLattice lattice = lattice_within(component, tolerance);
            auto& rounded = trial.values.emplace_back();
            for (const double value : component)
                rounded.push_back(lattice.value(lattice.nearest(value)));
            trial.header.lattices.push_back(lattice);
        }
        trial.contents.levels = {
            encode_ps_values(source_.finest().mesh, trial.header.lattices, values())};
        RELIEF_TRY(LevelHeights splines,
                   splines_through(source_.finest(), trial.values, source_.values->gradients));
        trial.levels = {std::move(splines)};
        return trial;
    }

    [[nodiscard]] Result<Trial> choose() override {
        const Goal& goal = options_.goal;
        const auto make = [this](double unit) { return trial(unit); };
        switch (goal.kind) {
            case Kind::Keep:
                return bad_argument(
                    "a spline through values has no details to drop; ask for another goal");
            case Kind::MaxError:
            case Kind::RmsError: {
                if (goal.kind == Kind::MaxError && !data_) return trial(goal.value);
                const double first = goal.kind == Kind::MaxError ? goal.value : 2 * goal.value;
                RELIEF_TRY(std::optional<Trial> best,
                           search_error(first, std::max(goal.value * 1e-6, 1e-290), make));
                if (best) return *std::move(best);
                return trial(0);
            }
            case Kind::Bytes: {
                RELIEF_TRY(Trial exact, trial(0));
                if (static_cast<double>(size_of(exact)) <= goal.value) return exact;
                const double most = largest_ > 0 ? 2 * largest_ : 1;
                return search_bytes(most * 0x1p-60, most, make);
            }
            default:
                return trial(0);
        }
    }

    [[nodiscard]] Result<PsErrors> errors_of(const Trial& trial, bool) const override {
        if (data_) return data_->of(trial.finest());
        PsErrors errors{0, 0, static_cast<double>(number_count())};
        for (std::size_t c = 0; c < components(); ++c)
            for (std::size_t v = 0; v < values()[c].size(); ++v) {
                const double error = std::abs(trial.values[c][v] - values()[c][v]);
                errors.max = std::max(errors.max, error);
                errors.square += error * error;
            }
        return errors;
    }

    [[nodiscard]] Result<double> coarsest_square() const override {
        double square = 0;
        for (const std::vector<double>& component : values()) {
            double mean = 0;
            for (const double value : component)
                mean += value / static_cast<double>(component.size());
            for (const double value : component) square += (value - mean) * (value - mean);
        }
        return square;
    }
};

class SplineEncoder final : public Encoder {
  public:
    using Encoder::Encoder;

  private:
    using Decompositions = std::vector<ps::Decomposition>;  ///< [component]

    [[nodiscard]] std::int64_t number_count() const override {
        return static_cast<std::int64_t>(3 * components() * source_.splines.front().size());
    }

    [[nodiscard]] Result<Decompositions> decomposed(Update update) const {
        Decompositions all;
        for (const ps::Coefficients& spline : source_.splines) {
            RELIEF_TRY(ps::Decomposition one, analyse(hierarchy(), spline, update));
            all.push_back(std::move(one));
        }
        return all;
    }

    [[nodiscard]] Result<Trial> trial(const PsQuantisation& quantisation, double rounding,
                                      const Decompositions& exact) const {
        Trial trial;
        trial.header = header();
        trial.header.quantisation = quantisation;
        trial.header.quantisation.step =
            rounded(std::clamp(quantisation.step, smallest_step() / 8, kLargestPsStep), 4);
        trial.unit = trial.header.quantisation.step;
        PsLevels coder(hierarchy(), source_.finest().mesh.x.size(), trial.header.quantisation);
        Decompositions decoded(components());
        for (int m = 0; m <= hierarchy().levels(); ++m) {
            LevelHeights heights;
            for (const ps::Decomposition& spline : exact)
                heights.push_back(m == 0 ? spline.base
                                         : spline.details[static_cast<std::size_t>(m) - 1]);
            trial.contents.levels.push_back(coder.encode_next(heights, rounding));
            for (std::size_t c = 0; c < components(); ++c) {
                if (m == 0)
                    decoded[c].base = std::move(heights[c]);
                else
                    decoded[c].details.push_back(std::move(heights[c]));
            }
        }
        trial.kept = coder.kept();
        for (int m = 0; m <= hierarchy().levels(); ++m) {
            LevelHeights& level = trial.levels.emplace_back();
            for (std::size_t c = 0; c < components(); ++c) {
                const auto below = static_cast<std::size_t>(m) - 1;
                RELIEF_TRY(ps::Coefficients spline,
                           m == 0 ? decoded[c].base
                                  : synthesise(hierarchy().space(m - 1), hierarchy().step(m - 1),
                                               {trial.levels[below][c], decoded[c].details[below]},
                                               quantisation.update));
                level.push_back(std::move(spline));
            }
        }
        return trial;
    }

    /// The distance of neighbouring heights at the spline's magnitude.
    [[nodiscard]] double smallest_step() const { return std::max(largest_ * 0x1p-52, 1e-290); }

    [[nodiscard]] Result<Trial> choose() override {
        switch (options_.goal.kind) {
            case Kind::MaxError:
            case Kind::RmsError:
                return best_for_error();
            case Kind::Bytes:
                return best_for_bytes();
            case Kind::Keep:
                return keep();
            default:
                return lossless();
        }
    }

    /// Of the ways to choose steps the one with the smallest file.
    Result<Trial> best_for_error() {
        const bool of_max = options_.goal.kind == Kind::MaxError;
        std::optional<Trial> best;
        double first = options_.goal.value;
        for (const auto& way : ways()) {
            RELIEF_TRY(const Decompositions exact, decomposed(way.update));
            const auto make = [&](double unit) {
                PsQuantisation quantisation = way;
                quantisation.step = unit;
                return trial(quantisation, of_max ? kNearest : kTowardsZero, exact);
            };
            RELIEF_TRY(std::optional<Trial> found, search_error(first, smallest_step() / 4, make));
            if (!found) continue;
            first = found->unit;
            if (!best || size_of(*found) < size_of(*best)) best = std::move(found);
        }
        if (best) return *std::move(best);
        return lossless();
    }

    /// Of largest errors, equal steps or such that grow slowly win, by up to 5 per cent each.
    [[nodiscard]] std::vector<PsQuantisation> ways() const {
        if (options_.goal.kind != Kind::MaxError) return {{Update::Semi2Moments, 1, StepLaw::Norm}};
        if (hierarchy().levels() == 0) return {{Update::Semi2Moments, 1, StepLaw::Flat}};
        return {{Update::Semi2Moments, 1, StepLaw::Flat},
                {Update::Semi2Moments, 1, StepLaw::RootNorm}};
    }

    Result<Trial> best_for_bytes() {
        RELIEF_TRY(const Decompositions exact, decomposed(Update::Semi2Moments));
        const auto make = [&](double unit) {
            return trial({Update::Semi2Moments, unit, StepLaw::Norm}, kTowardsZero, exact);
        };
        return search_bytes(smallest_step() / 4, largest_ > 0 ? 4 * largest_ : 1, make);
    }

    /// Heights are corrected to the bit: finer steps cost levels, coarser ones corrections.
    Result<Trial> lossless() {
        RELIEF_TRY(const Decompositions exact, decomposed(Update::None));
        std::vector<ValueLattice> lattices;
        double unit = smallest_step();
        for (const ps::Coefficients& spline : source_.splines) {
            const std::span<const double> numbers(spline.front().data(), 3 * spline.size());
            lattices.push_back(ValueLattice::exact(numbers));
            if (lattices.back().kind == ValueLattice::Kind::Decimal)
                unit = std::max(unit, lattices.back().value(1));
        }
        std::optional<Trial> best;
        double step = 0;
        const auto attempt = [&](double size) -> Result<bool> {
            RELIEF_TRY(Trial found, trial({Update::None, size, StepLaw::Flat}, kNearest, exact));
            found.header.lattices = lattices;
            found.contents.correction =
                write_exact_heights(found.finest(), source_.splines, lattices);
            found.levels.back() = source_.splines;
            found.kept = number_count();
            if (best && size_of(found) >= size_of(*best)) return false;
            best = std::move(found);
            step = size;
            return true;
        };
        RELIEF_TRY(bool better, attempt(2 * unit));
        for (double ratio = 8; ratio > 1.9; ratio = std::sqrt(ratio)) {
            if (cancelled(0.5)) return cancelled_error();
            for (better = true; better && ratio > 2;) {
                RELIEF_TRY(better, attempt(step * ratio));
            }
            RELIEF_TRY(better, attempt(step / ratio));
        }
        return *std::move(best);
    }

    /// Details that change the surface little become zero.
    Result<Trial> keep() {
        RELIEF_TRY(Decompositions some, decomposed(Update::Semi2Moments));
        std::vector<std::pair<double, double*>> details;  // weighted sizes
        for (int m = 0; m < hierarchy().levels(); ++m) {
            RELIEF_TRY(
                const ps::DetailNorms norms,
                detail_norms(hierarchy().space(m), hierarchy().step(m), Update::Semi2Moments));
            for (ps::Decomposition& spline : some) {
                ps::Coefficients& level = spline.details[static_cast<std::size_t>(m)];
                for (std::size_t k = 0; k < level.size(); ++k)
                    for (std::size_t j = 0; j < 3; ++j)
                        details.emplace_back(std::abs(level[k][j]) * norms.l2[k][j], &level[k][j]);
            }
        }
        const auto base = 3 * components() * hierarchy().space(0).mesh.x.size();
        const auto samples = static_cast<double>(data_ ? components() * source_.data.points.size()
                                                       : static_cast<std::size_t>(number_count()));
        const double wanted = options_.goal.value / 100 * samples - static_cast<double>(base);
        const auto count =
            static_cast<std::size_t>(std::clamp(wanted, 0.0, static_cast<double>(details.size())));
        std::nth_element(details.begin(), details.begin() + static_cast<std::ptrdiff_t>(count),
                         details.end(),
                         [](const auto& a, const auto& b) { return a.first > b.first; });
        for (std::size_t k = count; k < details.size(); ++k) *details[k].second = 0;
        return trial(
            {Update::Semi2Moments, std::max(largest_ * kFine, smallest_step()), StepLaw::Flat},
            kNearest, some);
    }

    [[nodiscard]] Result<PsErrors> errors_of(const Trial& trial, bool only_max) const override {
        return errors_between(trial.finest(), only_max);
    }

    [[nodiscard]] Result<PsErrors> errors_between(const LevelHeights& splines,
                                                  bool only_max) const {
        if (data_) return data_->of(splines);
        if (only_max) return PsErrors{largest_difference(splines, source_.splines), 0, 1};
        return surface_errors(source_.finest(), splines, source_.splines);
    }

    [[nodiscard]] Result<double> coarsest_square() const override {
        LevelHeights coarsest;
        RELIEF_TRY(const Decompositions exact, decomposed(Update::Semi2Moments));
        for (const ps::Decomposition& spline : exact) {
            ps::Coefficients heights = refined(hierarchy(), 0, spline.base);
            if (hierarchy().levels() == 0) {
                double mean = 0;
                for (const ps::Heights& h : heights)
                    mean += (h[0] + h[1] + h[2]) / static_cast<double>(3 * heights.size());
                std::fill(heights.begin(), heights.end(), ps::Heights{mean, mean, mean});
            }
            coarsest.push_back(std::move(heights));
        }
        RELIEF_TRY(const PsErrors errors, errors_between(coarsest, false));
        return errors.square;
    }
};

}  // namespace

Result<EncodedPs> encode_ps(const PsModel& model, const PsEncodeOptions& options) {
    RELIEF_CHECK(check_goal(options.goal));
    RELIEF_TRY(const PsSource source, prepare_ps(model, options.keep_order));
    if (source.values) return ValueEncoder(source, options).run();
    return SplineEncoder(source, options).run();
}

}  // namespace relief::codec
