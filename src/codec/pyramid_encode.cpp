#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "codec/corrections.h"
#include "codec/decimal.h"
#include "codec/pyramid_code.h"
#include "codec/pyramid_encode.h"
#include "codec/pyramid_search.h"
#include "codec/raster_header.h"
#include "codec/surface_error.h"
#include "codec/tile_masks.h"
#include "relief/codec/container.h"
#include "relief/codec/fill.h"
#include "relief/core/parallel.h"

namespace relief::codec {

namespace {

using multires::Planes;

/// Bounds below so many of a float type's steps may cost more than exactness.
constexpr double kNearlyExact = 64;

/// One way to code the raster: quantised coefficients, the surface they give, how far it is off,
/// and the coded chunks.
struct Candidate {
    PyramidCoding coding;
    QuantisedPyramid quantised;
    Planes<double> surface;
    SurfaceError error;
    std::optional<Corrections> corrections;
    std::vector<Bytes> chunks;
    Bytes correction;
};

class Encoder {
  public:
    Encoder(const Raster& raster, const multires::SchemeSpec& spec, const EncodeOptions& options)
        : raster_(raster), spec_(spec), options_(options) {}

    Result<EncodedRaster> run() {
        RELIEF_CHECK(check());
        RELIEF_CHECK(analyse());
        // The bounds in the header, which are measured last, may take more bytes than was thought.
        for (double most = options_.goal.value;;) {
            RELIEF_TRY(Candidate best, choose(most));
            if (cancelled(0.8)) return cancelled_error();
            RELIEF_TRY(EncodedRaster encoded, finish(std::move(best)));
            const double over = static_cast<double>(encoded.bytes.size()) - options_.goal.value;
            if (options_.goal.kind != Kind::Bytes || over <= 0) {
                if (options_.progress) options_.progress(1);
                return encoded;
            }
            most -= over;
        }
    }

  private:
    using Kind = Goal::Kind;

    Status check() {
        RELIEF_CHECK(check_goal(options_.goal));
        if (raster_.rows < 1 || raster_.cols < 1 || raster_.planes.empty())
            return Error{ErrorCode::BadInput, "the raster is empty; it needs at least one sample",
                         ""};
        samples_ = raster_.valid_count();
        if (samples_ == 0)
            return Error{ErrorCode::BadInput,
                         "no sample is valid: every one is NODATA or not a number", ""};
        RELIEF_CHECK(check_samples(raster_, 0, 0));
        return {};
    }

    Status analyse() {
        for (const Grid<double>& plane : raster_.planes)
            filled_.push_back(filled(plane.view(), raster_.mask));
        for (const Grid<double>& plane : filled_) target_.planes.push_back(plane.view());
        if (!raster_.mask.empty()) target_.mask = raster_.mask.view();
        RELIEF_TRY(pyramid_, multires::analyse<double>(target_.planes, spec_));
        scratch_ = Pyramid<double>::allocate(pyramid_.layout);
        means_ = means_of(pyramid_.bands[0]);
        return {};
    }

    /// most: of a goal in bytes.
    Result<Candidate> choose(double most) {
        const Goal& goal = options_.goal;
        switch (goal.kind) {
            case Kind::Keep:
                return keep();
            case Kind::Bytes:
                return search_bytes(most);
            case Kind::RmsError:
                return search_rms();
            case Kind::MaxError:
                return search_bounded(goal.value);
            case Kind::Lossless:
                break;
        }
        return search_bounded(0);
    }

    Planes<double> surface_of(const Candidate& candidate, int plane = 0, int finest_level = 0) {
        reconstruct(candidate.quantised, candidate.coding, plane, finest_level, scratch_);
        return multires::synthesise(scratch_);
    }

    void evaluate(Candidate& candidate) {
        candidate.surface = surface_of(candidate);
        candidate.error = surface_error(raster_, candidate.surface);
    }

    Candidate quantised(const Pyramid<double>& pyramid, double step) const {
        Candidate candidate;
        candidate.coding.means = means_;
        const double least = least_step(pyramid, means_);
        candidate.coding.step = rounded_up(std::clamp(step, least, kLargestStep), 6);
        candidate.quantised = quantise(pyramid, candidate.coding);
        return candidate;
    }

    /// The pyramid whose coefficients are to be quantised with a step.
    Pyramid<double> improved(double step) const {
        return codec::improved(copy_of(pyramid_), target_, {.step = step, .means = means_},
                               options_.effort);
    }

    /// Codes the streams, which drops some values, and measures what is left.
    Status code(Candidate& candidate) {
        const StreamLayout streams(pyramid_.layout);
        RELIEF_TRY(const std::vector<CodedStream> coded,
                   encode_streams(pyramid_.layout, streams, candidate.quantised));
        candidate.coding.layers = choose_layers(coded);
        candidate.chunks = chunks_of(coded, candidate.coding.layers);
        evaluate(candidate);
        return {};
    }

    Result<Candidate> at_step(double step) {
        Candidate candidate = quantised(improved(step), step);
        RELIEF_CHECK(code(candidate));
        return candidate;
    }

    std::uint64_t size_of(Candidate& candidate) const {
        if (candidate.corrections) candidate.correction = write_corrections(*candidate.corrections);
        const auto file = assemble(candidate, {}, candidate.error);
        return file.ok() ? file->size() : std::numeric_limits<std::uint64_t>::max();
    }

    Result<Candidate> keep() {
        const double share = options_.goal.value / 100;
        const double wanted =
            std::min(share * static_cast<double>(raster_.rows * raster_.cols), 9e18);
        Pyramid<double> chosen = copy_of(pyramid_);
        const Selection selection = codec::choose(
            chosen, static_cast<std::int64_t>(std::llround(wanted)), target_, options_.effort);
        kept_ = selection.kept;
        Candidate candidate;
        candidate.coding = fine_coding(chosen, means_);
        candidate.quantised = quantise(chosen, candidate.coding);
        candidate.quantised.worths.clear();
        RELIEF_CHECK(code(candidate));
        return candidate;
    }

    /// As codec::search, and reports progress.
    template <class Make, class MeasureOf>
    Result<std::optional<Candidate>> search(double unit, bool growing, double close_enough,
                                            Make make, MeasureOf measure_of) {
        return codec::search<Candidate>(unit, growing, close_enough, make, measure_of,
                                        [&](double done) { return cancelled(0.1 + 0.7 * done); });
    }

    /// First without coding; then, for values that are dropped make the error larger, with it.
    Result<Candidate> search_rms() {
        const double goal = options_.goal.value;
        if (goal > 0) {
            const auto measure = [&](const Candidate& candidate) {
                return candidate.error.rms(samples_) / goal;
            };
            const auto quantise_only = [&](double step) -> Result<Candidate> {
                Candidate candidate = quantised(improved(step), step);
                evaluate(candidate);
                return candidate;
            };
            RELIEF_TRY(std::optional<Candidate> found,
                       search(4 * goal, true, 0.95, quantise_only, measure));
            if (found) {
                RELIEF_TRY(found, search(
                                      0.97 * found->coding.step, true, 0.995,
                                      [&](double step) { return at_step(step); }, measure));
            }
            if (found) return *std::move(found);
        }
        return search_bounded(0);  // nearer than quantising comes
    }

    Result<Candidate> search_bytes(double goal) {
        RELIEF_TRY(Candidate nothing, at_step(step_above_all()));
        const std::uint64_t least = size_of(nothing);
        if (static_cast<double>(least) > goal)
            return Error{ErrorCode::InvalidArgument,
                         "no file is that small; this raster's header and structure alone take " +
                             std::to_string(least) + " bytes",
                         ""};
        // A start from the spread of the data: about one bit a sample at a third of its deviation.
        const double bits = 8 * goal / static_cast<double>(samples_);
        const double spread = surface_error(raster_, nothing.surface).rms(samples_);
        if (!(spread > 0)) return nothing;
        RELIEF_TRY(std::optional<Candidate> found,
                   search(
                       std::max(8 * spread * std::exp2(-2 * bits), 1e-6 * spread), false, 0.997,
                       [&](double step) { return at_step(step); },
                       [&](Candidate& candidate) {
                           return static_cast<double>(size_of(candidate)) / goal;
                       }));
        return found ? *std::move(found) : std::move(nothing);
    }

    /// A step with which every coefficient is quantised to zero.
    [[nodiscard]] double step_above_all() const {
        return std::max(4 * 0x1p29 * least_step(pyramid_, means_), 1e-290);
    }

    /// A candidate with its corrections and the size of its file.
    struct Corrected {
        Candidate candidate;
        std::uint64_t size = std::numeric_limits<std::uint64_t>::max();
    };

    /// The smaller of a file within the bound and, where that might be smaller, an exact one.
    Result<Candidate> search_bounded(double bound) {
        RELIEF_TRY(Corrected best, search_corrected(bound));
        if (bound > 0 && !is_integer(raster_.type) && bound < kNearlyExact * smallest_step()) {
            RELIEF_TRY(Corrected exact, search_corrected(0));
            if (exact.size < best.size) best = std::move(exact);
        }
        return std::move(best.candidate);
    }

    /// The file with the step, in units of the bound, that makes it smallest with corrections:
    /// found without least squares, by a walk with falling ratios.
    Result<Corrected> search_corrected(double bound) {
        const bool exact = bound == 0;
        const double quantum = smallest_step();
        const double scale = std::max(exact ? quantum : bound, quantum);
        Corrected best;
        double factor = exact ? 2.0 : 2.35;
        // Returns whether it is the smallest so far.
        const auto attempt = [&](const Pyramid<double>& pyramid, double f) -> Result<bool> {
            Candidate candidate = quantised(pyramid, f * scale);
            RELIEF_CHECK(code(candidate));
            candidate.corrections = make_corrections(raster_, candidate.surface, bound);
            const std::uint64_t size = size_of(candidate);
            if (size >= best.size) return false;
            best = {std::move(candidate), size};
            return true;
        };
        RELIEF_TRY([[maybe_unused]] const bool first, attempt(pyramid_, factor));
        for (double ratio = 2; ratio > 1.1; ratio = std::sqrt(ratio)) {
            if (cancelled(0.3)) return cancelled_error();
            RELIEF_TRY(const bool coarser, attempt(pyramid_, factor * ratio));
            if (coarser) {
                factor *= ratio;
                continue;
            }
            RELIEF_TRY(const bool finer, attempt(pyramid_, factor / ratio));
            if (finer) factor /= ratio;
        }
        if (options_.effort != Effort::Select) {
            RELIEF_TRY([[maybe_unused]] const bool refitted,
                       attempt(improved(factor * scale), factor));
        }
        return best;
    }

    /// The distance of neighbouring values of the sample type at the raster's magnitude.
    [[nodiscard]] double smallest_step() const {
        if (is_integer(raster_.type)) return 1;
        double largest = 0;
        for (const Grid<double>& plane : filled_)
            for (std::int64_t r = 0; r < plane.rows(); ++r)
                for (std::int64_t c = 0; c < plane.cols(); ++c)
                    largest = std::max(largest, std::abs(plane(r, c)));
        const double epsilon = raster_.type == SampleType::Float32 ? 0x1p-24 : 0x1p-53;
        return std::max(largest * epsilon, 1e-290);
    }

    /// The file of a candidate whose chunks are coded.
    /// layer_errors: largest ones, one for each layer; none if they are not known yet.
    Result<Bytes> assemble(const Candidate& candidate, const std::vector<double>& layer_errors,
                           const SurfaceError& final_error) const {
        RasterHeader header;
        header.description = description_of(raster_);
        header.components = static_cast<int>(raster_.planes.size());
        header.has_mask = !raster_.mask.empty();
        header.spec = pyramid_.layout.spec;
        header.goal = options_.goal;
        header.max_error = final_error.max;
        header.rms_error = final_error.rms(samples_);
        header.pyramid = candidate.coding;
        // Room for the bounds of levels that are not known yet.
        const auto levels = static_cast<std::size_t>(pyramid_.layout.levels());
        header.pyramid.bounds.resize(levels, rounded_up(final_error.max, 3));

        ContainerWriter writer;
        writer.add({});  // no edits
        if (header.has_mask) add_masks(writer);
        constexpr double unknown = std::numeric_limits<double>::infinity();
        const std::size_t layers = candidate.coding.layers.size();
        const ChunkOrder order{layers, candidate.chunks.size() / layers};
        std::vector<double> bounds(order.count(), unknown);
        for (std::size_t k = 0; k < layer_errors.size(); ++k)
            bounds[order.end_of(k)] = layer_errors[k];
        for (std::size_t k = 0; k < bounds.size(); ++k) writer.add(candidate.chunks[k], bounds[k]);
        writer.add(candidate.correction, final_error.max);
        return writer.finish(write_header(header));
    }

    void add_masks(ContainerWriter& writer) const {
        const TileTree tree(raster_.rows, raster_.cols);
        for (const std::int64_t tile : tree.hilbert_order(0))
            writer.add(encode_tile_mask(part_of(raster_.mask.view(), tree.box(0, tile))));
    }

    /// Largest errors of the surfaces that the first layers give.
    std::vector<double> errors_by_layer(const Candidate& candidate) {
        std::vector<double> errors;
        for (const int plane : candidate.coding.layers)
            errors.push_back(plane == 0 ? candidate.error.max
                                        : surface_error(raster_, surface_of(candidate, plane)).max);
        return errors;
    }

    /// Largest errors of the surfaces without details of level 1, of 2 and 1, .. at all samples.
    /// They hold for the rasters of the levels too, whose border is extrapolated at that level and
    /// may differ from the surface.
    std::vector<double> errors_by_level(const Candidate& candidate) {
        std::vector<double> errors;
        for (int level = 1; level <= pyramid_.layout.levels(); ++level) {
            const double error = surface_error(raster_, surface_of(candidate, 0, level)).max;
            errors.push_back(rounded_up(
                std::max(error, largest_error_of_level(
                                    raster_, multires::synthesise(scratch_, level), level)),
                3));
        }
        return errors;
    }

    Result<EncodedRaster> finish(Candidate best) {
        const std::vector<double> layer_errors = errors_by_layer(best);
        best.coding.bounds = errors_by_level(best);
        SurfaceError final_error = best.error;
        if (best.corrections) {
            apply_corrections(*best.corrections, raster_.type, raster_.nodata,
                              {0, 0, raster_.rows, raster_.cols}, best.surface);
            final_error = surface_error(raster_, best.surface);
        }
        EncodedRaster result;
        RELIEF_TRY(result.bytes, assemble(best, layer_errors, final_error));
        RELIEF_CHECK(verify(result.bytes, final_error));

        EncodeReport& report = result.report;
        report = size_report(raster_, result.bytes.size());
        report.spec = pyramid_.layout.spec;
        report.coefficients = pyramid_.layout.coefficients();
        report.kept = kept_ > 0 ? kept_ : count_kept(best.quantised);
        report.corrected = best.corrections ? best.corrections->corrected : 0;
        set_errors(report, final_error, samples_, detail_energy_of_pyramid());
        report.bound = options_.goal.kind == Kind::MaxError ? options_.goal.value : final_error.max;
        return result;
    }

    double detail_energy_of_pyramid() {
        for (std::size_t k = 0; k < pyramid_.bands.size(); ++k)
            for (std::size_t p = 0; p < pyramid_.bands[k].size(); ++p)
                for (std::int64_t r = 0; r < pyramid_.bands[k][p].rows(); ++r)
                    if (k == 0)
                        std::copy_n(pyramid_.bands[k][p].row(r), pyramid_.bands[k][p].cols(),
                                    scratch_.bands[k][p].row(r));
                    else
                        std::fill_n(scratch_.bands[k][p].row(r), scratch_.bands[k][p].cols(), 0.0);
        const Planes<double> coarse = multires::synthesise(scratch_);
        double energy = 0;
        for (std::size_t p = 0; p < coarse.size(); ++p)
            for (std::int64_t r = 0; r < raster_.rows; ++r)
                for (std::int64_t c = 0; c < raster_.cols; ++c)
                    if (raster_.valid(r, c))
                        energy += std::pow(raster_.planes[p](r, c) - coarse[p](r, c), 2);
        return energy;
    }

    /// What was written is decoded and compared: the bound is of the file, not of an intention.
    Status verify(const Bytes& bytes, const SurfaceError& expected) {
        RELIEF_TRY(const RasterFile file, RasterFile::open(bytes));
        RELIEF_TRY(const Raster decoded, file.decode(0));
        const SurfaceError found = surface_error(raster_, decoded.planes);
        const bool over = options_.goal.kind == Kind::MaxError && found.max > options_.goal.value;
        if (found.max == expected.max && found.square == expected.square && !over) return {};
        return Error{ErrorCode::BadFile,
                     "the decoded file differs from what was encoded (error " +
                         std::to_string(found.max) + " instead of " + std::to_string(expected.max) +
                         "); nothing was written. Please report this",
                     "verification"};
    }

    bool cancelled(double done) {
        done_ = std::max(done_, done);
        return options_.progress && !options_.progress(done_);
    }

    friend Result<double> relief::codec::pyramid_energy(const Raster&, const multires::SchemeSpec&);

    const Raster& raster_;
    const multires::SchemeSpec& spec_;
    const EncodeOptions& options_;
    std::int64_t samples_ = 0;
    Planes<double> filled_;
    Target target_;
    Pyramid<double> pyramid_;
    Pyramid<double> scratch_;
    std::vector<double> means_;  ///< of the scaling band
    std::int64_t kept_ = 0;      ///< by choice
    double done_ = 0;
};

}  // namespace

Result<EncodedRaster> encode_pyramid(const Raster& raster, const multires::SchemeSpec& spec,
                                     const EncodeOptions& options) {
    return Encoder(raster, spec, options).run();
}

Result<double> pyramid_energy(const Raster& raster, const multires::SchemeSpec& spec) {
    const EncodeOptions options;
    Encoder encoder(raster, spec, options);
    RELIEF_CHECK(encoder.check());
    RELIEF_CHECK(encoder.analyse());
    return encoder.detail_energy_of_pyramid();
}

}  // namespace relief::codec
