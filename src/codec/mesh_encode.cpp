#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "codec/bytes.h"
#include "codec/decimal.h"
#include "codec/goal_search.h"
#include "codec/mesh_measure.h"
#include "codec/mesh_source.h"
#include "relief/codec/container.h"
#include "relief/multires/mesh_frames.h"

namespace relief::codec {

namespace {

using mesh::Index;
using Kind = Goal::Kind;
using multires::DetailFrames;

/// Steps of a first trial, in units of the goal.
constexpr double kFirstOfRms = 4;
constexpr double kFirstOfMax = 1.5;
/// Where searches for errors and for sizes end.
constexpr SearchLimits kOfErrors = {.trials = 12, .close_enough = 0.98, .narrow = 1.002};
constexpr SearchLimits kOfBytes = {.trials = 24, .close_enough = HUGE_VAL, .narrow = 1.01};
/// How often vertices that are too far off are pulled back.
constexpr int kRounds = 6;
/// Files that keep coefficients exactly: 2^-24 of the largest.
constexpr double kFine = 0x1p-24;
/// What the bounds in a header may take more than was thought.
constexpr std::uint64_t kHeaderSlack = 16;

/// How steps differ between levels, and between the normal and the tangents.
struct Weights {
    double gain = 2;
    double tangential = 1;
};

/// One way to quantise: integers, what they give, and how far that is off.
struct Trial {
    MeshQuantisation quantisation;
    std::vector<GridPoint> base;
    std::vector<QuantisedStep> steps;
    MeshPoints points;
    MeshErrors errors;
};

class Encoder {
  public:
    Encoder(const PolygonMesh& mesh, const MeshEncodeOptions& options, MeshSource source)
        : mesh_(mesh),
          options_(options),
          source_(std::move(source)),
          measure_(mesh, source_.points, source_.order, options.distance, options.original),
          exact_(coefficients_of(source_.synthesis, source_.points)) {
        std::vector<double> all;
        for (const auto& p : source_.points) all.insert(all.end(), {p.x, p.y, p.z});
        lattice_ = ValueLattice::exact(all);
        for (const auto& v : mesh.vertices)
            for (const double x : v) largest_ = std::max(largest_, std::abs(x));
    }

    Result<EncodedMesh> run() {
        if (by_surface() && !(largest_ <= kLargestMeasured))
            return Error{ErrorCode::InvalidArgument,
                         "distances of surfaces need coordinates of at most 1e75; scale the mesh, "
                         "or measure by vertices",
                         ""};
        RELIEF_TRY(const Trial best, choose());
        if (cancelled(0.9)) return cancelled_error();
        RELIEF_TRY(EncodedMesh encoded, finish(best));
        if (options_.progress) options_.progress(1);
        return encoded;
    }

  private:
    [[nodiscard]] const multires::MeshHierarchy& hierarchy() const { return source_.hierarchy(); }
    [[nodiscard]] int levels() const { return source_.header.levels; }
    [[nodiscard]] std::size_t base_count() const { return hierarchy().vertices(0); }
    [[nodiscard]] double count() const { return static_cast<double>(source_.points.size()); }
    [[nodiscard]] bool by_surface() const { return options_.distance == MeshDistance::Surface; }

    /// The scheme's norms of details grow by this from one step to the coarser one.
    [[nodiscard]] double norm_gain() const {
        return source_.header.spec.scheme == multires::MeshScheme::Sqrt3 ? 1.7320508075688772 : 2;
    }

    /// Moves along the surface matter less than moves of it.
    [[nodiscard]] Weights plain_weights() const { return {norm_gain(), by_surface() ? 4.0 : 1.0}; }

    bool cancelled(double done) {
        done_ = std::max(done_, done);
        return options_.progress && !options_.progress(done_);
    }

    Result<Trial> choose() {
        const Goal& goal = options_.goal;
        switch (goal.kind) {
            case Kind::MaxError:
                return search_weights(kFirstOfMax * goal.value);
            case Kind::RmsError:
                return search_weights(kFirstOfRms * goal.value);
            case Kind::Bytes:
                return search_bytes();
            case Kind::Keep:
                return keep();
            default:
                return search_lossless();
        }
    }

    /// The distance of neighbouring coordinates at the mesh's magnitude.
    [[nodiscard]] double smallest_step() const {
        if (lattice_.kind == ValueLattice::Kind::Decimal) return lattice_.value(1);
        const double epsilon = lattice_.kind == ValueLattice::Kind::Float32 ? 0x1p-24 : 0x1p-52;
        return std::max(largest_ * epsilon, 1e-290);
    }

    [[nodiscard]] MeshQuantisation quantisation(double step, const Weights& weights) const {
        MeshQuantisation q;
        // So that quotients stay below 2^50, and the coarsest step is a number.
        const double least =
            std::max(largest_ * 0x1p-44, 1e-280) * std::pow(weights.gain, levels());
        q.step = rounded(std::clamp(step, least, 1e290), 4);
        q.gain = rounded(weights.gain, 4);
        q.tangential = rounded(weights.tangential, 3);
        return q;
    }

    /// From coarse to fine, each step in the frames of what the decoder has.
    Trial trial(const MeshQuantisation& q, const MeshCoefficients& exact,
                std::int64_t samples = kAllSamples) const {
        Trial t;
        t.quantisation = q;
        for (std::size_t v = 0; v < base_count(); ++v) {
            t.base.push_back(base_grid_point(q, levels(), exact.points[v]));
            t.points.push_back(base_point(q, levels(), t.base.back()));
        }
        for (int step = 0; step < levels(); ++step) {
            const DetailFrames frames(hierarchy(), step, t.points.data());
            const MeshPoints coarse = t.points;
            QuantisedStep& details = t.steps.emplace_back(quantised_step(q, exact, step, frames));
            source_.synthesis.refine(q, levels(), step, details, frames, t.points);
            if (step + 1 < levels() || options_.goal.kind != Kind::MaxError) continue;
            for (int round = 0; round < kRounds && pull_back(q, frames, t.points, details);
                 ++round) {
                t.points = coarse;
                source_.synthesis.refine(q, levels(), step, details, frames, t.points);
            }
        }
        t.errors = measure_(t.points, samples);
        return t;
    }

    QuantisedStep quantised_step(const MeshQuantisation& q, const MeshCoefficients& exact, int step,
                                 const DetailFrames& frames) const {
        const double size = q.step_of(step, levels());
        const Vec3<double>* details = exact.points.data() + hierarchy().vertices(step);
        const MeshPoints& residuals = exact.residuals[static_cast<std::size_t>(step)];
        QuantisedStep result;
        for (std::size_t k = 0; k < frames.fresh().size(); ++k)
            result.fresh.push_back(quantised(frames.fresh()[k].in(details[k]), size, q.tangential));
        for (std::size_t k = 0; k < residuals.size(); ++k)
            result.stiff.push_back(
                quantised(frames.stiff()[k].in(residuals[k]), size, q.tangential));
        return result;
    }

    /// New vertices of the finest step that are too far off: details that bring them back. False:
    /// there are none. By surface only moves along the normal matter, roughly.
    bool pull_back(const MeshQuantisation& q, const DetailFrames& frames, const MeshPoints& points,
                   QuantisedStep& details) const {
        const std::size_t first = hierarchy().vertices(levels() - 1);
        bool any = false;
        for (std::size_t k = 0; k < details.fresh.size(); ++k) {
            Vec3<double> off = frames.fresh()[k].in(source_.points[first + k] - points[first + k]);
            if (by_surface()) off.x = off.y = 0;
            if (!(length(off) > options_.goal.value)) continue;
            QuantisedDetail& detail = details.fresh[k];
            const QuantisedDetail nearer = quantised(
                reconstructed(detail, q.step, q.tangential) + off, q.step, q.tangential, kNearest);
            any = any || nearer != detail;
            detail = nearer;
        }
        return any;
    }

    /// What the goal limits, in units of it.
    [[nodiscard]] double share_of(const Trial& t) const {
        const bool max = options_.goal.kind == Kind::MaxError;
        return (max ? t.errors.max : t.errors.rms) / options_.goal.value;
    }

    /// The largest step with which the error stays within the goal, from a first one on.
    Result<std::optional<Trial>> search_step(const Weights& weights, double step,
                                             std::int64_t samples) {
        if (!(options_.goal.value > smallest_step() / 4)) return std::optional<Trial>();
        const auto try_step = [&](double size) -> Result<Tried<Trial>> {
            Trial t = trial(quantisation(size, weights), exact_, samples);
            const double used = t.quantisation.step;
            const double share = share_of(t);
            return Tried<Trial>{std::move(t), used, share};
        };
        return largest_unit<Trial>(step, 0, kOfErrors, {.least = 1e-3, .most = HUGE_VAL}, try_step,
                                   [&](double done) { return cancelled(0.9 * done); });
    }

    /// The weights with which the file is the smallest, going each way as long as it helps;
    /// lossless if no step is small enough.
    Result<Trial> search_weights(double first_step) {
        Weights weights = plain_weights();
        RELIEF_TRY(std::optional<Trial> best, search_step(weights, first_step, kSomeSamples));
        if (!best) return all_but_lossless();
        std::size_t least = size_of(*best);
        const auto climb = [&](auto next) -> Result<bool> {
            for (bool moved = false;; moved = true) {
                const Weights other = next(weights);
                RELIEF_TRY(std::optional<Trial> t,
                           search_step(other, best->quantisation.step, kSomeSamples));
                const std::size_t size = t ? size_of(*t) : least;
                if (size >= least) return moved;
                least = size;
                best = std::move(t);
                weights = other;
            }
        };
        const auto climb_gain = [&](double power) {
            return climb([power](const Weights& w) {
                return Weights{std::pow(w.gain, power), w.tangential};
            });
        };
        const auto climb_tangential = [&](double factor) {
            return climb([factor](const Weights& w) {
                return Weights{w.gain, factor * w.tangential};
            });
        };
        RELIEF_TRY(const bool softer, climb_gain(0.75));
        if (!softer) RELIEF_CHECK(climb_gain(1 / 0.75));
        if (by_surface()) {
            RELIEF_TRY(const bool longer, climb_tangential(1.5));
            if (!longer) RELIEF_CHECK(climb_tangential(1 / 1.5));
            RELIEF_TRY(best, search_step(weights, best->quantisation.step, kAllSamples));
            if (!best) return all_but_lossless();
        }
        return *std::move(best);
    }

    /// No step is small enough.
    Result<Trial> all_but_lossless() {
        if (!options_.original) return search_lossless();
        return Error{ErrorCode::BadInput,
                     "goal_out_of_reach: the mesh is too far from the original, however exactly it "
                     "is kept; remesh it with more base faces or levels, or take a larger error",
                     ""};
    }

    /// Coordinates are corrected to the bit: finer steps cost details, coarser ones corrections.
    Result<Trial> search_lossless() {
        source_.header.lattice = lattice_;
        std::optional<Trial> best;
        std::size_t least = std::numeric_limits<std::size_t>::max();
        const auto attempt = [&](double factor) -> bool {
            Trial t = trial(quantisation(factor * smallest_step(), plain_weights()), exact_);
            const std::size_t size = size_of(t);
            if (size >= least) return false;
            least = size;
            best = std::move(t);
            return true;
        };
        double factor = 4;
        attempt(factor);
        for (double ratio = 4; ratio > 1.3; ratio = std::sqrt(ratio)) {
            if (cancelled(0.3)) return cancelled_error();
            if (attempt(factor * ratio)) {
                factor *= ratio;
                while (ratio > 3 && attempt(factor * ratio)) factor *= ratio;
            } else if (attempt(factor / ratio)) {
                factor /= ratio;
            }
        }
        return *std::move(best);
    }

    Result<Trial> search_bytes() {
        const auto try_step = [&](double step) -> Result<Tried<Trial>> {
            Trial t = trial(quantisation(step, plain_weights()), exact_);
            const double used = t.quantisation.step;
            const auto size = static_cast<double>(size_of(t) + kHeaderSlack);
            return Tried<Trial>{std::move(t), used, size / std::floor(options_.goal.value)};
        };
        RELIEF_TRY(Tried<Trial> coarsest, try_step(std::max(largest_, 1e-280)));
        if (coarsest.share > 1)
            return Error{ErrorCode::InvalidArgument,
                         "no file is that small; the connectivity of the base, the numbers of "
                         "vertices and faces and what else is kept exactly take about " +
                             std::to_string(size_of(coarsest.candidate) + kHeaderSlack) + " bytes",
                         ""};
        const double finest = std::max(smallest_step() / 4, coarsest.unit * 1e-12);
        RELIEF_TRY(Tried<Trial> best, bisect(std::move(coarsest), finest, kOfBytes, try_step,
                                             [&](double done) { return cancelled(0.9 * done); }));
        return std::move(best.candidate);
    }

    /// Details that are small for their step become zero.
    Result<Trial> keep() {
        const double wanted =
            options_.goal.value / 100 * count() - static_cast<double>(base_count());
        const auto most = static_cast<std::size_t>(std::clamp(wanted, 0.0, count()));
        MeshCoefficients some = exact_;
        std::vector<double> weighted;
        for (int step = 0; step < levels(); ++step) {
            const double norm = std::pow(norm_gain(), levels() - 1 - step);
            for (std::size_t k = hierarchy().vertices(step); k < hierarchy().vertices(step + 1);
                 ++k)
                weighted.push_back(norm * length(some.points[k]));
        }
        std::vector<double> sorted = weighted;
        double limit = -1;
        if (most < sorted.size()) {
            const auto place = sorted.begin() + static_cast<std::ptrdiff_t>(most);
            std::nth_element(sorted.begin(), place, sorted.end(), std::greater<>());
            limit = *place;
        }
        double largest = 0;
        for (std::size_t k = 0; k < weighted.size(); ++k) {
            if (weighted[k] <= limit) some.points[base_count() + k] = {};
            largest = std::max(largest, weighted[k]);
        }
        const double step = std::max(largest, largest_ * 0x1p-20) * kFine;
        return trial(quantisation(step, {1, 1}), some);
    }

    [[nodiscard]] std::vector<Bytes> chunks_of(const Trial& t) const {
        std::vector<Bytes> chunks(MeshChunks{levels()}.count());
        std::vector<GridPoint> base = t.base;
        const CodedBase coded = encode_base(source_.base, base);
        ByteWriter out;
        out.varint(coded.bytes.size());
        out.bytes(coded.bytes);
        out.bytes(write_base_order(coded, source_.base));
        chunks[MeshChunks::kBase] = out.take();
        MeshDetails details(hierarchy());
        for (int step = 0; step < levels(); ++step)
            chunks[MeshChunks::step(step)] =
                details.encode_next(t.steps[static_cast<std::size_t>(step)]);
        if (source_.header.lattice)
            chunks[MeshChunks{levels()}.exact()] =
                write_exact(t.points, source_.points, *source_.header.lattice);
        add_extras(chunks);
        return chunks;
    }

    /// The same for all trials.
    void add_extras(std::vector<Bytes>& chunks) const {
        if (extras_.empty()) {
            extras_.resize(chunks.size());
            const MeshChunks numbers{levels()};
            extras_[MeshChunks::kTags] = write_tags(source_.tags);
            extras_[numbers.order()] = write_order(source_.order, hierarchy());
            extras_[numbers.attributes()] =
                write_attributes(mesh_, source_.header.attributes, hierarchy(), source_.order);
            extras_[numbers.labels()] = write_labels(mesh_, source_.order, source_.sides);
            extras_[numbers.creases()] =
                has_creases_of_tags() ? Bytes{kCreasesOfTags} : write_creases(mesh_);
        }
        for (std::size_t k = 0; k < chunks.size(); ++k)
            if (!extras_[k].empty()) chunks[k] = extras_[k];
    }

    [[nodiscard]] Result<Bytes> file_of(const Trial& t, const MeshErrors& errors) const {
        MeshHeader header = source_.header;
        header.quantisation = t.quantisation;
        header.max_error = errors.max;
        header.rms_error = errors.rms;
        ContainerWriter writer;
        const std::vector<Bytes> chunks = chunks_of(t);
        for (std::size_t k = 0; k < chunks.size(); ++k)
            writer.add(chunks[k], k + 1 == chunks.size() ? rounded_up(errors.max, 4)
                                                         : std::numeric_limits<double>::infinity());
        return writer.finish(write_mesh_header(header));
    }

    [[nodiscard]] std::size_t size_of(const Trial& t) const {
        const auto file = file_of(t, source_.header.lattice ? MeshErrors() : t.errors);
        return file.ok() ? file->size() : std::numeric_limits<std::size_t>::max();
    }

    Result<EncodedMesh> finish(const Trial& best) {
        const bool exact = source_.header.lattice.has_value();
        const MeshErrors errors = exact ? MeshErrors() : best.errors;
        EncodedMesh encoded;
        RELIEF_TRY(encoded.bytes, file_of(best, errors));
        RELIEF_CHECK(verify(encoded.bytes, exact ? source_.points : best.points));
        MeshReport& report = encoded.report;
        report.scheme = source_.header.spec.scheme;
        report.levels = levels();
        report.samples = static_cast<std::int64_t>(source_.points.size());
        report.coefficients = report.samples;
        report.kept = static_cast<std::int64_t>(base_count());
        for (const QuantisedStep& step : best.steps)
            report.kept +=
                std::count_if(step.fresh.begin(), step.fresh.end(),
                              [](const QuantisedDetail& q) { return q != QuantisedDetail{}; });
        report.bytes = encoded.bytes.size();
        report.bits_per_sample = 8 * static_cast<double>(report.bytes) / count();
        report.max_error = errors.max;
        report.rms_error = errors.rms;
        const double energy = coarsest_square();
        report.energy_percent = energy > 0 ? 100 * errors.square / energy : 0;
        report.bound = options_.goal.kind == Kind::MaxError ? options_.goal.value : errors.max;
        report.base_vertices = static_cast<std::int64_t>(base_count());
        report.base_faces = hierarchy().topology(0).face_count;
        report.faces = hierarchy().topology(levels()).face_count;
        report.lost_creases = source_.lost_creases;
        return encoded;
    }

    /// Whether the creases of the mesh are those of the transform, in its numbers and order.
    [[nodiscard]] bool has_creases_of_tags() const {
        if (mesh_.creases.empty() && mesh_.sharp_vertices.empty()) return false;
        PolygonMesh marked;
        add_creases(hierarchy(), levels(), source_.tags.corner, marked);
        const auto& order = source_.order.vertices;
        for (std::size_t v = 0; v < order.size(); ++v)
            if (order[v] != v) return false;
        return marked.creases == mesh_.creases && marked.sharp_vertices == mesh_.sharp_vertices;
    }

    /// Squared distance of the mesh from the surface of its base.
    [[nodiscard]] double coarsest_square() const {
        MeshCoefficients smooth = exact_;
        std::fill(smooth.points.begin() + static_cast<std::ptrdiff_t>(base_count()),
                  smooth.points.end(), Vec3<double>());
        for (auto& residuals : smooth.residuals)
            std::fill(residuals.begin(), residuals.end(), Vec3<double>());
        source_.synthesis.maps().synthesise(0, levels(), smooth.points.data(), smooth.residuals);
        return measure_(smooth.points, 1).square;
    }

    /// What was written is decoded and compared: the error is of the file, not of an intention.
    [[nodiscard]] Status verify(const Bytes& bytes, const MeshPoints& expected) const {
        const Error differs{ErrorCode::BadInput,
                            "the decoded file differs from what was encoded; nothing was written. "
                            "Please report this mesh",
                            "verification"};
        RELIEF_TRY(const MeshFile file, MeshFile::open(bytes));
        RELIEF_TRY(const PolygonMesh decoded, file.decode(0));
        if (decoded.corners != mesh_.corners || decoded.attributes != mesh_.attributes ||
            decoded.labels != mesh_.labels || decoded.creases != mesh_.creases ||
            decoded.sharp_vertices != mesh_.sharp_vertices)
            return differs;
        for (std::size_t v = 0; v < expected.size(); ++v) {
            const auto& p = decoded.vertices[source_.order.vertices[v]];
            if (ordinal_of(p[0]) != ordinal_of(expected[v].x) ||
                ordinal_of(p[1]) != ordinal_of(expected[v].y) ||
                ordinal_of(p[2]) != ordinal_of(expected[v].z))
                return differs;
        }
        return {};
    }

    const PolygonMesh& mesh_;
    const MeshEncodeOptions& options_;
    MeshSource source_;
    MeshMeasure measure_;
    MeshCoefficients exact_;
    ValueLattice lattice_;
    double largest_ = 0;
    mutable std::vector<Bytes> extras_;
    double done_ = 0;
};

/// Creases in the order of the transform, if they are the same.
void order_creases(const MeshSource& source, PolygonMesh& mesh) {
    const auto sorted = [](const PolygonMesh& of) {
        std::vector<std::pair<std::pair<int, int>, double>> creases;
        for (const CreaseEdge& crease : of.creases)
            creases.emplace_back(std::minmax(crease.a, crease.b), crease.sharpness);
        for (const SharpVertex& sharp : of.sharp_vertices)
            creases.emplace_back(std::pair{sharp.vertex, sharp.vertex}, sharp.sharpness);
        std::sort(creases.begin(), creases.end());
        return creases;
    };
    PolygonMesh marked;
    add_creases(source.hierarchy(), source.header.levels, source.tags.corner, marked);
    if (sorted(marked) != sorted(mesh)) return;
    mesh.creases = std::move(marked.creases);
    mesh.sharp_vertices = std::move(marked.sharp_vertices);
}

Result<EncodedMesh> encode_as(const PolygonMesh& mesh, multires::MeshScheme scheme,
                              const MeshEncodeOptions& options) {
    RELIEF_TRY(MeshSource source, prepare_mesh(mesh, scheme, options));
    if (options.keep_order) return Encoder(mesh, options, std::move(source)).run();
    PolygonMesh ordered = reordered(mesh, source.order, source.sides);
    source.order = same_order(source.hierarchy().topology(source.header.levels));
    order_creases(source, ordered);
    return Encoder(ordered, options, std::move(source)).run();
}

std::vector<multires::MeshScheme> schemes_for(const PolygonMesh& mesh) {
    using multires::MeshScheme;
    for (std::int64_t f = 0; f < mesh.polygon_count(); ++f)
        if (mesh.polygon(f).size() != 3) return {MeshScheme::CatmullClark};
    return {MeshScheme::Loop, MeshScheme::Sqrt3};
}

/// What the goal leaves open is smaller.
bool is_better(const EncodedMesh& a, const EncodedMesh& b, const Goal& goal) {
    if (goal.kind == Kind::Bytes || goal.kind == Kind::Keep)
        return a.report.rms_error < b.report.rms_error;
    return a.bytes.size() < b.bytes.size();
}

}  // namespace

Result<EncodedMesh> encode_mesh(const PolygonMesh& mesh, const MeshEncodeOptions& options) {
    RELIEF_CHECK(check_goal(options.goal));
    RELIEF_CHECK(check(mesh));
    if (options.scheme) return encode_as(mesh, *options.scheme, options);
    std::optional<Result<EncodedMesh>> best;
    for (const multires::MeshScheme scheme : schemes_for(mesh)) {
        Result<EncodedMesh> encoded = encode_as(mesh, scheme, options);
        if (!encoded.ok() && encoded.error().code == ErrorCode::Cancelled) return encoded;
        const bool first = !best || !best->ok();
        if (!best || (encoded.ok() && (first || is_better(*encoded, **best, options.goal))))
            best = std::move(encoded);
    }
    return *std::move(best);
}

}  // namespace relief::codec
