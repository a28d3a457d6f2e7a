#include "relief/mesh/delaunay.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>

#include "mesh/delaunay_flips.h"
#include "mesh/hilbert.h"
#include "mesh/lattice_predicates.h"
#include "mesh/plane_checks.h"
#include "mesh/triangulation_checks.h"

namespace relief::mesh {

namespace {

constexpr std::size_t kMostPoints = ((std::size_t{1} << 31) - 1) / 6;
constexpr double kThinnestAtHull = 2e-12;  ///< more than what `build` refuses
constexpr int kSiteBits = 50;              ///< coordinates of sites are integers of at most 2^50

/// Points on a lattice around the centre of their bounding box.
struct Lattice {
    Vec2 origin;
    double step = 1;

    [[nodiscard]] Vec2 site(Vec2 point) const {
        const Vec2 p = point - origin;
        return {std::rint(p.x / step), std::rint(p.y / step)};
    }
};

Lattice lattice_of(std::span<const Vec2> points) {
    const Box box = box_of(points);
    const Vec2 origin = midpoint(box.low, box.high);
    const Vec2 reach = box.high - origin;
    int exponent = 0;
    std::frexp(std::max(reach.x, reach.y), &exponent);
    return {origin, std::ldexp(1.0, std::max(exponent - kSiteBits, -1074))};
}

/// Different sites along a Hilbert curve.
struct Sites {
    std::vector<Vec2> places;
    std::vector<Index> vertex_of_point;
    std::vector<Index> first_point;  ///< of each site
};

Sites sites_of(std::span<const Vec2> points, const Lattice& lattice) {
    struct Entry {
        std::uint64_t distance;
        Vec2 site;
        Index point;
    };
    std::vector<Entry> entries(points.size());
    const auto cell = [](double t) {
        const auto shifted = static_cast<std::uint64_t>(t + std::ldexp(1.0, kSiteBits));
        return static_cast<std::uint32_t>(shifted >> (kSiteBits - 30));
    };
    for (std::size_t k = 0; k < points.size(); ++k) {
        const Vec2 site = lattice.site(points[k]);
        entries[k] = {hilbert_distance(cell(site.x), cell(site.y)), site, static_cast<Index>(k)};
    }
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
        if (a.distance != b.distance) return a.distance < b.distance;
        return std::tie(a.site.x, a.site.y, a.point) < std::tie(b.site.x, b.site.y, b.point);
    });
    Sites sites;
    sites.vertex_of_point.resize(points.size());
    for (const Entry& entry : entries) {
        if (sites.places.empty() || entry.site != sites.places.back()) {
            sites.places.push_back(entry.site);
            sites.first_point.push_back(entry.point);
        }
        sites.vertex_of_point[entry.point] = static_cast<Index>(sites.places.size() - 1);
    }
    return sites;
}

/// In which of the rounds of insertion a vertex takes part: in the last with 3/4 of all, in the one
/// before with 3/16, .., by a fixed hash. So no order of the points is a bad one.
int rounds_before_last(Index v) {
    std::uint64_t hash = (v + 1) * 0x9E3779B97F4A7C15ULL;
    hash = (hash ^ hash >> 30) * 0xBF58476D1CE4E5B9ULL;
    return std::countr_zero(hash >> 32 | std::uint64_t{1} << 31) / 2;
}

/// Round by round, each along the curve; the first three not collinear, if there are such.
std::vector<Index> insertion_order(std::span<const Vec2> sites) {
    constexpr int kRounds = 16;
    std::array<Index, kRounds + 1> begin{};
    for (Index v = 0; v < sites.size(); ++v) ++begin[kRounds - rounds_before_last(v)];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<Index> order(sites.size());
    for (Index v = 0; v < sites.size(); ++v)
        order[begin[kRounds - 1 - rounds_before_last(v)]++] = v;
    const auto apex = std::find_if(order.begin() + 2, order.end(), [&](Index v) {
        return exact_orient(sites[order[0]], sites[order[1]], sites[v]) != 0;
    });
    if (apex != order.end()) std::swap(order[2], *apex);
    return order;
}

/// Which triangles stay: those of the plane, without the slivers at its hull.
std::vector<std::uint8_t> peeled(const FlipMesh& mesh, double least) {
    std::vector<std::uint8_t> kept(mesh.triangle_count);
    std::vector<std::uint8_t> on_boundary(mesh.sites.size());
    std::vector<Index> sides;  // of triangles that are kept, on the boundary
    for (Index t = 0; t < mesh.triangle_count; ++t) kept[t] = mesh.is_finite(t);
    for (Index h = 0; h < 3 * mesh.triangle_count; ++h)
        if (kept[h / 3] && !kept[mesh.twin[h] / 3]) {
            on_boundary[mesh.origin[h]] = 1;
            sides.push_back(h);
        }
    while (!sides.empty()) {
        const Index h = sides.back();
        sides.pop_back();
        const Index apex = mesh.origin[FlipMesh::prev(h)];
        const Vec2 a = mesh.sites[mesh.origin[h]];
        const Vec2 ab = mesh.sites[mesh.origin[FlipMesh::next(h)]] - a;
        const Vec2 ac = mesh.sites[apex] - a;
        const double along = dot(ab, ac);
        const bool sliver = cross(ab, ac) < least * dot(ab, ab) && along > 0 && along < dot(ab, ab);
        if (!kept[h / 3] || on_boundary[apex] || !sliver) continue;
        kept[h / 3] = 0;
        on_boundary[apex] = 1;
        sides.push_back(mesh.twin[FlipMesh::next(h)]);
        sides.push_back(mesh.twin[FlipMesh::prev(h)]);
    }
    return kept;
}

/// By their lowest vertices, which come first.
std::vector<std::array<Index, 3>> triangles_of(const FlipMesh& mesh,
                                               std::span<const std::uint8_t> kept) {
    const auto lowest = [&mesh](Index t) {
        const Index* v = mesh.origin.data() + 3 * t;
        return static_cast<Index>(std::min_element(v, v + 3) - v);
    };
    std::vector<Index> place(mesh.sites.size() + 1);
    for (Index t = 0; t < mesh.triangle_count; ++t)
        if (kept[t]) ++place[mesh.origin[3 * t + lowest(t)] + 1];
    std::partial_sum(place.begin(), place.end(), place.begin());
    std::vector<std::array<Index, 3>> triangles(place.back());
    for (Index t = 0; t < mesh.triangle_count; ++t) {
        if (!kept[t]) continue;
        const Index h = 3 * t + lowest(t);
        const Index a = mesh.origin[h];
        triangles[place[a]++] = {a, mesh.origin[FlipMesh::next(h)], mesh.origin[FlipMesh::prev(h)]};
    }
    return triangles;
}

Status check_points(std::span<const Vec2> points) {
    if (points.size() > kMostPoints)
        return Error{ErrorCode::BadInput,
                     "too_many_points: at most 2^31 / 6 can be triangulated; thin them out or "
                     "split the region",
                     ""};
    return check_coordinates(points, "non_finite_input", "point");
}

Error too_few_points(std::size_t places) {
    return {
        ErrorCode::BadInput,
        "too_few_points: they lie at " + std::to_string(places) + " places; at least 3 are needed",
        ""};
}

Result<FlipMesh> triangulated(const Sites& sites) {
    if (sites.places.size() < 3) return too_few_points(sites.places.size());
    const std::vector<Index> order = insertion_order(sites.places);
    if (exact_orient(sites.places[order[0]], sites.places[order[1]], sites.places[order[2]]) == 0)
        return Error{ErrorCode::BadInput,
                     "collinear_points: all points lie on one line; add one beside it", ""};
    return triangulate(sites.places, order);
}

/// Of each site one of those to which steps shorter than `distance` lead. They are all found along
/// edges, because the shortest tree that joins all sites is part of a Delaunay triangulation.
std::vector<Index> clusters(const FlipMesh& mesh, double distance) {
    std::vector<Index> up(mesh.sites.size());
    std::iota(up.begin(), up.end(), Index{0});
    const auto root = [&up](Index v) {
        while (up[v] != v) v = up[v] = up[up[v]];
        return v;
    };
    for (Index h = 0; h < 3 * mesh.triangle_count; ++h) {
        const Index a = mesh.origin[h];
        const Index b = mesh.origin[FlipMesh::next(h)];
        if (a >= b || b == mesh.infinite()) continue;
        if (length(mesh.sites[b] - mesh.sites[a]) < distance) up[root(b)] = root(a);
    }
    for (Index v = 0; v < up.size(); ++v) up[v] = root(v);
    return up;
}

/// One site for each cluster: that of its first point.
Sites merged(const Sites& sites, std::span<const Index> cluster) {
    const auto count = static_cast<Index>(sites.places.size());
    std::vector<Index> chosen(count, kNone);
    for (Index v = 0; v < count; ++v) {
        Index& best = chosen[cluster[v]];
        if (best == kNone || sites.first_point[v] < sites.first_point[best]) best = v;
    }
    Sites result;
    std::vector<Index> number(count);
    for (Index v = 0; v < count; ++v) {
        if (chosen[cluster[v]] != v) continue;
        number[v] = static_cast<Index>(result.places.size());
        result.places.push_back(sites.places[v]);
        result.first_point.push_back(sites.first_point[v]);
    }
    for (const Index v : sites.vertex_of_point)
        result.vertex_of_point.push_back(number[chosen[cluster[v]]]);
    return result;
}

/// Thin triangles inside come from points that are too close, not from a fault of the result.
Status check_distances(const Triangulation& mesh, std::span<const Index> first_point) {
    const auto thin = find_thin_triangle(mesh);
    if (!thin) return {};
    const auto& [a, b, c] = mesh.triangles[*thin];
    return Error{
        ErrorCode::BadInput,
        "degenerate_triangle: they lie almost on a line or at one place, and no triangle "
        "without them does; remove one, or merge points that are closer than some distance",
        "points " + std::to_string(first_point[a]) + ", " + std::to_string(first_point[b]) +
            " and " + std::to_string(first_point[c])};
}

}  // namespace

Result<Delaunay> delaunay(std::span<const Vec2> points, const DelaunayOptions& options) {
    RELIEF_CHECK(check_points(points));
    if (points.empty()) return too_few_points(0);
    const Lattice lattice = lattice_of(points);
    Sites sites = sites_of(points, lattice);
    RELIEF_TRY(FlipMesh flips, triangulated(sites));
    if (options.merge_distance > 0) {
        sites = merged(sites, clusters(flips, options.merge_distance / lattice.step));
        RELIEF_TRY(flips, triangulated(sites));
    }
    auto triangles = triangles_of(flips, peeled(flips, std::max(options.peel, kThinnestAtHull)));
    flips = {};
    std::vector<double> x;
    std::vector<double> y;
    for (const Vec2 site : sites.places) {
        x.push_back(site.x * lattice.step);
        y.push_back(site.y * lattice.step);
    }
    Delaunay result{connect(lattice.origin, std::move(x), std::move(y), std::move(triangles)),
                    std::move(sites.vertex_of_point)};
    RELIEF_CHECK(check_distances(result.mesh, sites.first_point));
    return result;
}

}  // namespace relief::mesh
