#include "relief/remesh/remesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "relief/mesh/closest.h"
#include "remesh/align.h"
#include "remesh/attributes.h"
#include "remesh/fit.h"
#include "remesh/levels.h"
#include "remesh/pins.h"
#include "remesh/relax.h"

namespace relief::remesh {

namespace {

using mesh::Index;
using Point = Vec3<double>;

/// Faces of bases that are neither wasteful nor too coarse for the shapes of scans, and of machine
/// parts, whose features make them finer where that matters.
constexpr double kLeastBase = 250;
constexpr double kLeastPartBase = 150;
constexpr int kMostLevels = 12;
/// How much finer the bases are that are tried, each with the vertices that were far from what came
/// of the one before.
constexpr std::array<double, 5> kBases = {1, 1, 1.5, 2.5, 4};
/// The map gives vertices down to this depth; the finer ones come from these.
constexpr int kMappedDepth = 3;
constexpr int kRelaxations = 30;
/// Vertices of the surface that are so far from the mesh, in tolerances, are locked: the base gets
/// them. At most so often, and so many at a time, so far apart.
constexpr double kLockBeyond = 2;
constexpr int kLockRounds = 3;
constexpr std::size_t kLocks = 30;
constexpr double kLocksApart = 0.03;
/// Vertices are pinned where the surface is so far away, in tolerances; what is around settles.
constexpr double kPinBeyond = 0.75;
constexpr int kPinRounds = 6;
constexpr int kPinRelaxations = 2;
/// Vertices stay in alignment where the surface is so far away, in tolerances: first few, then
/// more, then all.
constexpr std::array<double, 3> kStayBeyond = {0.7, 0.35, 0};
/// Alignment is not tried where it is so far away.
constexpr double kHopeless = 1.25;
constexpr int kAlignRounds = 7;
constexpr int kAlignments = 3;
constexpr int kFits = 1;
/// Of so many boundaries a failure speaks.
constexpr std::int64_t kManyBoundaries = 16;
/// What is nearly too far in the end is brought nearer once more.
constexpr int kLastRounds = 2;
constexpr double kLastBeyond = 0.9;

Error invalid(std::string message) {
    return {ErrorCode::InvalidArgument, std::move(message), ""};
}

Status check_options(const RemeshOptions& options) {
    if (options.base_faces && *options.base_faces < 1)
        return invalid("a base has at least one face");
    if (options.levels && (*options.levels < 0 || *options.levels > kMostLevels))
        return invalid("levels are 0 to 12");
    if (options.feature_degrees &&
        !(*options.feature_degrees > 0 && *options.feature_degrees < 180))
        return invalid("features turn by more than 0 and less than 180 degrees");
    if (!(options.tolerance > 0) || !std::isfinite(options.tolerance))
        return invalid("the tolerance is a fraction of the diagonal above 0");
    return {};
}

/// As many as leave the base enough faces.
int default_levels(double faces, bool part) {
    const double least = part ? kLeastPartBase : kLeastBase;
    int levels = 1;
    while (levels < kMostLevels && std::ldexp(faces, -2 * (levels + 1)) >= least) ++levels;
    return levels;
}

std::int64_t boundary_count(const mesh::Topology& mesh) {
    const Buffer<Index> out = mesh::outgoing(mesh);
    std::vector<std::uint8_t> seen(mesh.half_edge_count(), 0);
    std::int64_t count = 0;
    for (Index first = 0; first < mesh.half_edge_count(); ++first) {
        if (!mesh.on_boundary(first) || seen[first]) continue;
        ++count;
        for (Index h = first; !std::exchange(seen[h], 1);) h = out[mesh.target(h)];
    }
    return count;
}

/// A number for people.
std::string text_of(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.4g", value);
    return text.data();
}

/// A finished mesh and how good it is.
struct Candidate {
    MovingMesh mesh;
    mesh::SurfaceDistance distance;  ///< in units of the diagonal
    std::vector<Index> flips;
};

class Remesher {
  public:
    Remesher(const PolygonMesh& mesh, Surface surface, const RemeshOptions& options)
        : mesh_(mesh),
          surface_(std::move(surface)),
          options_(options),
          shape_(shape_of(surface_.points,
                          {surface_.mesh.origin.data(), surface_.mesh.origin.size()})),
          tree_(mesh::fan_triangles(shape_)),
          curvature_(relative_curvature(surface_)) {}

    Result<Remeshed> run() {
        const double faces = surface_.mesh.face_count;
        const int levels = options_.levels
                               ? *options_.levels
                               : default_levels(faces, options_.feature_degrees.has_value());
        const double base = options_.base_faces ? static_cast<double>(*options_.base_faces)
                                                : std::ldexp(faces, -2 * levels);
        bool is_new = true;
        for (const double factor : kBases) {
            if (factor == 1 && !is_new) continue;
            // A finer base than the surface there is not.
            if (factor > 1 && factor * base >= faces) break;
            ++attempts_;
            RELIEF_CHECK(attempt(static_cast<Index>(std::min(factor * base, faces)), levels));
            if (is_good(*best_)) break;
            is_new = lock_far(best_->mesh, 1) + lock_worst() > 0;
        }
        RELIEF_CHECK(check_result());
        return finish(levels);
    }

  private:
    static PolygonMesh shape_of(const std::vector<Point>& points, std::span<const Index> corners) {
        PolygonMesh shape;
        for (const Point& p : points) shape.vertices.push_back({p.x, p.y, p.z});
        shape.corners.assign(corners.begin(), corners.end());
        for (std::size_t k = 3; k <= corners.size(); k += 3)
            shape.offsets.push_back(static_cast<std::int64_t>(k));
        return shape;
    }

    /// The share of all attempts that is done; false: to be stopped.
    Status go_on(double share) {
        const double last = static_cast<double>(kBases.size());
        done_ = std::max(done_, (static_cast<double>(attempts_) - 1 + share) / last);
        if (!options_.progress || options_.progress(done_)) return {};
        return Error{ErrorCode::Cancelled, "stopped; nothing was written", ""};
    }

    [[nodiscard]] bool is_good(const Candidate& candidate) const {
        return candidate.flips.empty() && candidate.distance.largest() <= options_.tolerance;
    }

    /// Than the best so far.
    [[nodiscard]] bool better(const mesh::SurfaceDistance& distance,
                              const std::vector<Index>& flips) const {
        if (flips.empty() != best_->flips.empty()) return flips.empty();
        return distance.largest() < best_->distance.largest();
    }

    /// Measures a mesh; true: it is the best so far.
    Result<bool> measure(const MovingMesh& mesh) {
        RELIEF_TRY(auto distance,
                   mesh::surface_distance(shape_, tree_, shape_of(mesh.points, mesh.corners)));
        const std::vector<Index> flips = mesh.flips();
        if (best_ && !better(distance, flips)) return false;
        best_ = Candidate{mesh, distance, flips};
        return true;
    }

    /// Finishes a mesh, in two ways if the first is not good enough.
    Result<bool> keep(MovingMesh mesh) {
        fit(mesh, tree_, kFits);
        RELIEF_TRY(const bool fitted, measure(mesh));
        if (is_good(*best_)) return fitted;
        const double near = kLastBeyond * options_.tolerance;
        for (int k = 0; k < kLastRounds; ++k) {
            pin_far_vertices(mesh, near);
            draw_near(mesh, tree_, near);
        }
        RELIEF_TRY(const bool mended, measure(mesh));
        return fitted || mended;
    }

    /// One base: from simplification to meshes that are measured.
    Status attempt(Index base_faces, int steps) {
        std::unique_ptr<Levels> levels;
        RELIEF_TRY(MovingMesh relaxed, locked(base_faces, steps, levels));
        const double near = kPinBeyond * options_.tolerance;
        for (int k = 0; k < kPinRounds && pin_far_vertices(relaxed, near) > 0; ++k)
            relax(relaxed, curvature_, tree_, kPinRelaxations);
        relaxed.untangle();
        draw_near(relaxed, tree_, near);
        RELIEF_CHECK(go_on(0.5));
        const std::vector<double> errors = errors_at_vertices(relaxed, tree_);
        const bool hopeless =
            *std::max_element(errors.begin(), errors.end()) > kHopeless * options_.tolerance;
        bool is_best = false;
        for (const double stay_beyond : kStayBeyond) {
            if (hopeless && stay_beyond > 0) continue;
            RELIEF_TRY(MovingMesh mesh, aligned(relaxed, errors, stay_beyond, *levels));
            RELIEF_CHECK(go_on(1 - stay_beyond / 2));
            RELIEF_TRY(const bool better, keep(std::move(mesh)));
            is_best = is_best || better;
            if (is_good(*best_)) break;
        }
        if (is_best) best_levels_ = std::move(levels);
        return {};
    }

    /// The farthest vertices of the surface shall be in the base. Returns how many are new.
    std::size_t lock_far(const MovingMesh& mesh, double tolerances) {
        const Reverse reverse = distances_from(mesh);
        const std::vector<Index> far = far_vertices(
            surface_, reverse.distances, tolerances * options_.tolerance, kLocksApart, kLocks);
        const std::size_t before = locks_.size();
        locks_.insert(locks_.end(), far.begin(), far.end());
        return locks_.size() - before;
    }

    /// So shall the vertices next to where the best mesh is farthest, which may be between
    /// vertices.
    std::size_t lock_worst() {
        const std::size_t before = locks_.size();
        for (const mesh::DirectedDistance* d : {&best_->distance.a_to_b, &best_->distance.b_to_a}) {
            if (d->largest <= options_.tolerance) continue;
            const mesh::SurfacePoint at = tree_.closest(d->farthest);
            const auto corners = surface_.mesh.corners(at.face);
            const Index next =
                *std::min_element(corners.begin(), corners.end(), [&](Index v, Index u) {
                    return length(surface_.points[v] - at.point) <
                           length(surface_.points[u] - at.point);
                });
            if (std::find(locks_.begin(), locks_.end(), next) == locks_.end())
                locks_.push_back(next);
        }
        return locks_.size() - before;
    }

    /// A relaxed mesh of the finest level, with vertices locked until none is far away.
    Result<MovingMesh> locked(Index base_faces, int steps, std::unique_ptr<Levels>& levels) {
        for (int round = 0;; ++round) {
            RELIEF_CHECK(go_on(0.1 * round));
            const auto wanted = base_faces + static_cast<Index>(2 * locks_.size());
            RELIEF_TRY(Levels made,
                       Levels::create(surface_,
                                      Simplification(surface_, {.faces = wanted, .locked = locks_}),
                                      steps));
            levels = std::make_unique<Levels>(std::move(made));
            MovingMesh mesh = finest(*levels, steps);
            if (round == kLockRounds || lock_far(mesh, kLockBeyond) == 0) return mesh;
        }
    }

    [[nodiscard]] MovingMesh finest(const Levels& levels, int steps) const {
        const int depth = std::min(steps, kMappedDepth);
        MovingMesh mesh = levels.mapped(depth);
        const std::vector<Index>& base = levels.base().vertices();
        for (const Index v : locks_)
            mesh.fixed[static_cast<std::size_t>(std::lower_bound(base.begin(), base.end(), v) -
                                                base.begin())] = 1;
        mesh.untangle();
        relax(mesh, curvature_, tree_, kRelaxations);
        mesh.untangle();
        for (int d = depth; d < steps; ++d) {
            mesh = levels.refined(mesh, d);
            mesh.untangle();
            relax(mesh, curvature_, tree_, 1);
        }
        return mesh;
    }

    Result<MovingMesh> aligned(const MovingMesh& relaxed, const std::vector<double>& errors,
                               double stay_beyond, const Levels& levels) const {
        MovingMesh mesh = relaxed;
        if (stay_beyond == 0) return mesh;
        for (std::size_t v = 0; v < errors.size(); ++v)
            if (errors[v] > stay_beyond * options_.tolerance) mesh.fixed[v] = 1;
        for (int round = 0; round < kAlignRounds; ++round) {
            RELIEF_CHECK(align(mesh, levels.hierarchy(), kAlignments));
            pin_far_vertices(mesh, kPinBeyond * options_.tolerance);
        }
        mesh.fixed = relaxed.fixed;
        mesh.untangle();
        draw_near(mesh, tree_, kPinBeyond * options_.tolerance);
        return mesh;
    }

    [[nodiscard]] std::string place(const Point& p) const {
        const Point at = surface_.original(p);
        return "(" + text_of(at.x) + ", " + text_of(at.y) + ", " + text_of(at.z) + ")";
    }

    [[nodiscard]] const mesh::DirectedDistance& worst() const {
        const mesh::SurfaceDistance& d = best_->distance;
        return d.a_to_b.largest >= d.b_to_a.largest ? d.a_to_b : d.b_to_a;
    }

    [[nodiscard]] Status check_result() const {
        if (!best_->flips.empty()) {
            const Index v = best_->mesh.corners[3 * best_->flips.front()];
            return Error{
                ErrorCode::BadInput,
                "flipped_faces: " + std::to_string(best_->flips.size()) +
                    " faces of the result would lie upside down; more base faces may help, "
                    "or the mesh has folds there that must be mended",
                place(best_->mesh.points[v])};
        }
        if (is_good(*best_)) return {};
        return Error{ErrorCode::BadInput,
                     "tolerance_not_met: the surfaces are " + text_of(worst().largest) +
                         " of the diagonal apart there, more than " + text_of(options_.tolerance) +
                         "; take more base faces or levels, or a larger tolerance; machine parts "
                         "need --features 40" +
                         advice_on_holes(),
                     place(worst().farthest)};
    }

    /// Each boundary keeps three vertices of the base at least.
    [[nodiscard]] std::string advice_on_holes() const {
        const std::int64_t boundaries = boundary_count(surface_.mesh);
        if (boundaries < kManyBoundaries) return "";
        return "; its " + std::to_string(boundaries) +
               " boundaries keep the base fine and its triangles thin: fill small holes first";
    }

    Result<Remeshed> finish(int steps) {
        const multires::MeshHierarchy& hierarchy = best_levels_->hierarchy();
        Remeshed result;
        result.levels = steps;
        result.mesh = polygons(hierarchy, steps);
        result.base = polygons(hierarchy, 0);
        take_attributes(mesh_, best_->mesh, result.mesh);
        RemeshReport& report = result.report;
        report.vertices = static_cast<std::int64_t>(surface_.points.size());
        report.base_faces = hierarchy.topology(0).face_count;
        report.levels = steps;
        report.diagonal = surface_.diagonal;
        report.rms_error = surface_.diagonal * best_->distance.rms();
        report.max_error = surface_.diagonal * best_->distance.largest();
        const Point at = surface_.original(worst().farthest);
        report.worst = {at.x, at.y, at.z};
        report.flips = static_cast<std::int64_t>(best_->flips.size());
        for (Index f = 0; f < best_->mesh.face_count(); ++f) report.quality += best_->mesh.fit(f);
        report.quality /= static_cast<double>(best_->mesh.face_count());
        report.attempts = attempts_;
        if (options_.progress) options_.progress(1);
        return result;
    }

    /// A depth of the hierarchy, with what is sharp.
    [[nodiscard]] PolygonMesh polygons(const multires::MeshHierarchy& hierarchy, int depth) const {
        const mesh::Topology& topology = hierarchy.topology(depth);
        const multires::MeshTags& tags = hierarchy.tags(depth);
        std::vector<Point> points(best_->mesh.points.begin(),
                                  best_->mesh.points.begin() + topology.vertex_count);
        for (Point& p : points) p = surface_.original(p);
        PolygonMesh result = shape_of(points, {topology.origin.data(), topology.origin.size()});
        for (Index h = 0; !tags.sharp.empty() && h < topology.half_edge_count(); ++h)
            if (topology.is_first(h) && !topology.on_boundary(h) && tags.is_sharp(topology, h))
                result.creases.push_back({static_cast<std::int32_t>(topology.origin[h]),
                                          static_cast<std::int32_t>(topology.target(h)), HUGE_VAL});
        for (std::size_t v = 0; v < tags.corner.size(); ++v)
            if (tags.corner[v])
                result.sharp_vertices.push_back({static_cast<std::int32_t>(v), HUGE_VAL});
        return result;
    }

    const PolygonMesh& mesh_;
    Surface surface_;
    const RemeshOptions& options_;
    PolygonMesh shape_;
    mesh::TriangleTree tree_;
    std::vector<double> curvature_;
    std::vector<Index> locks_;
    std::optional<Candidate> best_;
    std::unique_ptr<Levels> best_levels_;
    std::int64_t attempts_ = 0;
    double done_ = 0;
};

}  // namespace

Result<Remeshed> remesh(const PolygonMesh& mesh, const RemeshOptions& options) {
    RELIEF_CHECK(check_options(options));
    RELIEF_TRY(Surface surface, surface_of(mesh, {.feature_degrees = options.feature_degrees}));
    return Remesher(mesh, std::move(surface), options).run();
}

}  // namespace relief::remesh
