#include "relief/multires/ps_space.h"

#include <Eigen/Dense>
#include <numeric>

#include "ps_testing.h"
#include "relief/core/parallel.h"

namespace relief::multires::ps {
namespace {

using namespace test;

double area(const TriangleCorners& t) {
    return 0.5 * std::abs(orient(t[0], t[1], t[2]));
}

TEST(PsSpace, GoldenSplit) {
    for (const auto& item : golden_cases()) {
        const Space space = must(make_space(golden_mesh(item["mesh"])));
        const auto& mesh = item["mesh"];
        ASSERT_EQ(space.mesh.edge_count(), mesh["E"].size());
        for (Index e = 0; e < space.mesh.edge_count(); ++e) {
            EXPECT_EQ(space.mesh.edges[e][0], mesh["E"][e][0]);
            EXPECT_EQ(space.mesh.edges[e][1], mesh["E"][e][1]);
            EXPECT_NEAR(space.split.edge_weight[e], mesh["lam"][e].get<double>(), 1e-11);
        }
        for (Index t = 0; t < space.mesh.triangle_count(); ++t) {
            const Vec2 z = space.split.centre[t] + space.mesh.origin;
            EXPECT_NEAR(z.x, mesh["Z"][t][0].get<double>(), 1e-11);
            EXPECT_NEAR(z.y, mesh["Z"][t][1].get<double>(), 1e-11);
        }
        for (Index v = 0; v < space.mesh.vertex_count(); ++v) {
            const double expected = item["min_area"][v];
            EXPECT_NEAR(area(space.control[v]), expected, 1e-11 * expected);
        }
        EXPECT_LE(enclosure_excess(space), 1e-12);
    }
}

TEST(PsSpace, GoldenTangentPlanes) {
    for (const auto& item : golden_cases()) {
        const Space space = golden_space(item);
        const Coefficients spline = golden_coefficients(item["c"]);
        const TangentPlanes planes = tangent_planes(space, spline);
        const Coefficients again = coefficients(space, planes);
        for (Index v = 0; v < space.mesh.vertex_count(); ++v) {
            const auto basis = basis_planes(space.control[v]);
            // Relative to gradients of up to 40.
            EXPECT_NEAR(planes[v].value, item["f"][v].get<double>(), 1e-11);
            EXPECT_NEAR(planes[v].gradient.x, item["grad"][v][0].get<double>(), 1e-10);
            EXPECT_NEAR(planes[v].gradient.y, item["grad"][v][1].get<double>(), 1e-10);
            for (int j = 0; j < 3; ++j) {
                EXPECT_NEAR(basis[j].value, item["alpha"][v][j].get<double>(), 1e-11);
                EXPECT_NEAR(again[v][j], spline[v][j], 1e-11);
            }
        }
    }
}

TEST(PsSpace, GoldenValues) {
    for (const auto& item : golden_cases()) {
        const Space space = golden_space(item);
        const Pointwise surface(space, golden_coefficients(item["c"]));
        const auto& eval = item["eval"];
        for (std::size_t k = 0; k < eval["points"].size(); ++k) {
            const Vec2 point = point_of(eval["points"][k]) - space.mesh.origin;
            const Index t = eval["triangle"][k];
            const Vec2 offset = point - space.split.centre[t];
            EXPECT_EQ(brute_force_locate(space.mesh, point), t);
            EXPECT_EQ(space.element(t).piece_of(offset), eval["piece"][k].get<int>());
            const spline::PlaneJet jet = surface.jet(t, point);
            const auto near = [](double value, const nlohmann::json& expected, double tolerance) {
                const double number = expected;
                EXPECT_NEAR(value, number, tolerance * std::max(1.0, std::abs(number)));
            };
            near(jet.value, eval["value"][k], 1e-11);
            near(jet.gradient.x, eval["gradient"][k][0], 1e-11);
            near(jet.gradient.y, eval["gradient"][k][1], 1e-11);
            near(jet.xx, eval["hessian"][k][0], 1e-8);
            near(jet.xy, eval["hessian"][k][1], 1e-8);
            near(jet.yy, eval["hessian"][k][2], 1e-8);
        }
    }
}

/// The basis: not negative, of sum 1, and with the corners' coordinates as coefficients of x and y.
TEST(PsSpace, NormalisedBasis) {
    Noise noise(4);
    for (const Space& space : space_family()) {
        EXPECT_LE(enclosure_excess(space), 1e-12);
        for (Index t = 0; t < space.mesh.triangle_count(); ++t) {
            const Vec2 point = inner_point(space.mesh, t, noise);
            const spline::PsElement element = space.element(t);
            const Vec2 offset = point - element.centre();
            const auto weights =
                element.weights_at(space.basis(t), element.piece_of(offset), offset);
            double sum = 0;
            Vec2 place;
            for (int q = 0; q < 9; ++q) {
                EXPECT_GE(weights[q], -1e-12);
                const Index v = space.mesh.triangles[t][q / 3];
                sum += weights[q];
                place = place + weights[q] * (space.mesh.vertex(v) + space.control[v][q % 3]);
            }
            EXPECT_NEAR(sum, 1, 1e-12);
            EXPECT_NEAR(place.x, point.x, 1e-11);  // coordinates of up to 7
            EXPECT_NEAR(place.y, point.y, 1e-11);
        }
    }
}

TEST(PsSpace, ContinuouslyDifferentiableAcrossEdges) {
    Noise noise(5);
    std::uint64_t seed = 0;
    for (const Space& space : space_family()) {
        const Pointwise surface(space, random_spline(space, ++seed));
        for (Index e = 0; e < space.mesh.edge_count(); ++e) {
            if (space.mesh.on_boundary(e)) continue;
            const auto [left, right] = space.mesh.edge_triangles[e];
            const Vec2 point = space.mesh.vertex(space.mesh.edges[e][0]) +
                               (0.5 + 0.49 * noise()) * space.mesh.edge_vector(e);
            const auto a = surface.jet(left, point);
            const auto b = surface.jet(right, point);
            const double scale = std::max(1.0, length(a.gradient));
            EXPECT_NEAR(a.value, b.value, 1e-12 * scale);
            EXPECT_NEAR(a.gradient.x, b.gradient.x, 1e-11 * scale);
            EXPECT_NEAR(a.gradient.y, b.gradient.y, 1e-11 * scale);
        }
    }
}

TEST(PsSpace, GivenCentresAndMidpoints) {
    const Triangulation mesh = relief::test::built(relief::test::triangle_grid(3, 3, 0.1));
    const Split incircles = must(split(mesh));
    std::vector<Vec2> centres;
    for (const Vec2 z : incircles.centre) centres.push_back(z + mesh.origin);
    const Split given = must(split(mesh, {BoundaryPoint::Midpoint, centres}));
    for (Index e = 0; e < mesh.edge_count(); ++e) {
        if (mesh.on_boundary(e))
            EXPECT_EQ(given.edge_weight[e], 0.5);
        else
            EXPECT_NEAR(given.edge_weight[e], incircles.edge_weight[e], 1e-12);
    }
    EXPECT_TRUE(lopsided_edges(given).empty());
}

std::string error_of(const Result<Split>& result) {
    return result.ok() ? "none"
                       : result.error().message.substr(0, result.error().message.find(':'));
}

TEST(PsSpace, Errors) {
    const Triangulation mesh = relief::test::built({{{0, 0}, {4, 0}, {4, 1}, {0, 1}},  //
                                                    {{0, 1, 2}, {0, 2, 3}}});
    const auto split_at = [&](std::vector<Vec2> centres) {
        return error_of(split(mesh, {BoundaryPoint::Foot, centres}));
    };
    EXPECT_EQ(split_at({{3, 0.5}}), "size_mismatch");
    EXPECT_EQ(split_at({{3, 0.5}, {NAN, 0.5}}), "non_finite_input");
    EXPECT_EQ(split_at({{3, 0.5}, {3, 0.2}}), "degenerate_split");  // not in its triangle
    EXPECT_EQ(split_at({{3, 0.5}, {1, 0.5}}), "none");

    const Triangulation dart = relief::test::built({{{0, 0}, {1, 0}, {3, 1}, {3, -1}},  //
                                                    {{0, 1, 2}, {1, 0, 3}}});
    const std::vector<Vec2> beyond = {{2.75, 0.9}, {2.75, -0.9}};  // edge 0 ends at x = 1
    const auto missed = split(dart, {BoundaryPoint::Foot, beyond});
    EXPECT_EQ(error_of(missed), "edge_not_crossed");
    EXPECT_EQ(missed.error().where, "edge 0");

    // Both triangles at one end nearly flat there: the edge is cut within 1e-9 of that end.
    const double eps = 1e-5;
    const Triangulation flat = relief::test::built(
        {{{0, 0}, {1, 0}, {-1, eps}, {-1, -eps}}, {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}}});
    const auto degenerate = split(flat);
    ASSERT_FALSE(degenerate.ok());
    EXPECT_EQ(error_of(degenerate), "degenerate_split");
    EXPECT_EQ(degenerate.error().where, "edge 0");

    const Space space = must(make_space(mesh));
    Coefficients spline = random_spline(space, 1);
    EXPECT_TRUE(check(space.mesh, spline).ok());
    spline[2][1] = NAN;
    EXPECT_EQ(check(space.mesh, spline).error().where, "vertex 2");
    spline.pop_back();
    EXPECT_FALSE(check(space.mesh, spline).ok());
}

/// The edge point runs to the end quadratically: 0.12 eps^2 of the edge (section 2).
TEST(PsSpace, FlatCornersOnBothSides) {
    for (const double eps : {1e-1, 1e-2, 1e-3}) {
        const Triangulation mesh = relief::test::built(
            {{{0, 0}, {1, 0}, {-1, eps}, {-1, -eps}}, {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}}});
        const double part = 1 - must(split(mesh)).edge_weight[0];
        EXPECT_NEAR(part / (eps * eps), 0.12, 0.006);
    }
}

TEST(PsSpace, SliversStayEnclosed) {
    for (const double thin : {1e-2, 1e-4, 1e-6, 1e-7}) {
        const Triangulation mesh =
            relief::test::built({{{0, 0}, {1, 0}, {0.3, thin}, {0.5, 1}, {0.4, -1}},
                                 {{0, 1, 2}, {0, 2, 3}, {2, 1, 3}, {0, 4, 1}}});
        const Space space = must(make_space(mesh));
        EXPECT_LE(enclosure_excess(space) * thin, 1e-11);
    }
}

TEST(PsSpace, SameBytesForAnyThreadCount) {
    const Triangulation mesh = relief::test::built(relief::test::triangle_grid(40, 40, 0.15));
    const Space several = must(make_space(mesh));
    set_thread_count(1);
    const Space one = must(make_space(mesh));
    set_thread_count(0);
    EXPECT_EQ(one.control, several.control);
    EXPECT_EQ(one.split.edge_weight, several.split.edge_weight);
}

}  // namespace
}  // namespace relief::multires::ps
