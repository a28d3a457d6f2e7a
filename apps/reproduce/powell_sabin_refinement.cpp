#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "functions.h"
#include "powell_sabin.h"
#include "relief/multires/ps_lift.h"
#include "relief/multires/ps_surface.h"
#include "relief/spline/control_triangle.h"

/// The statements of sections 2 and 3 of the text, as numbers.
namespace relief::reproduce::ps_text {

namespace {

using mesh::Index;
using mesh::TriangleLocator;
using spline::PlaneJet;

constexpr int kGrid = 101;  ///< points a side of the unit square

std::vector<Vec2> grid_points() {
    std::vector<Vec2> points;
    for (int row = 0; row < kGrid; ++row)
        for (int col = 0; col < kGrid; ++col)
            points.push_back({col / (kGrid - 1.0), row / (kGrid - 1.0)});
    return points;
}

std::vector<PlaneJet> jets(const ps::Space& space, const ps::Coefficients& spline,
                           const std::vector<Vec2>& points) {
    const ps::Surface surface = *ps::Surface::create(space, std::span(&spline, 1));
    std::vector<PlaneJet> result(points.size());
    const Status done =
        ps::evaluate(surface, TriangleLocator(space.mesh), points, result, ps::Outside::Nearest);
    return done.ok() ? result : std::vector<PlaneJet>();
}

double largest_difference(const std::vector<PlaneJet>& a, const std::vector<PlaneJet>& b) {
    double largest = 0;
    for (std::size_t k = 0; k < a.size(); ++k)
        largest = std::max(largest, std::abs(a[k].value - b[k].value));
    return largest;
}

double area(const TriangleCorners& t) {
    return std::abs(orient(t[0], t[1], t[2])) / 2;
}

// --- section 2

void b_splines(Rows& rows) {
    const ps::Space space = random_space(60, 1);
    const std::vector<Vec2> points = grid_points();
    std::vector<double> sum(points.size());
    double least = 0;
    for (const ps::Coefficients& b_spline : all_b_splines(space)) {
        const std::vector<PlaneJet> values = jets(space, b_spline, points);
        for (std::size_t k = 0; k < points.size(); ++k) {
            least = std::min(least, values[k].value);
            sum[k] += values[k].value;
        }
    }
    double off = 0;
    for (const double s : sum) off = std::max(off, std::abs(s - 1));
    rows.add("(2.5), 60 vertices", "least value of a B-spline", 0, least);
    rows.add("(2.6), 60 vertices", "largest difference of their sum from 1", 0, off);

    const ps::Coefficients spline = franke_spline(space);
    std::vector<Vec2> vertices;
    for (Index v = 0; v < space.mesh.vertex_count(); ++v)
        vertices.push_back(space.mesh.origin + space.mesh.vertex(v));
    double value = 0;
    double gradient = 0;
    const std::vector<PlaneJet> found = jets(space, spline, vertices);
    for (std::size_t v = 0; v < vertices.size(); ++v) {
        const PlaneJet wanted = franke(vertices[v]);
        value = std::max(value, std::abs(found[v].value - wanted.value));
        gradient = std::max(gradient, length(found[v].gradient - wanted.gradient));
    }
    rows.add("(2.3), Franke", "error of values at vertices", 0, value);
    rows.add("(2.3), Franke", "error of gradients at vertices", 0, gradient, "gradients up to 5");
    for (const int side : {4, 8, 16, 32}) {
        const ps::Space lattice = squares(side);
        double error = 0;
        const std::vector<PlaneJet> at = jets(lattice, franke_spline(lattice), points);
        for (std::size_t k = 0; k < points.size(); ++k)
            error = std::max(error, std::abs(at[k].value - franke(points[k]).value));
        rows.add("(2.3), Franke", fmt::format("largest error on {0} x {0} squares", side), {},
                 error, "third order");
    }
}

void smallest_triangles(Rows& rows) {
    std::vector<Vec2> hexagon;
    for (int k = 0; k < 6; ++k) hexagon.push_back({std::cos(k * M_PI / 3), std::sin(k * M_PI / 3)});
    const std::vector<Vec2> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    rows.add("section 2.3", "smallest triangle around a regular hexagon", 9 * std::sqrt(3.0) / 4,
             area(*spline::smallest_triangle(hexagon)),
             "exact: 9 sqrt(3) / 4; no quadratic program");
    rows.add("section 2.3", "smallest triangle around a unit square", 2,
             area(*spline::smallest_triangle(square)));
}

// --- section 3.1

void refinements(Rows& rows) {
    const ps::Space space = random_space(60, 1);
    const ps::Coefficients spline = franke_spline(space);
    const std::vector<Vec2> points = grid_points();
    const std::vector<PlaneJet> before = jets(space, spline, points);
    const ps::Hierarchy hierarchy = *ps::Hierarchy::create(space, 3);
    ps::Coefficients finer = spline;
    for (int level = 0; level < 3; ++level) {
        finer = prolong(hierarchy.space(level), hierarchy.step(level), finer);
        const ps::Space& fine = hierarchy.space(level + 1);
        const std::string after =
            fmt::format("after {} triadic step{}", level + 1, level ? "s" : "");
        rows.add("section 3.1.2", "change of the surface " + after, 0,
                 largest_difference(before, jets(fine, finer, points)), "values up to 1.2");
        rows.add("section 3.2.1", "control points outside, " + after, 0, ps::enclosure_excess(fine),
                 "barycentric");
    }
    const ps::Refinement root3 = *refine(space, {.scheme = ps::Scheme::Root3});
    rows.add("section 3.1.2", "change of the surface after one sqrt(3) step", 0,
             largest_difference(before, jets(root3.fine, prolong(space, root3, spline), points)));
    rows.add("section 3.1.2", "triangles for each after a sqrt(3) step", 3,
             static_cast<double>(root3.fine.mesh.triangle_count()) / space.mesh.triangle_count());
    rows.add("section 3.1.2", "triangles for each after a triadic step", 9,
             static_cast<double>(hierarchy.space(1).mesh.triangle_count()) /
                 space.mesh.triangle_count());
    int dyadic = 0;
    constexpr int kMeshes = 20;
    for (unsigned seed = 0; seed < kMeshes; ++seed)
        dyadic += refine(random_space(30, seed), {.scheme = ps::Scheme::Dyadic}).ok();
    rows.add("section 3.1.1", "random meshes that a dyadic step applies to", {},
             static_cast<double>(dyadic) / kMeshes, "\"not generally applicable\"");
}

/// Where the cut of an edge lies, in the uniform case; and when the new lines meet before Z.
void cuts(Rows& rows) {
    const std::array<Vec2, 3> corners{Vec2{0, 0}, {1, 0}, {0.5, std::sqrt(0.75)}};
    const std::array<std::array<Index, 3>, 1> triangle{{{0, 1, 2}}};
    const ps::Space uniform = *ps::make_space(*mesh::build(corners, triangle));
    const ps::Refinement step = *refine(uniform);
    // Vertices: 3 old, 1 in the triangle, two on each edge.
    rows.add("section 3.1.2", "part of an edge before its cut, equilateral", 1.0 / 3,
             length(step.fine.mesh.vertex(4) - step.fine.mesh.vertex(0)), "omega = 1/3");

    // R at 95 per cent of the two short edges.
    const TriangleCorners flat{Vec2{0, 0}, {1, 0.1}, {-1, 0.1}};
    const double short_side = length(flat[1] - flat[0]);
    const double long_side = length(flat[2] - flat[1]);
    const double whole = 2 * short_side + long_side;
    const Vec2 centre = (long_side / whole) * flat[0] +
                        ((short_side / whole) * flat[1] + (short_side / whole) * flat[2]);
    const spline::PsElement element(flat, centre, {0.05, 0.5, 0.95});
    const double rho = 1 / element.inverse_ratios()[0];
    rows.add("section 3.1.2, flat triangle", "rho", {}, rho, "needed: (1 - omega) rho < 1");
    for (const double omega : {1.0 / 3, 1.0 / 6, 1.0 / 12})
        rows.add("section 3.1.2, flat triangle",
                 fmt::format("(1 - omega) rho, omega {:.4f}", omega), {}, (1 - omega) * rho,
                 "the text halves omega: worse");
    rows.add("section 3.1.2, flat triangle", "(1 - omega) rho, omega 2/3", {}, rho / 3,
             "1 - omega halved: valid");
}

void valences(Rows& rows) {
    const ps::Space space = random_space(60, 1);
    const Index old = space.mesh.vertex_count();
    const auto least_and_most = [&](const ps::Space& fine) {
        const auto stars = mesh::vertex_neighbours(fine.mesh);
        std::size_t least = 100;
        std::size_t most = 0;
        // Those in triangles.
        for (Index v = old; v < old + space.mesh.triangle_count(); ++v) {
            least = std::min(least, stars.of(v).size());
            most = std::max(most, stars.of(v).size());
        }
        return std::pair(static_cast<double>(least), static_cast<double>(most));
    };
    const auto [least3, most3] = least_and_most(refine(space, {.scheme = ps::Scheme::Root3})->fine);
    const auto [least9, most9] = least_and_most(refine(space)->fine);
    rows.add("theorem 3.1", "least valence of a new vertex, sqrt(3)", 6, least3,
             "6 less the edges on the boundary");
    rows.add("theorem 3.1", "largest valence of a new vertex, sqrt(3)", 6, most3);
    rows.add("theorem 3.1", "least valence of a new vertex, triadic", 6, least9);
    rows.add("theorem 3.1", "largest valence of a new vertex, triadic", 6, most9);
}

// --- section 3.2

void combinations(Rows& rows) {
    const ps::Space space = random_space(60, 1);
    const ps::Refinement step = *refine(space);
    double least = 1;
    double off = 0;
    for (Index v = 0; v < step.fine.mesh.vertex_count(); ++v) {
        const ps::StepRows blocks = step_rows(space, step, v);
        for (std::size_t j = 0; j < 3; ++j) {
            double sum = 0;
            for (std::size_t k = 0; k < static_cast<std::size_t>(blocks.count); ++k)
                for (const double weight : blocks.block[k][j]) {
                    least = std::min(least, weight);
                    sum += weight;
                }
            off = std::max(off, std::abs(sum - 1));
        }
    }
    rows.add("(3.2) to (3.11)", "least weight of an old coefficient in a new one", 0, least,
             "convex combinations");
    rows.add("(3.2) to (3.11)", "largest difference of their sum from 1", 0, off);
}

/// Formulas that need another reading: how far points are from where they belong.
void readings(Rows& rows) {
    const std::array<Vec2, 3> corners{Vec2{0, 0}, {1, 0}, {0, 1}};
    const std::array<std::array<Index, 3>, 1> triangle{{{0, 1, 2}}};
    const ps::Space space = *ps::make_space(*mesh::build(corners, triangle));
    const spline::PsElement element = space.element(0);
    const Vec2 long_edge = corners[2] - corners[1];
    const double doubled_area = std::abs(cross(long_edge, element.corner(1)));
    rows.add("(3.10)", "distance of the new vertex from the edge", 0,
             2.0 / 3 * doubled_area / dot(long_edge, long_edge),
             "as printed, with V_ijk; of its length");
    double worst = 0;
    const ps::Refinement step = *refine(space);
    for (Index e = 0; e < 3; ++e)
        for (const Index v : {4 + 2 * e, 5 + 2 * e})  // after 3 old vertices and that at Z
            worst = std::max(worst, std::abs(cross(space.mesh.edge_vector(e),
                                                   step.fine.mesh.vertex(v) -
                                                       space.mesh.vertex(space.mesh.edges[e][0]))));
    rows.add("(3.10)", "the same with R_ij in its place", 0, worst / dot(long_edge, long_edge));

    // The third control point of a vertex on the boundary edge from corner 0 to corner 1.
    const ps::Coefficients spline = franke_spline(space);
    const ps::TangentPlanes planes = ps::tangent_planes(space, spline);
    const double weight = element.weights()[0];
    const double omega = 1.0 / 3;
    const double mu = omega + weight - omega * weight;
    const auto ordinate = [&](Index corner, int edge) {
        const Vec2 way =
            0.5 * (element.edge_point(edge) - element.corner(static_cast<int>(corner)));
        return std::pair(space.mesh.vertex(corner) + way, planes[corner].at(way));
    };
    const Vec2 edge_point = element.centre() + element.edge_point(0);
    const Vec2 place = omega * space.mesh.vertex(0) + (1 - omega) * edge_point;
    const ps::Surface surface = *ps::Surface::create(space, std::span(&spline, 1));
    const PlaneJet touched = surface.jet(0, place);
    const auto distance = [&](int edge_of_second) {
        const auto [first_point, first_height] = ordinate(0, 0);
        const auto [second_point, second_height] = ordinate(1, edge_of_second);
        const Vec2 point = mu * first_point + (1 - mu) * second_point;
        const double height = mu * first_height + (1 - mu) * second_height;
        return std::abs(height - touched.value - dot(touched.gradient, point - place));
    };
    rows.add("(3.8)", "distance of C_ij,2 from the tangent plane", 0, distance(1),
             "as printed, with L_j; Franke");
    rows.add("(3.8)", "the same with L'_j", 0, distance(0));
}

/// Areas of new control triangles over the smallest ones, of triangles without boundary edges.
void optimality(Rows& rows) {
    double worst = 1;
    for (unsigned seed = 1; seed <= 5; ++seed) {
        const ps::Space space = random_space(60, seed);
        const mesh::Triangulation& mesh = space.mesh;
        const ps::RefineOptions own{.scheme = ps::Scheme::Root3, .rescale = ps::Rescale::None};
        ps::RefineOptions smallest = own;
        smallest.rescale = ps::Rescale::Smallest;
        const ps::Refinement a = *refine(space, own);
        const ps::Refinement b = *refine(space, smallest);
        for (Index t = 0; t < mesh.triangle_count(); ++t) {
            const auto& edges = mesh.triangle_edges[t];
            if (std::any_of(edges.begin(), edges.end(),
                            [&](Index e) { return mesh.on_boundary(e); }))
                continue;
            const Index v = mesh.vertex_count() + t;
            worst = std::max(worst, area(a.fine.control[v]) / area(b.fine.control[v]));
        }
    }
    rows.add("section 4", "new control triangle over the smallest, area", 1, worst,
             "\"optimal\": in regular meshes");
}

void rescaling(Rows& rows) {
    constexpr std::pair<ps::Rescale, const char*> kRules[] = {{ps::Rescale::None, "none"},
                                                              {ps::Rescale::Paper, "(3.11)"},
                                                              {ps::Rescale::Tight, "tight"},
                                                              {ps::Rescale::Smallest, "smallest"}};
    for (const auto& [rule, name] : kRules)
        for (const int levels : {0, 1, 2}) {
            const ps::Hierarchy hierarchy =
                *ps::Hierarchy::create(squares(2), levels, {.rescale = rule});
            const ps::Space& fine = hierarchy.space(levels);
            rows.add("section 3.2.3, 2 x 2 squares",
                     fmt::format("condition of B-splines, level {}, {}", levels, name), {},
                     scaled_condition(fine, all_b_splines(fine)));
        }
}

}  // namespace

void add_refinement(Rows& rows) {
    b_splines(rows);
    smallest_triangles(rows);
    refinements(rows);
    cuts(rows);
    valences(rows);
    combinations(rows);
    readings(rows);
    optimality(rows);
    rescaling(rows);
}

}  // namespace relief::reproduce::ps_text
