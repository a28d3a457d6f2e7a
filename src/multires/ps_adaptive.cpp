#include "relief/multires/ps_adaptive.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "relief/mesh/delaunay.h"
#include "relief/mesh/triangle_locator.h"

namespace relief::multires::ps {

using mesh::Index;
using mesh::kNone;

namespace {

/// Hull slivers that are peeled off.
constexpr double kPeel = 1e-2;
/// Triangles get a vertex if their worst point is off by so much of the worst of all.
constexpr double kShareOfWorst = 0.3;
constexpr int kMostRounds = 200;
constexpr double kLargest = 1e150;
constexpr std::size_t kMostComponents = 3;
constexpr std::size_t kNoLimit = static_cast<std::size_t>(-1);

bool usable(double number) {
    return std::abs(number) <= kLargest;
}

Error not_usable(std::size_t point) {
    return {ErrorCode::BadInput,
            "non_finite_input: it is not made of numbers of at most 1e150; leave the point out or "
            "correct it",
            "point " + std::to_string(point)};
}

/// Points at one place.
struct Place {
    Vec2 at;
    /// Of each component: in the middle of theirs, and from there to the least and the greatest.
    std::array<double, kMostComponents> value{};
    std::array<double, kMostComponents> half_range{};
    std::size_t first = 0;  ///< those farthest apart in one component
    std::size_t last = 0;

    /// Makes some points, the first of which has been taken in, one place.
    void add(std::span<const std::size_t> points, const std::vector<double>& values,
             std::size_t component) {
        const auto less = [&](std::size_t a, std::size_t b) { return values[a] < values[b]; };
        const auto [low, high] = std::minmax_element(points.begin(), points.end(), less);
        value[component] = 0.5 * values[*low] + 0.5 * values[*high];
        half_range[component] = 0.5 * values[*high] - 0.5 * values[*low];
        const double widest = *std::max_element(half_range.begin(), half_range.end());
        if (component > 0 && half_range[component] < widest) return;
        first = std::min(*low, *high);
        last = std::max(*low, *high);
    }
};

/// In the order of x, then y.
std::vector<Place> places_of(const ScatteredData& data) {
    std::vector<std::size_t> order(data.points.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        const Vec2 p = data.points[a];
        const Vec2 q = data.points[b];
        if (p.x != q.x) return p.x < q.x;
        return p.y != q.y ? p.y < q.y : a < b;
    });
    std::vector<Place> places;
    for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
        const Vec2 at = data.points[order[begin]];
        while (end < order.size() && data.points[order[end]] == at) ++end;
        Place place;
        place.at = at;
        const std::span points(order.data() + begin, end - begin);
        for (std::size_t m = 0; m < data.components.size(); ++m)
            place.add(points, data.components[m], m);
        places.push_back(place);
    }
    return places;
}

/// The places on the convex hull, collinear ones left out. Requires: sorted.
void add_hull(const std::vector<Place>& places, std::vector<std::uint8_t>& chosen) {
    const auto chain = [&](auto begin, auto end) {
        std::vector<std::size_t> hull;
        for (auto k = begin; k != end; ++k) {
            const auto place = static_cast<std::size_t>(*k);
            const auto bends = [&] {
                const Vec2 a = places[hull[hull.size() - 2]].at;
                const Vec2 b = places[hull.back()].at;
                return cross(b - a, places[place].at - a) > 0;
            };
            while (hull.size() >= 2 && !bends()) hull.pop_back();
            hull.push_back(place);
        }
        for (const std::size_t place : hull) chosen[place] = 1;
    };
    std::vector<std::size_t> order(places.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    chain(order.begin(), order.end());
    chain(order.rbegin(), order.rend());
}

/// About `count` places all over the domain: that nearest to the middle of each cell of a lattice.
void add_spread(const std::vector<Place>& places, std::size_t count,
                std::vector<std::uint8_t>& chosen) {
    Vec2 low = places.front().at;
    Vec2 high = low;
    for (const Place& place : places) {
        low = {std::min(low.x, place.at.x), std::min(low.y, place.at.y)};
        high = {std::max(high.x, place.at.x), std::max(high.y, place.at.y)};
    }
    const Vec2 extent = high - low;
    const double cell =
        std::sqrt(extent.x * extent.y / static_cast<double>(std::max<std::size_t>(count, 1)));
    if (count == 0 || !(cell > 0)) return;
    const auto cells = [&](double length) {
        return std::clamp<std::size_t>(static_cast<std::size_t>(length / cell), 1, count);
    };
    const std::size_t cols = cells(extent.x);
    const std::size_t rows = cells(extent.y);
    std::vector<std::size_t> best(rows * cols, places.size());
    std::vector<double> least(rows * cols, std::numeric_limits<double>::infinity());
    const auto part = [](double t, std::size_t n) {
        return std::min(static_cast<std::size_t>(t * static_cast<double>(n)), n - 1);
    };
    for (std::size_t k = 0; k < places.size(); ++k) {
        const Vec2 t{(places[k].at.x - low.x) / extent.x, (places[k].at.y - low.y) / extent.y};
        const std::size_t col = part(t.x, cols);
        const std::size_t row = part(t.y, rows);
        const double dx = t.x * static_cast<double>(cols) - static_cast<double>(col) - 0.5;
        const double dy = t.y * static_cast<double>(rows) - static_cast<double>(row) - 0.5;
        const double distance = dx * dx + dy * dy;
        if (distance >= least[row * cols + col]) continue;
        least[row * cols + col] = distance;
        best[row * cols + col] = k;
    }
    for (const std::size_t k : best)
        if (k < places.size()) chosen[k] = 1;
}

std::size_t count_of(const std::vector<std::uint8_t>& chosen) {
    return static_cast<std::size_t>(std::count(chosen.begin(), chosen.end(), std::uint8_t{1}));
}

/// Of the places outside the mesh the outermost at each boundary triangle. Whether there was one.
bool add_outermost(const mesh::Triangulation& mesh, const std::vector<Place>& places,
                   std::vector<std::uint8_t>& chosen) {
    struct Outermost {
        double distance = -1;
        std::size_t place = 0;
    };
    std::vector<Vec2> points;
    for (const Place& place : places) points.push_back(place.at);
    const mesh::TriangleLocator locator(mesh);
    std::vector<Index> triangles(points.size());
    locator.locate(points, triangles);
    std::map<Index, Outermost> outermost;
    for (std::size_t k = 0; k < points.size(); ++k) {
        if (triangles[k] != kNone || chosen[k] != 0) continue;
        const mesh::TrianglePlace nearest = locator.nearest(points[k]);
        const Vec2 way = points[k] - mesh.origin - nearest.point;
        Outermost& most = outermost[nearest.triangle];
        if (dot(way, way) > most.distance) most = {dot(way, way), k};
    }
    for (const auto& [triangle, most] : outermost) chosen[most.place] = 1;
    return !outermost.empty();
}

/// The Delaunay triangulation of the chosen places and of others that would lie outside: slivers
/// at the hull are peeled off with what is in them.
Result<mesh::Delaunay> triangulate(const std::vector<Place>& places, std::size_t most_vertices,
                                   std::vector<std::uint8_t>& chosen) {
    for (;;) {
        std::vector<Vec2> vertices;
        for (std::size_t k = 0; k < places.size(); ++k)
            if (chosen[k] != 0) vertices.push_back(places[k].at);
        RELIEF_TRY(mesh::Delaunay delaunay, mesh::delaunay(vertices, {kPeel}));
        if (vertices.size() >= most_vertices || !add_outermost(delaunay.mesh, places, chosen))
            return delaunay;
    }
}

class Refiner {
  public:
    Refiner(const ScatteredData& data, const AdaptiveOptions& options)
        : data_(data), options_(options), places_(places_of(data)), chosen_(places_.size(), 0) {
        add_hull(places_, chosen_);
        add_spread(places_, std::min(options.first_vertices, options.most_vertices), chosen_);
    }

    Result<AdaptiveSurface> run() {
        for (int round = 1;; ++round) {
            RELIEF_TRY(AdaptiveSurface surface, fit());
            surface.rounds = round;
            const std::size_t within = places_.size() - violators_.size();
            const double done = static_cast<double>(within) /
                                static_cast<double>(std::max<std::size_t>(places_.size(), 1));
            if (options_.progress && !options_.progress(done))
                return Error{ErrorCode::Cancelled, "cancelled", ""};
            const std::size_t added = choose_more(surface.space.mesh.triangle_count());
            if (added > 0 && round < kMostRounds) continue;
            tell(surface);
            return surface;
        }
    }

  private:
    /// A place beyond the bound.
    struct Violator {
        std::size_t place;
        Index triangle;
        double off;
    };

    Result<AdaptiveSurface> fit() {
        RELIEF_TRY(mesh::Delaunay delaunay, triangulate(places_, options_.most_vertices, chosen_));
        std::vector<std::size_t> place_of_point;
        for (std::size_t k = 0; k < places_.size(); ++k)
            if (chosen_[k] != 0) place_of_point.push_back(k);
        AdaptiveSurface surface;
        RELIEF_TRY(surface.space, make_space(std::move(delaunay.mesh)));
        const Space& space = surface.space;
        const mesh::TriangleLocator locator(space.mesh);
        locate(space.mesh, locator);
        RELIEF_TRY(
            const LeastSquares squares,
            LeastSquares::create(space, {moved_, triangles_, data_.weights}, options_.energy));
        const std::vector<std::span<const double>> values(data_.components.begin(),
                                                          data_.components.end());
        RELIEF_TRY(FittedSplines fitted, squares.fit(values, options_.smoothing));
        surface.components = std::move(fitted.components);
        surface.report.smoothing = options_.smoothing;
        correct(surface, delaunay.vertex_of_point, place_of_point);
        measure(surface, squares);
        return surface;
    }

    /// Points outside the domain, which are in hull slivers, move to its boundary.
    void locate(const mesh::Triangulation& mesh, const mesh::TriangleLocator& locator) {
        moved_.assign(data_.points.begin(), data_.points.end());
        triangles_.resize(moved_.size());
        locator.locate(moved_, triangles_);
        for (std::size_t k = 0; k < moved_.size(); ++k) {
            if (triangles_[k] != kNone) continue;
            const mesh::TrianglePlace place = locator.nearest(moved_[k]);
            triangles_[k] = place.triangle;
            moved_[k] = place.point + mesh.origin;
        }
    }

    /// Vertices that least squares left beyond the bound are raised or lowered to their places.
    void correct(AdaptiveSurface& surface, const std::vector<Index>& vertex_of_point,
                 const std::vector<std::size_t>& place_of_point) const {
        for (std::size_t k = 0; k < place_of_point.size(); ++k) {
            const Index v = vertex_of_point[k];
            const Place& place = places_[place_of_point[k]];
            for (std::size_t m = 0; m < surface.components.size(); ++m) {
                Heights& heights = surface.components[m][v];
                const double off =
                    place.value[m] - tangent_plane(surface.space.control[v], heights).value;
                if (std::abs(off) + place.half_range[m] <= options_.max_error) continue;
                for (double& height : heights) height += off;
            }
        }
    }

    void measure(AdaptiveSurface& surface, const LeastSquares& squares) {
        off_.assign(data_.points.size(), 0);
        std::vector<double> at(data_.points.size());
        std::vector<Violator> of_place(places_.size(), Violator{0, 0, -1});
        double squared = 0;
        for (std::size_t m = 0; m < surface.components.size(); ++m) {
            squares.evaluate(surface.components[m], at);
            for (std::size_t k = 0; k < at.size(); ++k) {
                const double off = std::abs(at[k] - data_.components[m][k]);
                squared += weight(k) * off * off;
                off_[k] = std::max(off_[k], off);
            }
            find_violators(m, at, of_place);
        }
        report_errors(surface, squared);
        violators_.clear();
        worst_ = 0;
        for (std::size_t p = 0; p < places_.size(); ++p) {
            if (of_place[p].off < 0) continue;
            violators_.push_back(of_place[p]);
            if (chosen_[p] == 0) worst_ = std::max(worst_, of_place[p].off);
        }
    }

    [[nodiscard]] double weight(std::size_t point) const {
        return data_.weights.empty() ? 1 : data_.weights[point];
    }

    void find_violators(std::size_t component, std::span<const double> at,
                        std::vector<Violator>& of_place) const {
        for (std::size_t p = 0; p < places_.size(); ++p) {
            const std::size_t k = places_[p].first;
            const double off = std::abs(at[k] - places_[p].value[component]);
            if (off + places_[p].half_range[component] <= options_.max_error) continue;
            of_place[p] = {p, triangles_[k], std::max(of_place[p].off, off)};
        }
    }

    void report_errors(AdaptiveSurface& surface, double squared) const {
        FitReport& report = surface.report;
        double weights = 0;
        for (std::size_t k = 0; k < off_.size(); ++k) {
            weights += weight(k);
            surface.beyond += off_[k] > options_.max_error;
            if (off_[k] <= report.max_error) continue;
            report.max_error = off_[k];
            report.worst = k;
        }
        report.rms_error = std::sqrt(squared / weights);
    }

    /// The worst place of each triangle, if it is bad enough, becomes a vertex.
    std::size_t choose_more(Index triangle_count) {
        std::vector<std::size_t> worst(triangle_count, violators_.size());
        for (std::size_t k = 0; k < violators_.size(); ++k) {
            const Violator& v = violators_[k];
            if (chosen_[v.place] != 0) continue;
            std::size_t& best = worst[v.triangle];
            if (best == violators_.size() || v.off > violators_[best].off) best = k;
        }
        const std::size_t vertices = count_of(chosen_);
        std::size_t added = 0;
        for (const std::size_t k : worst) {
            if (k == violators_.size() || violators_[k].off < kShareOfWorst * worst_) continue;
            if (vertices + added >= options_.most_vertices) break;
            chosen_[violators_[k].place] = 1;
            ++added;
        }
        return added;
    }

    void tell(AdaptiveSurface& surface) const {
        if (surface.beyond == 0) return;
        for (const Place& place : places_)
            if (*std::max_element(place.half_range.begin(), place.half_range.end()) >
                options_.max_error) {
                surface.reason = "points " + std::to_string(place.first) + " and " +
                                 std::to_string(place.last) +
                                 " lie at the same place and their values are farther apart than "
                                 "twice the bound";
                return;
            }
        const auto open = std::count_if(violators_.begin(), violators_.end(),
                                        [&](const auto& v) { return chosen_[v.place] == 0; });
        surface.reason = open > 0 ? "more vertices are needed than are allowed"
                                  : "points are too close to each other to be told apart";
    }

    const ScatteredData& data_;
    const AdaptiveOptions& options_;
    std::vector<Place> places_;
    std::vector<std::uint8_t> chosen_;  ///< of each place: whether it is a vertex
    std::vector<Vec2> moved_;           ///< the points, inside the domain
    std::vector<Index> triangles_;      ///< of each point
    std::vector<double> off_;           ///< of each point, in its worst component
    std::vector<Violator> violators_;
    double worst_ = 0;  ///< of the places that are not vertices yet
};

Status check(const ScatteredData& data, const AdaptiveOptions& options) {
    if (!(options.max_error >= 0) || std::isinf(options.max_error))
        return Error{ErrorCode::InvalidArgument,
                     "invalid_parameter: the bound is a number from 0 on", "max_error"};
    if (!(options.smoothing > 0) || std::isinf(options.smoothing))
        return Error{ErrorCode::InvalidArgument, "invalid_parameter: smoothing is a number above 0",
                     "smoothing"};
    if (data.components.empty() || data.components.size() > kMostComponents)
        return Error{ErrorCode::InvalidArgument,
                     "component_count: points have one to three values each", "points"};
    for (const std::vector<double>& values : data.components)
        if (values.size() != data.points.size())
            return Error{ErrorCode::BadInput,
                         "size_mismatch: " + std::to_string(values.size()) + " values for " +
                             std::to_string(data.points.size()) + " points",
                         "points"};
    for (std::size_t k = 0; k < data.points.size(); ++k) {
        bool good = usable(data.points[k].x) && usable(data.points[k].y);
        for (const std::vector<double>& values : data.components) good = good && usable(values[k]);
        if (!good) return not_usable(k);
    }
    return {};
}

}  // namespace

Result<mesh::Triangulation> spread_triangulation(std::span<const Vec2> points, std::size_t count) {
    for (std::size_t k = 0; k < points.size(); ++k)
        if (!usable(points[k].x) || !usable(points[k].y)) return not_usable(k);
    const std::vector<Place> places = places_of({points, {}, {}});
    std::vector<std::uint8_t> chosen(places.size(), 0);
    add_hull(places, chosen);
    const std::size_t hull = count_of(chosen);
    if (!places.empty() && count > hull) add_spread(places, count - hull, chosen);
    RELIEF_TRY(mesh::Delaunay delaunay, triangulate(places, kNoLimit, chosen));
    return std::move(delaunay.mesh);
}

Result<AdaptiveSurface> fit_within(const ScatteredData& data, const AdaptiveOptions& options) {
    RELIEF_CHECK(check(data, options));
    if (data.points.size() < 3)
        return Error{ErrorCode::BadInput, "too_few_points: a surface needs three places", "points"};
    return Refiner(data, options).run();
}

}  // namespace relief::multires::ps
