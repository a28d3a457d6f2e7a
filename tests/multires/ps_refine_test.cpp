#include "relief/multires/ps_refine.h"

#include <rapidcheck.h>

#include "ps_testing.h"
#include "relief/core/parallel.h"
#include "relief/mesh/delaunay.h"

namespace relief::multires::ps {
namespace {

using namespace test;

void expect_mesh(const Space& space, const nlohmann::json& expected) {
    const auto near = [&](Vec2 p, const nlohmann::json& q) {
        EXPECT_NEAR(p.x + space.mesh.origin.x, q[0].get<double>(), 1e-11);
        EXPECT_NEAR(p.y + space.mesh.origin.y, q[1].get<double>(), 1e-11);
    };
    ASSERT_EQ(space.mesh.vertex_count(), expected["V"].size());
    ASSERT_EQ(space.mesh.triangle_count(), expected["T"].size());
    ASSERT_EQ(space.mesh.edge_count(), expected["E"].size());
    for (Index v = 0; v < space.mesh.vertex_count(); ++v)
        near(space.mesh.vertex(v), expected["V"][v]);
    for (Index t = 0; t < space.mesh.triangle_count(); ++t) {
        EXPECT_EQ(nlohmann::json(space.mesh.triangles[t]), expected["T"][t]);
        near(space.split.centre[t], expected["Z"][t]);
    }
    for (Index e = 0; e < space.mesh.edge_count(); ++e) {
        EXPECT_EQ(nlohmann::json(space.mesh.edges[e]), expected["E"][e]);
        EXPECT_NEAR(space.split.edge_weight[e], expected["lam"][e].get<double>(), 1e-11);
    }
}

void expect_controls(const Space& space, const nlohmann::json& expected) {
    for (Index v = 0; v < expected.size(); ++v)
        for (int j = 0; j < 3; ++j) {
            const Vec2 q = space.mesh.origin + space.mesh.vertex(v) + space.control[v][j];
            EXPECT_NEAR(q.x, expected[v][j][0].get<double>(), 1e-11);
            EXPECT_NEAR(q.y, expected[v][j][1].get<double>(), 1e-11);
        }
}

void expect_spline(const Coefficients& spline, const nlohmann::json& expected) {
    ASSERT_EQ(spline.size(), expected.size());
    for (std::size_t v = 0; v < spline.size(); ++v)
        for (int j = 0; j < 3; ++j) EXPECT_NEAR(spline[v][j], expected[v][j].get<double>(), 1e-11);
}

TEST(PsRefine, GoldenTriadic) {
    for (const auto& item : golden_cases()) {
        if (!item.contains("triadic") || item["triadic"].is_null()) continue;
        const auto& expected = item["triadic"];
        const Space coarse = golden_space(item);
        const Refinement step = must(refine(coarse));
        for (Index e = 0; e < coarse.mesh.edge_count(); ++e)
            for (int end = 0; end < 2; ++end)
                EXPECT_NEAR(step.kappa[coarse.mesh.edges[e][end]],
                            expected["kappa1"][e][end].get<double>(), 1e-12);
        for (Index v = 0; v < coarse.mesh.vertex_count(); ++v)
            EXPECT_NEAR(step.second_kappa[v], expected["kappa2"][v].get<double>(), 1e-12);
        expect_mesh(step.fine, expected["mesh"]);
        expect_controls(step.fine, expected["Q"]);
        expect_spline(prolong(coarse, step, golden_coefficients(item["c"])), expected["c"]);
        const Refinement paper = must(refine(coarse, {.rescale = Rescale::Paper}));
        expect_controls(paper.fine, expected["Q_old_paper"]);
    }
}

TEST(PsRefine, GoldenRoot3) {
    for (const auto& item : golden_cases()) {
        if (!item.contains("sqrt3") || item["sqrt3"].is_null()) continue;
        const auto& expected = item["sqrt3"];
        const Space coarse = golden_space(item);
        const Refinement step =
            must(refine(coarse, {.scheme = Scheme::Root3, .rescale = Rescale::Paper}));
        for (Index v = 0; v < coarse.mesh.vertex_count(); ++v)
            EXPECT_NEAR(step.kappa[v], expected["kappa"][v].get<double>(), 1e-12);
        expect_mesh(step.fine, expected["mesh"]);
        expect_controls(step.fine, expected["Q"]);
        expect_spline(prolong(coarse, step, golden_coefficients(item["c"])), expected["c"]);
    }
}

TEST(PsRefine, GoldenDyadic) {
    for (const auto& item : golden_cases()) {
        const Space coarse = golden_space(item);
        const auto step = refine(coarse, {.scheme = Scheme::Dyadic});
        ASSERT_EQ(step.ok(), item["dyadic_applies"].get<bool>());
        if (!step.ok()) {
            EXPECT_EQ(step.error().message.rfind("dyadic_not_applicable", 0), 0U);
            continue;
        }
        expect_mesh(step->fine, item["dyadic"]["mesh"]);
        const auto fine = prolong(coarse, *step, golden_coefficients(item["c"]));
        const TangentPlanes planes = tangent_planes(step->fine, fine);
        for (Index v = 0; v < planes.size(); ++v) {
            const auto& gradient = item["dyadic"]["grad"][v];
            EXPECT_NEAR(planes[v].value, item["dyadic"]["f"][v].get<double>(), 1e-11);
            EXPECT_NEAR(planes[v].gradient.x, gradient[0].get<double>(), 1e-10);  // up to 40
            EXPECT_NEAR(planes[v].gradient.y, gradient[1].get<double>(), 1e-10);
        }
    }
}

/// The refined spline is the coarse one: values, gradients and the enclosure of each level.
void expect_same_surface(const Space& coarse, const Coefficients& spline, const Space& fine,
                         const Coefficients& refined, double tolerance) {
    const Pointwise before(coarse, spline);
    const Pointwise after(fine, refined);
    Noise noise(17);
    for (Index t = 0; t < fine.mesh.triangle_count(); t += 1 + fine.mesh.triangle_count() / 300) {
        const Vec2 point = inner_point(fine.mesh, t, noise);
        const auto expected = before.jet(brute_force_locate(coarse.mesh, point), point);
        const auto jet = after.jet(t, point);
        const double scale = std::max(1.0, length(expected.gradient));
        EXPECT_NEAR(jet.value, expected.value, tolerance * scale);
        EXPECT_NEAR(jet.gradient.x, expected.gradient.x, 10 * tolerance * scale);
        EXPECT_NEAR(jet.gradient.y, expected.gradient.y, 10 * tolerance * scale);
    }
}

TEST(PsRefine, TriadicKeepsTheSurface) {
    std::uint64_t seed = 0;
    for (const Space& coarse : space_family())
        for (const Rescale rescale :
             {Rescale::Tight, Rescale::Smallest, Rescale::Paper, Rescale::None})
            for (const CutRule cut : {CutRule::Closed, CutRule::Halving}) {
                const Coefficients spline = random_spline(coarse, ++seed);
                const Refinement step = must(refine(coarse, {.rescale = rescale, .cut = cut}));
                const Coefficients fine = prolong(coarse, step, spline);
                EXPECT_LE(enclosure_excess(step.fine), 1e-12);
                // Gradients of a level grow with the smallest control triangles.
                expect_same_surface(coarse, spline, step.fine, fine, 1e-12);
            }
}

TEST(PsRefine, ThreeTriadicLevels) {
    const Space coarse = must(make_space(relief::test::built(
        relief::test::without_triangle(relief::test::triangle_grid(3, 3, 0.15), 7))));
    for (const Rescale rescale : {Rescale::Tight, Rescale::Paper, Rescale::None}) {
        const Coefficients spline = random_spline(coarse, 3);
        Coefficients refined = spline;
        Space space = coarse;
        const double excess[] = {1e-12, 1e-11, 1e-10};
        for (int level = 0; level < 3; ++level) {
            Refinement step = must(refine(space, {.rescale = rescale}));
            refined = prolong(space, step, refined);
            space = std::move(step.fine);
            EXPECT_LE(enclosure_excess(space), excess[level]);
        }
        expect_same_surface(coarse, spline, space, refined, 1e-12);
    }
}

TEST(PsRefine, Root3KeepsTheSurface) {
    std::uint64_t seed = 0;
    for (const Space& coarse : space_family())
        for (const Rescale rescale : {Rescale::Tight, Rescale::Smallest, Rescale::Paper}) {
            const Coefficients spline = random_spline(coarse, ++seed);
            const Refinement step =
                must(refine(coarse, {.scheme = Scheme::Root3, .rescale = rescale}));
            EXPECT_LE(enclosure_excess(step.fine), 1e-12);
            expect_same_surface(coarse, spline, step.fine, prolong(coarse, step, spline), 1e-12);
        }
}

/// The triadic step is two steps of root 3: the tangent planes at all vertices that both have.
TEST(PsRefine, TriadicIsRoot3Twice) {
    const Space coarse =
        must(make_space(relief::test::built(relief::test::triangle_grid(4, 4, 0.19))));
    const Coefficients spline = random_spline(coarse, 8);
    const Refinement triadic = must(refine(coarse));
    const RefineOptions root3{.scheme = Scheme::Root3};
    const Refinement first = must(refine(coarse, root3));
    const Refinement second = must(refine(first.fine, root3));
    const TangentPlanes once = tangent_planes(triadic.fine, prolong(coarse, triadic, spline));
    const TangentPlanes twice =
        tangent_planes(second.fine, prolong(first.fine, second, prolong(coarse, first, spline)));
    int shared = 0;
    for (Index v = 0; v < twice.size(); ++v)
        for (Index w = 0; w < once.size(); ++w) {
            if (length(second.fine.mesh.vertex(v) - triadic.fine.mesh.vertex(w)) > 1e-12) continue;
            ++shared;
            EXPECT_NEAR(twice[v].value, once[w].value, 1e-10);
            EXPECT_NEAR(twice[v].gradient.x, once[w].gradient.x, 1e-10);
            EXPECT_NEAR(twice[v].gradient.y, once[w].gradient.y, 1e-10);
        }
    // All but the two vertices on each of the 16 boundary edges.
    EXPECT_EQ(shared, static_cast<int>(once.size()) - 2 * 16);
}

TEST(PsRefine, RowsAreConvexCombinations) {
    for (const Space& coarse : space_family()) {
        const Refinement step = must(refine(coarse));
        const Coefficients spline = random_spline(coarse, 5);
        const Coefficients fine = prolong(coarse, step, spline);
        for (Index v = 0; v < fine.size(); ++v) {
            const StepRows rows = step_rows(coarse, step, v);
            for (int j = 0; j < 3; ++j) {
                double sum = 0;
                double value = 0;
                for (int k = 0; k < rows.count; ++k)
                    for (int l = 0; l < 3; ++l) {
                        EXPECT_GE(rows.block[k][j][l], -1e-13);
                        sum += rows.block[k][j][l];
                        value += rows.block[k][j][l] * spline[rows.vertex[k]][l];
                    }
                EXPECT_NEAR(sum, 1, 1e-12);
                EXPECT_NEAR(value, fine[v][j], 1e-13);
            }
        }
    }
}

TEST(PsRefine, TransposeIsTheAdjoint) {
    for (const Scheme scheme : {Scheme::Triadic, Scheme::Root3, Scheme::Dyadic}) {
        const Space coarse =
            must(make_space(relief::test::built(relief::test::triangle_grid(5, 4, 0.02))));
        const Refinement step = must(refine(coarse, {.scheme = scheme}));
        const Coefficients a = random_spline(coarse, 1);
        const Coefficients b = random_spline(step.fine, 2);
        const auto product = [](const Coefficients& u, const Coefficients& v) {
            double sum = 0;
            for (std::size_t k = 0; k < u.size(); ++k)
                for (int j = 0; j < 3; ++j) sum += u[k][j] * v[k][j];
            return sum;
        };
        EXPECT_NEAR(product(prolong(coarse, step, a), b),
                    product(a, transpose_prolong(coarse, step, b)), 1e-11);
    }
}

/// The two edge points of a corner far towards it: with kappa = 2/3 the new vertices of its edges
/// would see each other beyond Z; both rules keep kappa rho below 1 (erratum 1).
TEST(PsRefine, CutsStayBeforeTheInnerPoint) {
    Space space =
        must(make_space(relief::test::built({{{0, 0}, {1, 0.1}, {-1, 0.1}}, {{0, 1, 2}}})));
    const TriangleCorners corners = space.mesh.corners(0);
    for (int k : {0, 2}) {
        const Index e = space.mesh.triangle_edges[0][k];
        const bool corner_is_lower = space.mesh.edges[e][0] == 0;
        space.split.edge_weight[e] = corner_is_lower ? 0.05 : 0.95;
    }
    const double inverse = space.element(0).inverse_ratios()[0];
    EXPECT_NEAR(1 / inverse, 1.895, 1e-3);
    const Refinement closed = must(refine(space));
    const Refinement halved = must(refine(space, {.cut = CutRule::Halving}));
    EXPECT_NEAR(closed.kappa[0], 0.75 * inverse, 1e-12);
    EXPECT_NEAR(halved.kappa[0], 1.0 / 3, 1e-12);
    EXPECT_GT(orient(corners[0], corners[1], corners[2]), 0);
}

/// Delaunay triangulations of random sites, with triangles taken out: holes, bow-ties, notches,
/// components, any valence.
TEST(PsRefine, RandomTriangulations) {
    rc::check("random sites", [] {
        Noise noise(*rc::gen::arbitrary<std::uint32_t>());
        std::vector<Vec2> sites(*rc::gen::inRange<std::size_t>(4, 60));
        for (Vec2& site : sites) site = {noise(), noise()};
        const auto delaunay = mesh::delaunay(sites);
        RC_PRE(delaunay.ok());
        std::vector<Vec2> vertices;
        for (Index v = 0; v < delaunay->mesh.vertex_count(); ++v)
            vertices.push_back(delaunay->mesh.vertex(v));
        std::vector<std::array<Index, 3>> triangles;
        double thinnest = 1;
        for (Index t = 0; t < delaunay->mesh.triangle_count(); ++t) {
            if (noise() > 0.7) continue;
            triangles.push_back(delaunay->mesh.triangles[t]);
            const TriangleCorners v = delaunay->mesh.corners(t);
            double longest = 0;
            for (int k = 0; k < 3; ++k) longest = std::max(longest, length(v[k] - v[(k + 1) % 3]));
            thinnest = std::min(thinnest, orient(v[0], v[1], v[2]) / (longest * longest));
        }
        RC_PRE(!triangles.empty() && thinnest > 1e-4);
        const auto used = must(mesh::compact(vertices, triangles));
        const Space coarse = must(make_space(must(mesh::build(used.vertices, used.triangles))));
        RC_ASSERT(enclosure_excess(coarse) * thinnest < 1e-11);
        const Coefficients spline = random_spline(coarse, 1);
        const Refinement step = must(refine(coarse));
        RC_ASSERT(enclosure_excess(step.fine) * thinnest < 1e-11);
        const Coefficients fine = prolong(coarse, step, spline);
        const Pointwise before(coarse, spline);
        const Pointwise after(step.fine, fine);
        for (Index t = 0; t < step.fine.mesh.triangle_count(); t += 3) {
            const Vec2 point = inner_point(step.fine.mesh, t, noise);
            const double expected = before.jet(t / 9, point).value;
            // Roundings of B-splines grow as triangles get thinner.
            RC_ASSERT(std::abs(after.jet(t, point).value - expected) < 1e-14 / thinnest);
        }
    });
}

/// Values of refined splines lose digits in proportion to the thinness of triangles.
TEST(PsRefine, Slivers) {
    for (const double thin : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
        const Space coarse =
            must(make_space(relief::test::built({{{0, 0}, {1, 0}, {0.3, thin}, {0.5, 1}, {0.4, -1}},
                                                 {{0, 1, 2}, {0, 2, 3}, {2, 1, 3}, {0, 4, 1}}})));
        const Coefficients spline = random_spline(coarse, 2);
        const Refinement step = must(refine(coarse));
        const Coefficients fine = prolong(coarse, step, spline);
        const Pointwise before(coarse, spline);
        const Pointwise after(step.fine, fine);
        Noise noise(3);
        for (Index t = 0; t < step.fine.mesh.triangle_count(); ++t) {
            const Vec2 point = inner_point(step.fine.mesh, t, noise);
            EXPECT_NEAR(after.jet(t, point).value, before.jet(t / 9, point).value, 1e-14 / thin);
        }
    }
}

TEST(PsRefine, SameBytesForAnyThreadCount) {
    const Space coarse =
        must(make_space(relief::test::built(relief::test::triangle_grid(30, 30, 0.15))));
    const Coefficients spline = random_spline(coarse, 2);
    const Refinement several = must(refine(coarse));
    const Coefficients fine = prolong(coarse, several, spline);
    set_thread_count(1);
    const Refinement one = must(refine(coarse));
    EXPECT_EQ(one.fine.control, several.fine.control);
    EXPECT_EQ(one.fine.split.edge_weight, several.fine.split.edge_weight);
    EXPECT_EQ(prolong(coarse, one, spline), fine);
    set_thread_count(0);
}

TEST(PsRefine, Errors) {
    const Space coarse = must(make_space(relief::test::built(relief::test::triangle_star(13))));
    EXPECT_FALSE(refine(coarse, {.eta = 0}).ok());
    EXPECT_FALSE(refine(coarse, {.eta = 1}).ok());
    EXPECT_FALSE(refine(coarse, {.eta = NAN}).ok());
}

}  // namespace
}  // namespace relief::multires::ps
