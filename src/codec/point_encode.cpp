#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "relief/codec/point_codec.h"
#include "relief/mesh/delaunay.h"
#include "relief/mesh/triangle_locator.h"
#include "relief/multires/ps_interpolant.h"
#include "relief/multires/ps_refine.h"
#include "relief/multires/ps_surface.h"

namespace relief::codec {

namespace ps = multires::ps;
using mesh::Index;
using mesh::kNone;

namespace {

constexpr double kLargest = 1e150;
constexpr std::size_t kMostFineVertices = std::size_t{1} << 23;
/// How much of the root mean square error coding may add where nothing is asked.
constexpr double kNegligible = 1e-3;
/// Parts of a bound that the spline may take; the code has the rest. The first makes the smallest
/// files where vertices are few, the second where more than a third of the points are vertices.
constexpr double kShareOfFew = 0.9;
constexpr double kShareOfMany = 0.7;
constexpr double kSmoothing = 1e-10;
/// What code may add to the error of a spline that is not within the bound, in parts of the bound.
constexpr double kCodeShare = 0.25;

/// What encode_points is asked, but for the method.
struct Task {
    const PsData& data;
    const std::optional<Goal>& goal;
    const Progress& progress;
    const PsReference& reference;
};

Status check(const PsData& data) {
    const std::size_t points = data.points.size();
    if (data.values.empty() || data.values.size() > 3)
        return Error{ErrorCode::InvalidArgument,
                     "component_count: points have one to three values each", "points"};
    for (const auto& values : data.values)
        if (values.size() != points || (!data.weights.empty() && data.weights.size() != points))
            return Error{ErrorCode::BadInput,
                         "size_mismatch: " + std::to_string(points) + " points have " +
                             std::to_string(values.size()) + " values and " +
                             std::to_string(data.weights.size()) + " weights",
                         "points"};
    const auto usable = [](double number) { return std::abs(number) <= kLargest; };
    for (std::size_t k = 0; k < points; ++k) {
        bool good = usable(data.points[k].x) && usable(data.points[k].y) &&
                    (data.weights.empty() || (usable(data.weights[k]) && data.weights[k] >= 0));
        for (const auto& values : data.values) good = good && usable(values[k]);
        if (!good)
            return Error{ErrorCode::BadInput,
                         "non_finite_input: its numbers are at most 1e150, its weight is not "
                         "negative; leave the point out or correct it",
                         "point " + std::to_string(k)};
    }
    return {};
}

/// A goal that can not be reached is a matter of the data.
Result<EncodedPs> encode(const PsModel& model, const Goal& goal, bool keep_order,
                         const Progress& progress) {
    auto encoded = encode_ps(model, {.goal = goal, .keep_order = keep_order, .progress = progress});
    if (encoded.ok() || encoded.error().code != ErrorCode::InvalidArgument) return encoded;
    return Error{ErrorCode::BadInput, "bound_not_reached: " + encoded.error().message,
                 encoded.error().where};
}

Result<EncodedPoints> interpolate(const Task& task, const Interpolation& method) {
    const PsData& data = task.data;
    RELIEF_TRY(mesh::Delaunay delaunay, mesh::delaunay(data.points));
    PsValues values{{}, method.gradients};
    for (const std::vector<double>& of_points : data.values)
        values.components.push_back(ps::vertex_means(
            delaunay.mesh.vertex_count(), delaunay.vertex_of_point, of_points, data.weights));
    EncodedPoints result;
    result.merged = data.points.size() - delaunay.mesh.vertex_count();
    const PsModel model{std::move(delaunay.mesh), std::move(values), data, task.reference};
    const Goal exact{Goal::Kind::Lossless, 0};
    RELIEF_TRY(EncodedPs encoded, encode(model, task.goal.value_or(exact), false, task.progress));
    result.bytes = std::move(encoded.bytes);
    result.report = encoded.report;
    return result;
}

/// Triangles grow by nine a level, and there are about half as many vertices.
Status check_levels(const mesh::Triangulation& base, int levels) {
    std::size_t triangles = base.triangles.size();
    for (int level = 0; level < levels; ++level) {
        triangles *= 9;
        if (triangles / 2 > kMostFineVertices)
            return Error{ErrorCode::InvalidArgument,
                         "too_many_elements: " + std::to_string(levels) +
                             " levels make more than 2^23 vertices; ask for fewer, or for a "
                             "smaller base",
                         ""};
    }
    return {};
}

/// Where the data are on a triangulation.
struct Located {
    PsData data;                   ///< those on a triangle
    std::vector<Index> triangles;  ///< of each of them
};

Located locate(const mesh::Triangulation& mesh, const PsData& all) {
    const mesh::TriangleLocator locator(mesh);
    std::vector<Index> triangles(all.points.size());
    locator.locate(all.points, triangles);
    Located found;
    found.data.values.resize(all.values.size());
    for (std::size_t k = 0; k < triangles.size(); ++k) {
        if (triangles[k] == kNone) continue;
        found.triangles.push_back(triangles[k]);
        found.data.points.push_back(all.points[k]);
        for (std::size_t m = 0; m < all.values.size(); ++m)
            found.data.values[m].push_back(all.values[m][k]);
        if (!all.weights.empty()) found.data.weights.push_back(all.weights[k]);
    }
    return found;
}

Result<EncodedPoints> approximate(const Task& task, const Approximation& method) {
    const PsData& data = task.data;
    const auto* given = std::get_if<mesh::Triangulation>(&method.base);
    mesh::Triangulation base;
    if (given != nullptr) {
        base = *given;
    } else {
        RELIEF_TRY(base, ps::spread_triangulation(data.points, std::get<std::size_t>(method.base)));
    }
    RELIEF_CHECK(check_levels(base, method.levels));
    RELIEF_TRY(ps::Space space, ps::make_space(base));
    for (int level = 0; level < method.levels; ++level) {
        RELIEF_TRY(ps::Refinement step, ps::refine(space));
        space = std::move(step.fine);
    }

    Located located = locate(space.mesh, data);
    EncodedPoints result;
    result.outside = data.points.size() - located.triangles.size();
    if (located.triangles.empty())
        return Error{ErrorCode::BadInput,
                     "no_data: none of the points lies on the triangles; compare their extents",
                     "points"};
    RELIEF_TRY(
        const ps::LeastSquares squares,
        ps::LeastSquares::create(
            space, {located.data.points, located.triangles, located.data.weights}, method.energy));
    const std::vector<std::span<const double>> components(located.data.values.begin(),
                                                          located.data.values.end());
    RELIEF_TRY(ps::FittedSplines fitted, squares.fit(components, method.smoothing));
    result.smoothing = fitted.report.smoothing;
    const double rms = fitted.report.rms_error;
    const PsModel model{std::move(base), PsSplines{method.levels, std::move(fitted.components)},
                        std::move(located.data), task.reference};
    const Goal close = rms > 0 ? Goal{Goal::Kind::RmsError, (1 + kNegligible) * rms}
                               : Goal{Goal::Kind::Lossless, 0};
    RELIEF_TRY(EncodedPs encoded,
               encode(model, task.goal.value_or(close), given != nullptr, task.progress));
    result.bytes = std::move(encoded.bytes);
    result.report = encoded.report;
    return result;
}

/// How many points the decoded surface misses by more than the bound.
Result<std::size_t> count_beyond(const PsData& data, Bytes bytes, double bound) {
    RELIEF_TRY(const PsFile file, PsFile::open(std::move(bytes)));
    RELIEF_TRY(const PsSurface level, file.surface(0));
    RELIEF_TRY(const ps::Surface surface, ps::Surface::create(level.space, level.components));
    const std::size_t components = data.values.size();
    std::vector<spline::PlaneJet> jets(components * data.points.size());
    RELIEF_CHECK(ps::evaluate(surface, mesh::TriangleLocator(level.space.mesh), data.points, jets,
                              ps::Outside::Nearest));
    std::size_t beyond = 0;
    for (std::size_t k = 0; k < data.points.size(); ++k) {
        double off = 0;
        for (std::size_t m = 0; m < components; ++m)
            off = std::max(off, std::abs(jets[k * components + m].value - data.values[m][k]));
        beyond += off > bound;
    }
    return beyond;
}

/// The spline within a share of the bound, coded within all of it.
Result<EncodedPoints> insert_within(const Task& task, const Insertion& method, double share) {
    const PsData& data = task.data;
    const double bound = task.goal->value;
    RELIEF_TRY(ps::AdaptiveSurface surface,
               ps::fit_within({data.points, data.values, data.weights},
                              {.max_error = share * bound,
                               .most_vertices = method.most_vertices,
                               .smoothing = method.smoothing.value_or(kSmoothing),
                               .energy = method.energy,
                               .progress = task.progress}));
    const double error = surface.report.max_error;
    const bool limited = surface.space.mesh.vertex_count() >= method.most_vertices;
    if (error > bound && !limited)
        return Error{ErrorCode::BadInput, "bound_not_reached: " + surface.reason, "points"};
    EncodedPoints result;
    result.smoothing = surface.report.smoothing;
    const Goal goal{Goal::Kind::MaxError, error > bound ? error + kCodeShare * bound : bound};
    const PsModel model{std::move(surface.space.mesh), PsSplines{0, std::move(surface.components)},
                        data, task.reference};
    RELIEF_TRY(EncodedPs encoded, encode(model, goal, false, task.progress));
    result.bytes = std::move(encoded.bytes);
    result.report = encoded.report;
    if (result.report.max_error > bound) {
        RELIEF_TRY(result.beyond, count_beyond(data, result.bytes, bound));
        result.reason = surface.reason;
    }
    return result;
}

/// Points at one place.
struct Conflict {
    std::size_t a = 0;
    std::size_t b = 0;
    double apart = 0;  ///< their values
};

/// The one whose values are farthest apart, among those of one component.
Conflict worst_conflict(const PsData& data, const std::vector<double>& values) {
    std::vector<std::size_t> order(data.points.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto key = [&](std::size_t k) {
        return std::tuple(data.points[k].x, data.points[k].y, values[k], k);
    };
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
    Conflict worst;
    for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
        while (end < order.size() && data.points[order[end]] == data.points[order[begin]]) ++end;
        const std::size_t low = order[begin];
        const std::size_t high = order[end - 1];
        const double apart = values[high] - values[low];
        if (apart > worst.apart) worst = {std::min(low, high), std::max(low, high), apart};
    }
    return worst;
}
Conflict worst_conflict(const PsData& data) {
    Conflict worst;
    for (const std::vector<double>& values : data.values) {
        const Conflict conflict = worst_conflict(data, values);
        if (conflict.apart > worst.apart) worst = conflict;
    }
    return worst;
}

Result<EncodedPoints> insert(const Task& task, const Insertion& method) {
    const PsData& data = task.data;
    if (!task.goal || task.goal->kind != Goal::Kind::MaxError || !(task.goal->value >= 0))
        return Error{ErrorCode::InvalidArgument,
                     "vertices are inserted for a largest error, a number from 0 on", ""};
    const double bound = task.goal->value;
    const Conflict conflict = worst_conflict(data);
    if (conflict.apart > 2 * bound && method.most_vertices >= data.points.size())
        return Error{ErrorCode::BadInput,
                     "bound_not_reached: points " + std::to_string(conflict.a) + " and " +
                         std::to_string(conflict.b) +
                         " lie at the same place and their values are farther apart than twice "
                         "the bound; allow more, or leave one of them out",
                     "points"};
    const auto trial = [&](double share) { return insert_within(task, method, share); };
    auto best = trial(conflict.apart > 2 * kShareOfFew * bound ? 1 : kShareOfFew);
    const std::size_t points = data.points.size();
    if (!best.ok() || best->beyond > 0 ||
        3 * static_cast<std::size_t>(best->report.vertices) <= points)
        return best;
    const auto keep_smaller = [&](Result<EncodedPoints> other) {
        if (other.ok() && other->bytes.size() < best->bytes.size()) best = std::move(other);
    };
    keep_smaller(trial(kShareOfMany));
    if (!method.smoothing && points <= method.most_vertices) keep_smaller(interpolate(task, {}));
    if (task.progress && !task.progress(1)) return Error{ErrorCode::Cancelled, "cancelled", ""};
    return best;
}

}  // namespace

Result<PointMethod> point_method(FitWishes wishes, const std::optional<Goal>& goal) {
    const auto wrong = [](const char* message) {
        return Error{ErrorCode::InvalidArgument, message, ""};
    };
    const bool least_squares = wishes.vertices || wishes.triangles;
    const bool bounded = goal && goal->kind == Goal::Kind::MaxError;
    const bool inserts = bounded && !wishes.gradients && !wishes.triangles && wishes.levels == 0;
    if (wishes.vertices && wishes.triangles)
        return wrong("a number of vertices and a mesh exclude each other");
    if (wishes.vertices && *wishes.vertices < 3)
        return wrong("the number of vertices must be at least 3");
    if (wishes.gradients && least_squares)
        return wrong("gradients are for interpolation, without a number of vertices or a mesh");
    if (wishes.levels != 0 && !least_squares)
        return wrong("levels need a number of vertices or a mesh");
    if ((wishes.smoothing || wishes.energy) && !least_squares && !inserts)
        return wrong("smoothing and energy need a number of vertices, a mesh or a largest error");
    if (wishes.smoothing && !(*wishes.smoothing >= 0 && std::isfinite(*wishes.smoothing)))
        return wrong("smoothing must be a number from 0 on");
    const auto energy = wishes.energy.value_or(multires::ps::Energy::ThinPlate);
    if (inserts)
        return PointMethod(Insertion{wishes.vertices.value_or(Insertion{}.most_vertices),
                                     wishes.smoothing, energy});
    if (!least_squares) {
        Interpolation interpolation;
        if (wishes.gradients) interpolation.gradients.rule = *wishes.gradients;
        return PointMethod(interpolation);
    }
    Approximation approximation{
        .base = {}, .levels = wishes.levels, .smoothing = wishes.smoothing, .energy = energy};
    if (wishes.vertices)
        approximation.base = *wishes.vertices;
    else
        approximation.base = *std::move(wishes.triangles);
    return PointMethod(std::move(approximation));
}

Result<EncodedPoints> encode_points(const PsData& data, const PointMethod& method,
                                    std::optional<Goal> goal, const Progress& progress,
                                    const PsReference& reference) {
    RELIEF_CHECK(check(data));
    const Task task{data, goal, progress, reference};
    if (const auto* interpolation = std::get_if<Interpolation>(&method))
        return interpolate(task, *interpolation);
    if (const auto* approximation = std::get_if<Approximation>(&method))
        return approximate(task, *approximation);
    return insert(task, std::get<Insertion>(method));
}

}  // namespace relief::codec
