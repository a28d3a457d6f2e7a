#include "relief/codec/scan_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "codec/goal_search.h"

namespace relief::codec {

namespace {

using Kind = Goal::Kind;

/// Tolerances of remeshes, in parts of goals and of the diagonal.
constexpr double kUsual = 2e-3;
constexpr double kOfRms = 10;
constexpr double kOfMax = 0.6;
/// What is tried if a goal can not be reached with the usual tolerance.
constexpr std::array<double, 3> kNearer = {0.8, 0.65, 0.5};
/// Files are about smallest where the RMS distance of the remesh is such a part of the goal, and
/// clearly larger from another one on. It falls like the number of faces grows.
constexpr double kBestPart = 0.3;
constexpr double kTooLarge = 0.4;
constexpr double kMostFiner = 8;
/// Bases of as many faces are better split into a coarser one, unless there are levels enough.
constexpr double kLargeBase = 800;
constexpr int kEnoughLevels = 3;
/// How a search for the smallest file goes on.
constexpr double kStride = 1.6;
constexpr double kShortStride = 1.25;

/// Faces of a base and how often it is subdivided; none: what remesh takes.
struct Sizes {
    std::optional<std::int64_t> base;
    std::optional<int> levels;
};

/// The same for other bases and tolerances.
bool may_help(const Error& error) {
    constexpr std::array<std::string_view, 3> names = {"goal_out_of_reach", "tolerance_not_met",
                                                       "flipped_faces"};
    return std::any_of(names.begin(), names.end(),
                       [&](std::string_view name) { return error.message.starts_with(name); });
}

class ScanEncoder {
  public:
    ScanEncoder(const PolygonMesh& mesh, const ScanEncodeOptions& options)
        : mesh_(mesh),
          options_(options),
          diagonal_(diagonal_of(mesh)),
          asked_{options.base_faces, options.levels} {}

    Result<EncodedScan> run() {
        auto first = suited();
        if (!first.ok() && !options_.tolerance) {
            for (const double share : kNearer) {
                if (!may_help(first.error())) break;
                auto nearer = encoded(remeshed(asked_, share * usual_tolerance()));
                if (nearer.ok() || !may_help(nearer.error())) {
                    first = std::move(nearer);
                    break;
                }
            }
        }
        if (!first.ok() || options_.effort != ScanEffort::Smallest || is_sized()) return first;
        best_ = *std::move(first);
        RELIEF_CHECK(search());
        return *std::move(best_);
    }

  private:
    [[nodiscard]] bool is_sized() const { return options_.base_faces || options_.levels; }

    [[nodiscard]] double usual_tolerance() const {
        if (options_.tolerance) return *options_.tolerance;
        if (!(diagonal_ > 0)) return kUsual;
        const double goal = options_.goal.value / diagonal_;
        if (options_.goal.kind == Kind::RmsError) return std::max(kUsual, kOfRms * goal);
        return options_.goal.kind == Kind::MaxError ? kOfMax * goal : 2 * kUsual;
    }

    [[nodiscard]] Result<remesh::Remeshed> remeshed(const Sizes& sizes, double tolerance) const {
        return remesh::remesh(mesh_, {.base_faces = sizes.base,
                                      .levels = sizes.levels,
                                      .feature_degrees = options_.feature_degrees,
                                      .tolerance = tolerance,
                                      .progress = options_.remeshing});
    }

    [[nodiscard]] Result<EncodedScan> encoded(Result<remesh::Remeshed> made) const {
        if (!made.ok()) return made.error();
        const MeshEncodeOptions options{.goal = options_.goal,
                                        .distance = MeshDistance::Surface,
                                        .original = &mesh_,
                                        .scheme = multires::MeshScheme::Loop,
                                        .levels = made->levels,
                                        .lift = options_.lift,
                                        .keep_order = false,
                                        .progress = options_.encoding};
        RELIEF_TRY(EncodedMesh file, encode_mesh(made->mesh, options));
        return EncodedScan{*std::move(made), std::move(file)};
    }

    /// The first remesh, or the finer one that the goal asks for.
    Result<EncodedScan> suited() {
        RELIEF_TRY(remesh::Remeshed made, remeshed(asked_, usual_tolerance()));
        const double share = made.report.rms_error / options_.goal.value;
        if (options_.goal.kind == Kind::RmsError && share > kTooLarge && !is_sized() &&
            options_.effort != ScanEffort::Once) {
            auto finer = remeshed(finer_sizes(made, share), usual_tolerance());
            if (!finer.ok() && finer.error().code == ErrorCode::Cancelled) return finer.error();
            if (finer.ok() && finer->report.rms_error < made.report.rms_error)
                made = *std::move(finer);
        }
        return encoded(std::move(made));
    }

    static Sizes finer_sizes(const remesh::Remeshed& made, double share) {
        const double finer = std::min(share / kBestPart, kMostFiner);
        double base = finer * static_cast<double>(made.report.base_faces);
        int levels = made.levels;
        for (; levels < kEnoughLevels && base > kLargeBase; ++levels) base /= 4;
        return {static_cast<std::int64_t>(base), levels};
    }

    [[nodiscard]] bool is_better(const EncodedMesh& file) const {
        const EncodedMesh& best = best_->encoded;
        if (options_.goal.kind == Kind::Bytes || options_.goal.kind == Kind::Keep)
            return file.report.rms_error < best.report.rms_error;
        return file.bytes.size() < best.bytes.size();
    }

    /// True: it is the best so far. Sizes that can not be made are passed over.
    Result<bool> improves(double base, int levels) {
        auto made = encoded(remeshed({static_cast<std::int64_t>(base), levels}, usual_tolerance()));
        if (!made.ok() && made.error().code == ErrorCode::Cancelled) return made.error();
        if (!made.ok() || !is_better(made->encoded)) return false;
        best_ = *std::move(made);
        return true;
    }

    /// Going one way as long as it helps. True: it did.
    Result<bool> climb(double factor, int more_levels) {
        for (bool moved = false;; moved = true) {
            const double base = static_cast<double>(best_->remeshed.report.base_faces);
            RELIEF_TRY(const bool better,
                       improves(factor * base, best_->remeshed.levels + more_levels));
            if (!better) return moved;
        }
    }

    Status climb_both_ways(double factor, int more_levels) {
        RELIEF_TRY(const bool moved, climb(factor, more_levels));
        if (!moved) RELIEF_CHECK(climb(1 / factor, -more_levels));
        return {};
    }

    /// Finer or coarser bases, then more or fewer levels, then bases again, by smaller steps.
    Status search() {
        RELIEF_CHECK(climb_both_ways(kStride, 0));
        RELIEF_CHECK(climb_both_ways(0.5, 1));
        return climb_both_ways(kShortStride, 0);
    }

    const PolygonMesh& mesh_;
    const ScanEncodeOptions& options_;
    double diagonal_;
    Sizes asked_;
    std::optional<EncodedScan> best_;
};

}  // namespace

Result<EncodedScan> encode_scan(const PolygonMesh& mesh, const ScanEncodeOptions& options) {
    RELIEF_CHECK(check_goal(options.goal));
    if (options.goal.kind == Kind::Lossless)
        return Error{ErrorCode::InvalidArgument,
                     "a remesh is another mesh of the same shape; the goals are max-error, "
                     "rms-error, bytes and keep",
                     ""};
    return ScanEncoder(mesh, options).run();
}

}  // namespace relief::codec
