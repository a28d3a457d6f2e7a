#include "relief/multires/fvs_mesh.h"

#include <limits>

#include "multires/fvs_mesh_support.h"
#include "relief/core/parallel.h"

namespace relief::multires::fvs_mesh {
namespace {

using mesh::Index;
using mesh::Quadrangulation;
using spline::PlaneJet;
using test::built;
using test::hierarchy_of;
using test::largest_difference;

NodalData golden_data(const nlohmann::json& lists) {
    NodalData data;
    data.value = lists[0].get<std::vector<double>>();
    for (const auto& g : lists[1]) {
        data.dx.push_back(g[0]);
        data.dy.push_back(g[1]);
    }
    data.normal = lists[2].get<std::vector<double>>();
    return data;
}

Hierarchy golden_hierarchy(int levels) {
    const nlohmann::json& data = test::fvs_golden()["hierarchy"][0];
    test::QuadMesh mesh;
    for (const auto& v : data["vertices"]) mesh.vertices.push_back({v[0], v[1]});
    for (const auto& q : data["quads"]) mesh.quads.push_back({q[0], q[1], q[2], q[3]});
    return hierarchy_of(built(mesh), levels);
}

/// sin(5x + 2y) cos(3y - x) + 0.3 exp(-40 ((x - 0.6)^2 + (y - 0.3)^2))
PlaneJet waves(Vec2 p) {
    const double a = 5 * p.x + 2 * p.y;
    const double b = 3 * p.y - p.x;
    PlaneJet jet = test::bump(p, 0.3, 40, 0.6, 40, 0.3);
    jet.value += std::sin(a) * std::cos(b);
    jet.gradient.x += 5 * std::cos(a) * std::cos(b) + std::sin(a) * std::sin(b);
    jet.gradient.y += 2 * std::cos(a) * std::cos(b) - 3 * std::sin(a) * std::sin(b);
    return jet;
}

PlaneJet cubic(Vec2 p) {
    const auto [x, y] = p;
    return {1 - 2 * x + y + x * x - x * y + 0.3 * x * x * x - 0.8 * x * x * y - 0.6 * y * y * y,
            {-2 + 2 * x - y + 0.9 * x * x - 1.6 * x * y, 1 - x - 0.8 * x * x - 1.8 * y * y}};
}

TEST(FvsMesh, GoldenPrediction) {
    const nlohmann::json& golden = test::fvs_golden()["hierarchy"][0]["predict"];
    const Hierarchy hierarchy = golden_hierarchy(0);
    const NodalData fine = predict(hierarchy.mesh(0), golden_data(golden["coarse"]));
    EXPECT_LT(largest_difference(fine, golden_data(golden["fine"])), 1e-12);
}

TEST(FvsMesh, GoldenDecomposition) {
    const nlohmann::json& golden = test::fvs_golden()["hierarchy"][0]["decompose"];
    const Hierarchy hierarchy = golden_hierarchy(2);
    const Decomposition d = *decompose(hierarchy, interpolate(hierarchy.mesh(2), waves));
    EXPECT_LT(largest_difference(d.base, golden_data(golden["level0"])), 1e-12);
    ASSERT_EQ(golden["details"].size(), d.details.size());
    for (std::size_t m = 0; m < d.details.size(); ++m) {
        const nlohmann::json& level = golden["details"][m];
        std::vector<double> dx;
        std::vector<double> dy;
        for (const auto& g : level["centre_grad"]) {
            dx.push_back(g[0]);
            dy.push_back(g[1]);
        }
        const Details<double> expected{
            level["edge_value"], level["edge_tangential"], level["centre_value"], dx, dy,
            level["gamma"]};
        for_each_detail(
            [](const std::vector<double>& a, const std::vector<double>& b) {
                ASSERT_EQ(a.size(), b.size());
                for (std::size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k], b[k], 1e-12);
            },
            d.details[m], expected);
    }
}

TEST(FvsMesh, SpacesAreNested) {
    for (const Quadrangulation& base : test::mesh_family()) {
        const Hierarchy hierarchy = hierarchy_of(base, 2);
        NodalData data = test::noise_data(base, 11);
        const auto points = test::inner_points(base);
        const auto coarse = test::jets(hierarchy, 0, data, points);
        data = predict(hierarchy.mesh(1), predict(base, data));
        const auto fine = test::jets(hierarchy, 2, data, points);
        // The stored origin keeps nestedness exact at coordinates of 2e6; the points themselves are
        // only known there to 5e-10.
        const double slack = length(base.origin) > 1e5 ? 1e-9 : 1e-12;
        for (std::size_t k = 0; k < points.size(); ++k) {
            EXPECT_NEAR(fine[k].value, coarse[k].value, slack);
            EXPECT_NEAR(length(fine[k].gradient - coarse[k].gradient), 0, 10 * slack);
            EXPECT_NEAR(fine[k].xx, coarse[k].xx, 1e3 * slack);
            EXPECT_NEAR(fine[k].xy, coarse[k].xy, 1e3 * slack);
            EXPECT_NEAR(fine[k].yy, coarse[k].yy, 1e3 * slack);
        }
    }
}

TEST(FvsMesh, RestrictionUndoesPrediction) {
    for (const Quadrangulation& base : test::mesh_family()) {
        const NodalData data = test::noise_data(base, 5);
        EXPECT_LT(largest_difference(restrict_to(base, predict(base, data)), data), 1e-14);
    }
}

TEST(FvsMesh, RoundTrip) {
    for (const Quadrangulation& base : test::mesh_family()) {
        const Hierarchy hierarchy = hierarchy_of(base, 3);
        const NodalData data = test::noise_data(hierarchy.mesh(3), 7);
        const Decomposition d = *decompose(hierarchy, data);
        EXPECT_LT(largest_difference(*reconstruct(hierarchy, d, 3), data), 1e-12);
        // A prefix of the levels is what restriction gives.
        EXPECT_LT(
            largest_difference(*reconstruct(hierarchy, d, 2), restrict_to(hierarchy.mesh(2), data)),
            1e-12);
    }
}

TEST(FvsMesh, CubicsHaveNoDetails) {
    for (const Quadrangulation& base : test::mesh_family()) {
        const Hierarchy hierarchy = hierarchy_of(base, 2);
        const Vec2 centre = base.origin;
        const NodalData data =
            interpolate(hierarchy.mesh(2), [&](Vec2 p) { return cubic(p - centre); });
        // At coordinates of 2e6 the function is asked at points that are rounded to 5e-10.
        const double slack = length(centre) > 1e5 ? 1e-8 : 1e-11;
        EXPECT_LT(test::largest_detail(*decompose(hierarchy, data)), slack);
    }
}

/// Value and gradient of random data agree on both sides of every edge.
TEST(FvsMesh, SurfacesAreSmooth) {
    for (const Quadrangulation& base : test::mesh_family()) {
        const Quadrangulation mesh = *mesh::refine(base);
        const NodalData data = test::noise_data(mesh, 13);
        const auto sides = mesh::edge_quads(mesh);
        for (Index e = 0; e < mesh.edge_count(); ++e) {
            if (sides[e][1] == mesh::kNoQuad) continue;
            for (const double t : {0.0, 0.25, 0.6, 1.0}) {
                const Vec2 p = mesh.vertex(mesh.edges[e][0]) + t * mesh.edge_vector(e);
                PlaneJet jet[2];
                for (int k = 0; k < 2; ++k) {
                    const Index q = sides[e][k];
                    const spline::FvsElement element(mesh.corners(q));
                    jet[k] = element.jet(element.ordinates(quad_data(mesh, data, q)), p);
                }
                EXPECT_NEAR(jet[0].value, jet[1].value, 1e-13);
                EXPECT_NEAR(length(jet[0].gradient - jet[1].gradient), 0, 1e-12);
            }
        }
    }
}

TEST(FvsMesh, TurningAnEdgeChangesOnlySignsAndOrder) {
    const Quadrangulation base = built(test::grid_mesh(2, 2, 1, 0.15));
    const Index turned_edge = base.quad_edges[0][1];
    Quadrangulation other = base;
    std::swap(other.edges[turned_edge][0], other.edges[turned_edge][1]);
    for (Index q = 0; q < base.quad_count(); ++q)
        for (int i = 0; i < 4; ++i)
            if (base.quad_edges[q][i] == turned_edge)
                other.quad_signs[q][i] = static_cast<std::int8_t>(-other.quad_signs[q][i]);
    const auto coefficients = [](const Quadrangulation& mesh) {
        const Hierarchy hierarchy = hierarchy_of(mesh, 1);
        return *decompose(hierarchy, interpolate(hierarchy.mesh(1), waves));
    };
    Decomposition expected = coefficients(base);
    expected.base.normal[turned_edge] *= -1;
    Details<double>& d = expected.details[0];
    d.edge_tangential[turned_edge] *= -1;
    std::swap(d.normal[2 * turned_edge], d.normal[2 * turned_edge + 1]);
    d.normal[2 * turned_edge] *= -1;
    d.normal[2 * turned_edge + 1] *= -1;
    const Decomposition found = coefficients(other);
    EXPECT_LT(largest_difference(found.base, expected.base), 1e-14);
    for_each_detail(
        [](const std::vector<double>& a, const std::vector<double>& b) {
            for (std::size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k], b[k], 1e-14);
        },
        found.details[0], d);
}

TEST(FvsMesh, SameBytesForAnyNumberOfThreads) {
    const Hierarchy hierarchy = hierarchy_of(built(test::grid_mesh(20, 20, 1, 0.19)), 3);
    const NodalData data = interpolate(hierarchy.mesh(3), waves);
    const auto points = test::inner_points(hierarchy.mesh(1));
    std::vector<double> values[2];
    NodalData back[2];
    std::vector<double> bounds[2];
    for (int k = 0; k < 2; ++k) {
        set_thread_count(k == 0 ? 1 : 4);
        const Decomposition d = *decompose(hierarchy, data);
        back[k] = *reconstruct(hierarchy, d, 3);
        bounds[k] = quad_bounds(hierarchy.mesh(3), data, 1);
        for (const PlaneJet& jet : test::jets(hierarchy, 3, data, points))
            values[k].push_back(jet.value);
    }
    set_thread_count(0);
    EXPECT_TRUE(back[0] == back[1]);
    EXPECT_EQ(values[0], values[1]);
    EXPECT_EQ(bounds[0], bounds[1]);
}

TEST(FvsMesh, DerivativesFromValuesAreExactForQuadratics) {
    const auto quadratic = [](Vec2 p) {
        const auto [x, y] = p;
        return PlaneJet{0.3 - x + 2 * y + 0.5 * x * x - 0.7 * x * y + 1.1 * y * y,
                        {-1 + x - 0.7 * y, 2 - 0.7 * x + 2.2 * y}};
    };
    for (const test::QuadMesh& source :
         {test::grid_mesh(4, 4), test::grid_mesh(5, 3, 0.5, 0.19),
          test::without_quad(test::grid_mesh(5, 5, 1, 0.1), 12), test::star_mesh(5)}) {
        const Quadrangulation mesh = built(source);
        const NodalData exact = interpolate(mesh, quadratic);
        const NodalData estimated = *interpolate_values(mesh, exact.value);
        // The normal equations square the condition of the fits.
        EXPECT_LT(largest_difference(estimated, exact), 1e-10);
    }
}

TEST(FvsMesh, LocalInterpolationIsThatOfAllValues) {
    for (const Quadrangulation& mesh : test::mesh_family()) {
        std::vector<double> values;
        for (Index v = 0; v < mesh.vertex_count(); ++v)
            values.push_back(waves(0.1 * (mesh.origin + mesh.vertex(v))).value);
        const NodalData data = *interpolate_values(mesh, values);
        const LocalInterpolation local(mesh);
        std::vector<VertexQuadratic> quadratics;
        for (Index v = 0; v < mesh.vertex_count(); ++v) {
            const VertexQuadratic fit = local.quadratic(values, v);
            EXPECT_EQ(fit.gradient, (Vec2{data.dx[v], data.dy[v]}));
            // Sums in another order: roundings of rises below 2 over distances from 0.1 on, in
            // fits whose pivots are 1e-3 at least.
            const VertexQuadratic same = local.rule(v).apply(values, v);
            EXPECT_NEAR(same.gradient.x, fit.gradient.x, 1e-10);
            EXPECT_NEAR(same.gradient.y, fit.gradient.y, 1e-10);
            EXPECT_NEAR(same.xx, fit.xx, 1e-9);
            EXPECT_NEAR(same.xy, fit.xy, 1e-9);
            EXPECT_NEAR(same.yy, fit.yy, 1e-9);
            quadratics.push_back(fit);
        }
        for (Index e = 0; e < mesh.edge_count(); ++e) {
            const auto [from, to] = mesh.edges[e];
            EXPECT_EQ(local.normal(e, quadratics[from], quadratics[to]), data.normal[e]);
        }
    }
}

TEST(FvsMesh, DerivativesFromValuesFallBackToPlanes) {
    const auto plane = [](Vec2 p) { return PlaneJet{1 + 2 * p.x - 3 * p.y, {2, -3}}; };
    for (const test::QuadMesh& source : {test::random_quad(3), test::grid_mesh(7, 1)}) {
        const Quadrangulation mesh = built(source);
        const NodalData exact = interpolate(mesh, plane);
        EXPECT_LT(largest_difference(*interpolate_values(mesh, exact.value), exact), 1e-12);
    }
}

TEST(FvsMesh, BoundsHoldAndTighten) {
    for (const Quadrangulation& mesh : test::mesh_family()) {
        const NodalData data = test::noise_data(mesh, 17);
        const Hierarchy hierarchy = hierarchy_of(mesh, 0);
        const auto jets = test::jets(hierarchy, 0, data, test::inner_points(mesh));
        std::vector<double> previous(mesh.quad_count(), std::numeric_limits<double>::infinity());
        for (int k = 0; k <= 3; ++k) {
            const auto bounds = quad_bounds(mesh, data, k);
            for (Index q = 0; q < mesh.quad_count(); ++q) {
                EXPECT_LE(bounds[q], previous[q]);
                for (std::size_t p = 12 * q; p < 12 * (q + 1); ++p)
                    EXPECT_LE(std::abs(jets[p].value), bounds[q] + 1e-8);
            }
            previous = bounds;
        }
    }
}

/// Bisection of the nets gives the ordinates of the refined spline.
TEST(FvsMesh, BoundsAreThoseOfRefinedSplines) {
    for (const Quadrangulation& mesh : test::mesh_family()) {
        const NodalData data = test::noise_data(mesh, 19);
        const Quadrangulation child = *mesh::refine(mesh);
        const auto coarse = quad_bounds(mesh, data, 2);
        const auto fine = quad_bounds(child, predict(mesh, data), 1);
        for (Index q = 0; q < mesh.quad_count(); ++q) {
            const double most =
                std::max({fine[4 * q], fine[4 * q + 1], fine[4 * q + 2], fine[4 * q + 3]});
            EXPECT_NEAR(coarse[q], most, 1e-13);
        }
    }
}

TEST(FvsMesh, L2NormOfAPlane) {
    // Integral of (1 + 2x - y)^2 over [0, 2] x [0, 2]: the mean square of 1 + 2x - y there is
    // (1 + 2 - 1)^2 + 4/3 + 1/3.
    const Quadrangulation mesh = built(test::grid_mesh(2, 2, 1, 0.1));
    const NodalData plane = interpolate(mesh, [](Vec2 p) {
        return PlaneJet{1 + 2 * p.x - p.y, {2, -1}};
    });
    EXPECT_NEAR(l2_norm(mesh, plane), std::sqrt(4 * (4 + 5.0 / 3)), 1e-13);
}

TEST(FvsMesh, PointsOutside) {
    const Hierarchy hierarchy =
        hierarchy_of(built(test::without_quad(test::grid_mesh(3, 3), 4)), 2);
    const NodalData data = interpolate(hierarchy.mesh(1), cubic);
    const std::vector<Vec2> points = {{0.5, 0.5}, {1.5, 1.75}, {4, 1.5}};
    std::vector<PlaneJet> out(3);
    const Status rejected = evaluate(hierarchy, 1, data, points, out);
    ASSERT_FALSE(rejected.ok());
    EXPECT_EQ(rejected.error().message.rfind("outside_domain", 0), 0u);
    EXPECT_EQ(rejected.error().where, "point 1");
    ASSERT_TRUE(evaluate(hierarchy, 1, data, points, out, Outside::Clamp).ok());
    EXPECT_NEAR(out[0].value, cubic({0.5, 0.5}).value, 1e-13);
    EXPECT_NEAR(out[1].value, cubic({1.5, 2}).value, 1e-12);
    EXPECT_NEAR(out[2].value, cubic({3, 1.5}).value, 1e-12);
    const std::vector<Vec2> nowhere = {{std::numeric_limits<double>::quiet_NaN(), 0}};
    out.resize(1);
    EXPECT_FALSE(evaluate(hierarchy, 1, data, nowhere, out, Outside::Clamp).ok());
}

TEST(FvsMesh, NamedErrors) {
    const Hierarchy hierarchy = hierarchy_of(built(test::grid_mesh(2, 2)), 1);
    const auto name = [](const Error& error) {
        return error.message.substr(0, error.message.find(':'));
    };
    NodalData data = test::noise_data(hierarchy.mesh(1), 1);
    Decomposition d = *decompose(hierarchy, data);
    EXPECT_EQ(name(reconstruct(hierarchy, d, 2).error()), "level_out_of_range");
    EXPECT_EQ(name(reconstruct(hierarchy, d, -1).error()), "level_out_of_range");
    d.details[0].normal.pop_back();
    EXPECT_EQ(name(reconstruct(hierarchy, d, 1).error()), "size_mismatch");
    EXPECT_TRUE(reconstruct(hierarchy, d, 0).ok());
    data.normal[5] = std::numeric_limits<double>::infinity();
    EXPECT_EQ(name(decompose(hierarchy, data).error()), "non_finite_data");
    EXPECT_EQ(decompose(hierarchy, data).error().where, "normal derivative of edge 5");
    data.value.pop_back();
    EXPECT_EQ(name(decompose(hierarchy, data).error()), "size_mismatch");
    EXPECT_EQ(name(Hierarchy::create(hierarchy.mesh(0), 40).error()), "level_out_of_range");
    EXPECT_EQ(name(interpolate_values(hierarchy.mesh(0), std::vector<double>(3)).error()),
              "size_mismatch");
    std::vector<double> values(9);
    values[4] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(name(interpolate_values(hierarchy.mesh(0), values).error()), "non_finite_data");
}

}  // namespace
}  // namespace relief::multires::fvs_mesh
