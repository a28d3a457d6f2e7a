#include "relief/mesh/delaunay.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>
#include <set>

#include "mesh/hilbert.h"
#include "mesh/lattice_predicates.h"
#include "mesh/triangle_meshes.h"

namespace relief::mesh {
namespace {

__extension__ using Wide = __int128;

struct Place {
    std::int64_t x = 0;
    std::int64_t y = 0;
    friend auto operator<=>(const Place&, const Place&) = default;
};

std::int64_t turn(Place a, Place b, Place c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// The determinant of the lifted points: positive if d lies in the circle.
int in_circle(Place a, Place b, Place c, Place d) {
    const auto lifted = [d](Place p) {
        return Wide{(p.x - d.x) * (p.x - d.x) + (p.y - d.y) * (p.y - d.y)};
    };
    const Wide sum =
        lifted(a) * turn(d, b, c) + lifted(b) * turn(d, c, a) + lifted(c) * turn(d, a, b);
    return (sum > 0) - (sum < 0);
}

/// Twice the area of the convex hull.
std::int64_t hull_area(std::vector<Place> places) {
    std::sort(places.begin(), places.end());
    const auto chain = [&](auto begin, auto end) {
        std::vector<Place> hull;
        for (auto p = begin; p != end; ++p) {
            while (hull.size() > 1 && turn(hull[hull.size() - 2], hull.back(), *p) <= 0)
                hull.pop_back();
            hull.push_back(*p);
        }
        return hull;
    };
    auto hull = chain(places.begin(), places.end());
    const auto upper = chain(places.rbegin(), places.rend());
    hull.insert(hull.end(), upper.begin() + 1, upper.end() - 1);
    std::int64_t area = 0;
    for (std::size_t k = 1; k + 1 < hull.size(); ++k) area += turn(hull[0], hull[k], hull[k + 1]);
    return area;
}

std::vector<Vec2> points_of(const std::vector<Place>& places) {
    std::vector<Vec2> points;
    for (const Place p : places) points.push_back({double(p.x), double(p.y)});
    return points;
}

Delaunay triangulated(const std::vector<Vec2>& points, double peel = 0) {
    auto result = delaunay(points, {.peel = peel});
    if (!result.ok()) throw std::runtime_error(result.error().text());
    return *std::move(result);
}

/// The integer place of every vertex. Its coordinates are exact: places are small integers.
std::vector<Place> places_of(const Triangulation& mesh) {
    std::vector<Place> places;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        const Vec2 p = mesh.origin + mesh.vertex(v);
        places.push_back({std::int64_t(p.x), std::int64_t(p.y)});
        RC_ASSERT(double(places.back().x) == p.x && double(places.back().y) == p.y);
    }
    return places;
}

/// Covers the convex hull once, with all edges locally Delaunay, which makes them globally so.
void expect_delaunay(const std::vector<Place>& points) {
    const Delaunay result = triangulated(points_of(points));
    const Triangulation& mesh = result.mesh;
    const std::vector<Place> places = places_of(mesh);
    RC_ASSERT(result.vertex_of_point.size() == points.size());
    for (std::size_t k = 0; k < points.size(); ++k)
        RC_ASSERT(places[result.vertex_of_point[k]] == points[k]);
    RC_ASSERT(std::set(places.begin(), places.end()).size() == places.size());
    RC_ASSERT(std::set(points.begin(), points.end()).size() == places.size());

    std::int64_t area = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
        RC_ASSERT(turn(places[a], places[b], places[c]) > 0);
        RC_ASSERT((a < b && a < c));
        area += turn(places[a], places[b], places[c]);
    }
    RC_ASSERT(area == hull_area(places));
    for (Index t = 0; t < mesh.triangle_count(); ++t)
        for (Index k = 0; k < 3; ++k) {
            const Index other = mesh.neighbour(t, k);
            if (other == kNone) continue;
            const auto& [a, b, c] = mesh.triangles[t];
            for (const Index v : mesh.triangles[other])
                RC_ASSERT(in_circle(places[a], places[b], places[c], places[v]) <= 0);
        }
    // Nothing overlaps, and what connect() made is what build() makes.
    std::vector<Vec2> vertices;
    for (Index v = 0; v < mesh.vertex_count(); ++v) vertices.push_back(mesh.vertex(v));
    const auto again = build(vertices, mesh.triangles, {.strict_orientation = true});
    RC_ASSERT(again.ok());
    RC_ASSERT(again->edges == mesh.edges && again->triangle_edges == mesh.triangle_edges);
}

bool on_a_line(const std::vector<Place>& p) {
    const auto other = std::find_if(p.begin(), p.end(), [&](Place q) { return q != p[0]; });
    return other == p.end() ||
           std::all_of(p.begin(), p.end(), [&](Place q) { return turn(p[0], *other, q) == 0; });
}

TEST(Delaunay, PlacesOfAllKinds) {
    EXPECT_TRUE(rc::check([] {
        // Up to here no triangle with an area of 1/2 is degenerate.
        const auto reach = *rc::gen::element<std::int64_t>(2, 5, 30, 1000, 1 << 19);
        const auto offset = *rc::gen::element<std::int64_t>(0, 2000000, -(1 << 28));
        const auto coordinate =
            rc::gen::map(rc::gen::arbitrary<std::int64_t>(),
                         [=](std::int64_t t) { return offset + (t % reach + reach) % reach; });
        const auto count = *rc::gen::inRange<std::size_t>(3, 200);
        std::vector<Place> points;
        for (std::size_t k = 0; k < count; ++k) points.push_back({*coordinate, *coordinate});
        RC_PRE(!on_a_line(points));
        expect_delaunay(points);
    }));
}

std::vector<Place> lattice(Index cols, Index rows, Place low = {}, std::int64_t step = 1) {
    std::vector<Place> points;
    for (Index r = 0; r < rows; ++r)
        for (Index c = 0; c < cols; ++c) points.push_back({low.x + c * step, low.y + r * step});
    return points;
}

TEST(Delaunay, LatticesFarAwayAndShuffled) {
    EXPECT_TRUE(rc::check([] {
        const auto cols = *rc::gen::inRange<Index>(2, 15);
        const auto rows = *rc::gen::inRange<Index>(2, 15);
        auto points = lattice(cols, rows, {2000000, -3000000});
        std::shuffle(points.begin(), points.end(), std::mt19937(*rc::gen::arbitrary<unsigned>()));
        expect_delaunay(points);
        // All squares are cut from the lower left to the upper right corner.
        const Triangulation mesh = triangulated(points_of(points)).mesh;
        RC_ASSERT(mesh.triangle_count() == 2 * (cols - 1) * (rows - 1));
        for (Index e = 0; e < mesh.edge_count(); ++e) {
            const Vec2 d = mesh.edge_vector(e);
            RC_ASSERT(d.x * d.y == 0 || d.x == d.y);
        }
    }));
}

/// Places on circles round the origin: Pythagorean triples of 65, and their multiples.
TEST(Delaunay, Cocircular) {
    std::vector<Place> ring;
    for (const auto& [x, y] : {std::pair{65, 0}, {63, 16}, {60, 25}, {56, 33}, {52, 39}})
        for (const auto& [a, b] : {std::pair{x, y}, {y, x}})
            for (const int s : {-1, 1})
                for (const int u : {-1, 1}) ring.push_back({s * a, u * b});
    EXPECT_EQ(std::set(ring.begin(), ring.end()).size(), 36u);
    EXPECT_TRUE(rc::check([&] {
        auto points = ring;
        if (*rc::gen::arbitrary<bool>()) points.push_back({0, 0});
        if (*rc::gen::arbitrary<bool>())
            for (const Place p : ring) points.push_back({2 * p.x, 2 * p.y});
        std::shuffle(points.begin(), points.end(), std::mt19937(*rc::gen::arbitrary<unsigned>()));
        points.resize(*rc::gen::inRange<std::size_t>(4, points.size()));
        RC_PRE(!on_a_line(points));
        expect_delaunay(points);
    }));
}

/// A triangulation in which the shorter diagonal of four places on a circle is joined.
TEST(Delaunay, FourOnACircleTakeTheShorterDiagonal) {
    const std::vector<Place> kite{{-65, 0}, {63, -16}, {65, 0}, {63, 16}};  // 32 against 130
    expect_delaunay(kite);
    const Triangulation mesh = triangulated(points_of(kite)).mesh;
    double shortest = std::numeric_limits<double>::infinity();
    for (Index e = 0; e < mesh.edge_count(); ++e)
        if (!mesh.on_boundary(e)) shortest = std::min(shortest, length(mesh.edge_vector(e)));
    EXPECT_EQ(shortest, 32);
}

TEST(Delaunay, ManyPlacesOfEachKind) {
    std::mt19937_64 random(7);
    const auto draw = [&](std::int64_t reach) { return std::int64_t(random() % reach); };
    std::vector<Place> uniform;
    std::vector<Place> clusters;
    std::vector<Place> lines;
    for (int k = 0; k < 4000; ++k) {
        uniform.push_back({draw(1 << 20), draw(1 << 20)});
        const std::int64_t far = (k % 3) << 27;
        clusters.push_back({far + draw(100), far / 2 + draw(100)});
        lines.push_back({draw(1 << 28), k % 2 ? 0 : 1000});
    }
    std::vector<Place> parabola;
    for (int k = -700; k <= 700; ++k) parabola.push_back({k, std::int64_t{k} * k});
    for (const auto& points :
         {uniform, clusters, lines, parabola, lattice(60, 60, {5, 7}, 1 << 20)})
        expect_delaunay(points);
}

TEST(Delaunay, PointsAtOnePlaceShareAVertex) {
    const std::vector<Vec2> points{{0, 0}, {1, 0}, {0, 0}, {0, 1}, {1, 0}, {0, -0.0}};
    const Delaunay result = triangulated(points);
    const auto& vertex = result.vertex_of_point;
    EXPECT_EQ(result.mesh.vertex_count(), 3u);
    EXPECT_EQ(vertex[2], vertex[0]);
    EXPECT_EQ(vertex[5], vertex[0]);
    EXPECT_EQ(vertex[4], vertex[1]);
    EXPECT_NE(vertex[3], vertex[0]);
    EXPECT_NE(vertex[1], vertex[0]);
}

TEST(Delaunay, VerticesStayAtTheirPoints) {
    test::Noise noise(4);
    std::vector<Vec2> points;
    for (int k = 0; k < 1000; ++k) points.push_back({3e5 + 1e3 * noise(), 5e6 + 2e3 * noise()});
    const Delaunay result = triangulated(points);
    for (std::size_t k = 0; k < points.size(); ++k) {
        const Vec2 p = result.mesh.vertex(result.vertex_of_point[k]);
        const Vec2 moved = p - (points[k] - result.mesh.origin);
        // Half a step of at most 2^-50 of the larger half side.
        EXPECT_LE(std::max(std::abs(moved.x), std::abs(moved.y)), 2e3 * 0x1p-50);
    }
}

TEST(Delaunay, ClosePointsAreMergedOnDemand) {
    test::Noise noise(6);
    std::vector<Vec2> points;
    for (int k = 0; k < 300; ++k) points.push_back({10 * noise(), 10 * noise()});
    // Chains of three, each 0.009 from the next, the last of which are 0.018 apart.
    for (int k = 0; k < 50; ++k)
        for (const double s : {0.018, 0.009}) points.push_back({points[k].x + s, points[k].y});
    const Delaunay apart = triangulated(points);
    EXPECT_EQ(apart.mesh.vertex_count(), 400u);
    const auto result = delaunay(points, {.peel = 0, .merge_distance = 0.01});
    ASSERT_TRUE(result.ok());
    const Triangulation& mesh = result->mesh;
    for (Index e = 0; e < mesh.edge_count(); ++e) EXPECT_GE(length(mesh.edge_vector(e)), 0.01);
    std::set<Index> used;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const Index v = result->vertex_of_point[k];
        used.insert(v);
        const bool late = k >= 300;
        EXPECT_EQ(v, result->vertex_of_point[late ? (k - 300) / 2 : k]);
        EXPECT_NEAR(length(mesh.vertex(v) - (points[k] - mesh.origin)),
                    !late        ? 0
                    : k % 2 == 0 ? 0.018
                                 : 0.009,
                    1e-12);
    }
    EXPECT_EQ(used.size(), mesh.vertex_count());
    EXPECT_EQ(used.size(), 300u);
    const auto none = delaunay(points, {.merge_distance = 100});
    ASSERT_FALSE(none.ok());
    EXPECT_EQ(none.error().message.substr(0, 14), "too_few_points");
}

TEST(Delaunay, TheOrderOfPointsDoesNotMatter) {
    test::Noise noise(8);
    std::vector<Vec2> points;
    for (int k = 0; k < 500; ++k) points.push_back({noise(), noise()});
    for (int k = 0; k < 100; ++k) points.push_back({0.1 * (k % 10), 0.1 * (k / 10 % 10)});
    const Delaunay expected = triangulated(points);
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::shuffle(order.begin(), order.end(), std::mt19937(2));
    std::vector<Vec2> shuffled;
    for (const std::size_t k : order) shuffled.push_back(points[k]);
    const Delaunay result = triangulated(shuffled);
    EXPECT_EQ(result.mesh.x, expected.mesh.x);
    EXPECT_EQ(result.mesh.y, expected.mesh.y);
    EXPECT_EQ(result.mesh.triangles, expected.mesh.triangles);
    for (std::size_t k = 0; k < order.size(); ++k)
        EXPECT_EQ(result.vertex_of_point[k], expected.vertex_of_point[order[k]]);
}

TEST(Delaunay, NumberingFollowsTheCurve) {
    const Triangulation mesh = triangulated(points_of(lattice(32, 32))).mesh;
    // On 2^k squared places that are centred in the quadrants of the curve every step is of
    // length 1.
    for (Index v = 1; v < mesh.vertex_count(); ++v)
        EXPECT_EQ(length(mesh.vertex(v) - mesh.vertex(v - 1)), 1);
    for (Index t = 1; t < mesh.triangle_count(); ++t)
        EXPECT_LE(mesh.triangles[t - 1][0], mesh.triangles[t][0]);
}

TEST(Delaunay, NamesWhatIsWrongWithPoints) {
    const auto refused = [](const std::vector<Vec2>& points) {
        const auto result = delaunay(points);
        if (result.ok()) return std::pair<std::string, std::string>();
        EXPECT_EQ(result.error().code, ErrorCode::BadInput);
        return std::pair(result.error().message.substr(0, result.error().message.find(':')),
                         result.error().where);
    };
    using Refusal = std::pair<std::string, std::string>;
    const double nan = std::nan("");
    EXPECT_EQ(refused({}), (Refusal{"too_few_points", ""}));
    EXPECT_EQ(refused({{1, 2}, {1, 2}, {1, 2}}), (Refusal{"too_few_points", ""}));
    EXPECT_EQ(refused({{1, 2}, {3, 4}, {1, 2}}), (Refusal{"too_few_points", ""}));
    EXPECT_EQ(refused({{0, 0}, {1, 3}, {2, 6}, {1, 3}, {-1, -3}}),
              (Refusal{"collinear_points", ""}));
    EXPECT_EQ(refused({{0, 0}, {1, 0}, {0, nan}}), (Refusal{"non_finite_input", "point 2"}));
    EXPECT_EQ(refused({{0, 0}, {-2e150, 0}, {0, 1}}), (Refusal{"non_finite_input", "point 1"}));
    EXPECT_EQ(refused({{0, 0}, {1, 1e-14}, {2, 0}, {0, 0}}),
              (Refusal{"degenerate_triangle", "points 0, 2 and 1"}));
    EXPECT_EQ(refused({{0, 0}, {1e150, 0}, {0, 1e150}, {-1e150, -1e150}}), Refusal());
    EXPECT_EQ(refused({{0, 0}, {1e-140, 0}, {0, 1e-140}}), Refusal());
}

/// A lattice whose lower boundary is bent inwards: slivers on the hull. Without them the smallest
/// angle is that of the lattice.
TEST(Delaunay, SliversAtTheHullArePeeled) {
    for (const double bend : {1e-3, 1e-6, 1e-9, 1e-11}) {
        std::vector<Vec2> points;
        for (int r = 0; r < 8; ++r)
            for (int c = 0; c < 8; ++c)
                points.push_back({double(c), r == 0 ? bend * c * (7 - c) : double(r)});
        const auto smallest = [&](double peel) {
            const Triangulation mesh = triangulated(points, peel).mesh;
            double angle = 180;
            for (Index t = 0; t < mesh.triangle_count(); ++t)
                angle = std::min(angle, smallest_angle(mesh.corners(t)));
            EXPECT_EQ(mesh.vertex_count(), 64u);
            std::vector<Vec2> vertices;
            for (Index v = 0; v < 64; ++v) vertices.push_back(mesh.vertex(v));
            EXPECT_TRUE(build(vertices, mesh.triangles).ok());
            return angle;
        };
        EXPECT_LT(smallest(0), 100 * bend);
        // Columns 1 .. 6 of the lower row rise by up to 0.012, so 45 degrees become 44.6 or more.
        EXPECT_GT(smallest(0.01), 44);
    }
}

/// Boundary points that are off their line by anything, down to less than the lattice tells apart.
TEST(Delaunay, NoisyLatticesAreValid) {
    test::Noise noise(12);
    for (double amplitude = 1e-3; amplitude > 1e-18; amplitude /= 10)
        for (const int side : {5, 9, 16}) {
            std::vector<Vec2> points;
            for (int r = 0; r < side; ++r)
                for (int c = 0; c < side; ++c) {
                    const bool inside = r > 0 && r + 1 < side && c > 0 && c + 1 < side;
                    const double off = inside ? 0 : amplitude;
                    points.push_back({0.1 * c + off * noise(), 0.1 * r + off * noise()});
                }
            const Triangulation mesh = triangulated(points, 0.01).mesh;
            std::vector<Vec2> vertices;
            for (Index v = 0; v < mesh.vertex_count(); ++v) vertices.push_back(mesh.vertex(v));
            EXPECT_EQ(vertices.size(), points.size());
            EXPECT_TRUE(
                build(vertices, mesh.triangles, {.strict_orientation = true, .check_overlap = true})
                    .ok());
            double area = 0;
            for (Index t = 0; t < mesh.triangle_count(); ++t) {
                const auto [a, b, c] = mesh.corners(t);
                area += orient(a, b, c) / 2;
                EXPECT_GT(smallest_angle(mesh.corners(t)), 1) << amplitude;
            }
            // The square, but for noise at its sides.
            const double whole = 0.01 * (side - 1) * (side - 1);
            EXPECT_NEAR(area, whole, 4 * 0.1 * side * amplitude + 1e-9);
        }
}

TEST(Delaunay, PeelingTakesNothingElse) {
    test::Noise noise(11);
    std::vector<Vec2> points;
    for (int k = 0; k < 3000; ++k) points.push_back({noise(), noise()});
    const Triangulation full = triangulated(points, 0).mesh;
    const Triangulation mesh = triangulated(points, 0.01).mesh;
    EXPECT_LT(mesh.triangle_count(), full.triangle_count());
    EXPECT_EQ(mesh.x, full.x);
    std::set<std::array<Index, 3>> kept(mesh.triangles.begin(), mesh.triangles.end());
    for (const auto& triangle : mesh.triangles)
        EXPECT_TRUE(std::binary_search(full.triangles.begin(), full.triangles.end(), triangle,
                                       [](const auto& a, const auto& b) { return a[0] < b[0]; }));
    double lost = 0;
    for (Index t = 0; t < full.triangle_count(); ++t) {
        if (kept.contains(full.triangles[t])) continue;
        const auto [a, b, c] = full.corners(t);
        const double longest = std::max({length(b - a), length(c - b), length(a - c)});
        EXPECT_LT(orient(a, b, c), 0.01 * longest * longest);
        lost += orient(a, b, c) / 2;
    }
    double area = 0;
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
        const auto [a, b, c] = mesh.corners(t);
        area += orient(a, b, c) / 2;
    }
    EXPECT_GT(area, 3.9);  // of 4
    EXPECT_GT(lost, 0);
    // What is left has no sliver that could be peeled.
    std::vector<char> on_boundary(mesh.vertex_count());
    for (Index e = 0; e < mesh.edge_count(); ++e)
        if (mesh.on_boundary(e)) on_boundary[mesh.edges[e][0]] = on_boundary[mesh.edges[e][1]] = 1;
    for (Index t = 0; t < mesh.triangle_count(); ++t)
        for (Index k = 0; k < 3; ++k) {
            const Index apex = mesh.triangles[t][(k + 2) % 3];
            if (mesh.neighbour(t, k) != kNone || on_boundary[apex]) continue;
            const Vec2 a = mesh.vertex(mesh.triangles[t][k]);
            const Vec2 ab = mesh.vertex(mesh.triangles[t][(k + 1) % 3]) - a;
            const Vec2 ac = mesh.vertex(apex) - a;
            const double along = dot(ab, ac) / dot(ab, ab);
            EXPECT_TRUE(cross(ab, ac) >= 0.01 * dot(ab, ab) || along <= 0 || along >= 1);
        }
}

/// Against integers of the same size that a slower route computes.
TEST(LatticePredicates, SignsAreExact) {
    EXPECT_TRUE(rc::check([] {
        const auto bits = *rc::gen::element(3, 10, 28);
        const auto coordinate = rc::gen::inRange<std::int64_t>(-(1LL << bits), 1LL << bits);
        std::array<Place, 4> p;
        for (Place& place : p) place = {*coordinate, *coordinate};
        std::array<Vec2, 4> v;
        // Far larger numbers have the same signs.
        const double scale = *rc::gen::element(1.0, 0x1p20);
        for (int k = 0; k < 4; ++k) v[k] = {scale * double(p[k].x), scale * double(p[k].y)};
        const std::int64_t side = turn(p[0], p[1], p[2]);
        RC_ASSERT(exact_orient(v[0], v[1], v[2]) == (side > 0) - (side < 0));
        RC_ASSERT(exact_in_circle(v[0], v[1], v[2], v[3]) == in_circle(p[0], p[1], p[2], p[3]));
    }));
}

/// Corners of a rectangle lie on a circle; one step inwards or outwards is not on it.
TEST(LatticePredicates, OneStepOfTheLatticeDecides) {
    const double w = 0x1p49 + 12345;
    const double h = 0x1p48 + 77;
    const Vec2 a{-w, -h};
    const Vec2 b{w, -h};
    const Vec2 c{w, h};
    EXPECT_EQ(exact_in_circle(a, b, c, {-w, h}), 0);
    EXPECT_EQ(exact_in_circle(a, b, c, {-w + 1, h}), 1);
    EXPECT_EQ(exact_in_circle(a, b, c, {-w - 1, h}), -1);
    EXPECT_EQ(exact_in_circle(a, b, c, {-w, h - 1}), 1);
    EXPECT_EQ(exact_in_circle(a, b, c, {-w, h + 1}), -1);
    EXPECT_EQ(exact_orient(a, {0, 0}, c), 0);
    EXPECT_EQ(exact_orient(a, {0, 1}, c), -1);
    EXPECT_EQ(exact_orient(a, {1, 0}, c), 1);
    EXPECT_EQ(exact_compare_lengths(c, {w, h + 1}), 1);
    EXPECT_EQ(exact_compare_lengths(c, b), 0);
}

TEST(Hilbert, VisitsEveryCellThenItsNeighbour) {
    std::vector<std::pair<std::uint64_t, std::array<int, 2>>> cells;
    for (int x = 0; x < 32; ++x)
        for (int y = 0; y < 32; ++y)
            cells.push_back({hilbert_distance(std::uint32_t(x), std::uint32_t(y)), {x, y}});
    std::sort(cells.begin(), cells.end());
    for (std::size_t k = 0; k < cells.size(); ++k) {
        EXPECT_EQ(cells[k].first, k);
        if (k == 0) continue;
        const auto& [x, y] = cells[k].second;
        const auto& [before_x, before_y] = cells[k - 1].second;
        EXPECT_EQ(std::abs(x - before_x) + std::abs(y - before_y), 1);
    }
}

}  // namespace
}  // namespace relief::mesh
