#include "relief/multires/ps_surface.h"

#include <rapidcheck.h>

#include <cstring>

#include "ps_testing.h"
#include "relief/core/parallel.h"

namespace relief::multires::ps {
namespace {

using namespace test;
using spline::PlaneJet;

Space grid_space(Index cols, Index rows, double shake, std::uint64_t seed = 1) {
    return must(
        make_space(relief::test::built(relief::test::triangle_grid(cols, rows, shake, {}, seed))));
}

Surface surface_of(const Space& space, const std::vector<Coefficients>& components) {
    return must(Surface::create(space, components));
}

void expect_near(const PlaneJet& a, const PlaneJet& b, double tolerance) {
    const double scale = std::max({1.0, length(b.gradient), std::abs(b.xx), std::abs(b.yy)});
    EXPECT_NEAR(a.value, b.value, tolerance * scale);
    EXPECT_NEAR(a.gradient.x, b.gradient.x, tolerance * scale);
    EXPECT_NEAR(a.gradient.y, b.gradient.y, tolerance * scale);
    EXPECT_NEAR(a.xx, b.xx, tolerance * scale);
    EXPECT_NEAR(a.xy, b.xy, tolerance * scale);
    EXPECT_NEAR(a.yy, b.yy, tolerance * scale);
}

TEST(PsSurface, JetsAreThoseOfTheElements) {
    Noise noise(3);
    for (const Space& space : space_family()) {
        std::vector<Coefficients> components;
        for (const std::uint64_t seed : {1, 2, 3}) components.push_back(random_spline(space, seed));
        const Surface surface = surface_of(space, components);
        for (Index t = 0; t < space.mesh.triangle_count(); ++t) {
            const Vec2 point = inner_point(space.mesh, t, noise);
            std::array<PlaneJet, 3> jets;
            surface.jets(t, point, jets.data());
            for (int m = 0; m < 3; ++m) {
                expect_near(jets[m], Pointwise(space, components[m]).jet(t, point), 1e-14);
                EXPECT_EQ(surface.jet(t, point, m).value, jets[m].value);
            }
        }
    }
}

TEST(PsSurface, PointsOfAnyOrder) {
    const Space space = grid_space(20, 15, 0.15);
    const std::vector<Coefficients> components = {random_spline(space, 1), random_spline(space, 2)};
    const Surface surface = surface_of(space, components);
    const mesh::TriangleLocator locator(space.mesh);
    std::vector<Vec2> points;
    Noise noise(4);
    for (int k = 0; k < 3000; ++k) points.push_back({10 + 10 * noise(), 7.5 + 7.5 * noise()});
    std::vector<PlaneJet> jets(2 * points.size());
    ASSERT_TRUE(evaluate(surface, locator, points, jets).ok());
    const Pointwise first(space, components[0]);
    for (std::size_t k = 0; k < points.size(); k += 37) {
        const Vec2 point = points[k] - space.mesh.origin;
        expect_near(jets[2 * k], first.jet(brute_force_locate(space.mesh, point), point), 1e-13);
    }
    std::vector<Vec2> backwards(points.rbegin(), points.rend());
    std::vector<PlaneJet> again(jets.size());
    set_thread_count(1);
    ASSERT_TRUE(evaluate(surface, locator, backwards, again).ok());
    set_thread_count(0);
    for (std::size_t k = 0; k < points.size(); ++k)
        for (std::size_t m = 0; m < 2; ++m) {
            const PlaneJet& a = jets[2 * k + m];
            const PlaneJet& b = again[2 * (points.size() - 1 - k) + m];
            EXPECT_EQ(a.value, b.value);
            EXPECT_EQ(a.gradient, b.gradient);
            EXPECT_EQ(a.xy, b.xy);
        }
}

TEST(PsSurface, OutsideTheDomain) {
    const Space space = grid_space(4, 4, 0);
    TangentPlanes planes;  // x - 2y
    for (Index v = 0; v < space.mesh.vertex_count(); ++v) {
        const Vec2 p = space.mesh.vertex(v) + space.mesh.origin;
        planes.push_back({p.x - 2 * p.y, {1, -2}});
    }
    const Surface surface = surface_of(space, {coefficients(space, planes)});
    const mesh::TriangleLocator locator(space.mesh);
    const std::vector<Vec2> points = {{1, 1}, {6, 3}, {-1, -1}};
    std::vector<PlaneJet> jets(3);
    const Status rejected = evaluate(surface, locator, points, jets, Outside::Reject);
    ASSERT_FALSE(rejected.ok());
    EXPECT_EQ(rejected.error().where, "point 1");
    ASSERT_TRUE(evaluate(surface, locator, points, jets, Outside::Nan).ok());
    EXPECT_NEAR(jets[0].value, -1, 1e-14);
    EXPECT_TRUE(std::isnan(jets[1].value) && std::isnan(jets[2].gradient.y));
    ASSERT_TRUE(evaluate(surface, locator, points, jets, Outside::Nearest).ok());
    EXPECT_NEAR(jets[1].value, 4 - 6, 1e-13);  // at (4, 3)
    EXPECT_NEAR(jets[2].value, 0, 1e-13);      // at (0, 0)
    const std::vector<Vec2> bad = {{1, 1}, {NAN, 3}, {1, 1}};
    EXPECT_EQ(evaluate(surface, locator, bad, jets, Outside::Nearest).error().where, "point 1");
    EXPECT_FALSE(evaluate(surface, locator, points, std::span(jets).first(2)).ok());
}

/// Rasters of any frame hold, to the bit, what single points have, but for samples within rounding
/// of the border of a piece.
TEST(PsSurface, RasterIsPointwise) {
    rc::check("random frames", [] {
        const Space space =
            grid_space(*rc::gen::inRange<Index>(1, 9), *rc::gen::inRange<Index>(1, 9), 0.19, 5);
        const Surface surface = surface_of(space, {random_spline(space, 6)});
        const mesh::TriangleLocator locator(space.mesh);
        Noise noise(*rc::gen::arbitrary<std::uint32_t>());
        const auto count = *rc::gen::inRange<std::int64_t>(1, 90);
        const double size = 0.02 + 0.3 * (1 + noise());
        const RasterFrame frame{{noise(), 4 + 3 * noise()},
                                {size, *rc::gen::arbitrary<bool>() ? size : -size}};
        Grid<double> out(count, count + 3);
        RC_ASSERT(evaluate_raster(surface, frame, out.view()).ok());
        for (std::int64_t r = 0; r < out.rows(); ++r)
            for (std::int64_t c = 0; c < out.cols(); ++c) {
                const Vec2 point{frame.first.x + static_cast<double>(c) * frame.step.x,
                                 frame.first.y + static_cast<double>(r) * frame.step.y};
                const Index t = locator.locate(point);
                RC_ASSERT(std::isnan(out(r, c)) == (t == mesh::kNone));
                if (t == mesh::kNone) continue;
                const double value = surface.jet(t, point - space.mesh.origin).value;
                RC_ASSERT(std::abs(out(r, c) - value) <= 1e-12);
            }
    });
}

TEST(PsSurface, RasterOnLatticeOfVertices) {
    // Every sample is a vertex, on an edge or on the boundary.
    const Space space = grid_space(6, 5, 0);
    const Coefficients spline = random_spline(space, 7);
    const Surface surface = surface_of(space, {spline});
    const TangentPlanes planes = tangent_planes(space, spline);
    Grid<double> out(6, 7);
    ASSERT_TRUE(evaluate_raster(surface, {{0, 0}, {1, 1}}, out.view(), 0, Outside::Reject).ok());
    for (std::int64_t r = 0; r < 6; ++r)
        for (std::int64_t c = 0; c < 7; ++c)
            EXPECT_NEAR(out(r, c), planes[static_cast<std::size_t>(7 * r + c)].value, 1e-13);
    Grid<double> turned(6, 7);
    ASSERT_TRUE(evaluate_raster(surface, {{0, 5}, {1, -1}}, turned.view()).ok());
    for (std::int64_t r = 0; r < 6; ++r)
        for (std::int64_t c = 0; c < 7; ++c) EXPECT_EQ(turned(r, c), out(5 - r, c));
    // A tenth is not exact: samples on the far boundary lie beside it.
    Grid<double> tenths(51, 61);
    ASSERT_TRUE(
        evaluate_raster(surface, {{0, 0}, {0.1, 0.1}}, tenths.view(), 0, Outside::Reject).ok());
    EXPECT_NEAR(tenths(50, 60), out(5, 6), 1e-13);
}

TEST(PsSurface, RasterErrors) {
    const Space space = grid_space(2, 2, 0);
    const Surface surface = surface_of(space, {random_spline(space, 8)});
    Grid<double> out(4, 4);
    for (const RasterFrame& frame :
         {RasterFrame{{0, 0}, {0, 1}}, RasterFrame{{0, 0}, {-1, 1}}, RasterFrame{{0, 0}, {1, 0}},
          RasterFrame{{NAN, 0}, {1, 1}}, RasterFrame{{0, INFINITY}, {1, 1}},
          RasterFrame{{0, 0}, {1, NAN}}, RasterFrame{{1e20, 0}, {1, 1}}})
        EXPECT_EQ(evaluate_raster(surface, frame, out.view()).error().code,
                  ErrorCode::InvalidArgument);
    EXPECT_FALSE(evaluate_raster(surface, {}, out.view(), 1).ok());
    EXPECT_FALSE(evaluate_raster(surface, {}, out.view(), 0, Outside::Nearest).ok());
    EXPECT_EQ(evaluate_raster(surface, {}, out.view(), 0, Outside::Reject).error().where, "row 0");
    const mesh::TriangleLocator locator(space.mesh);
    ASSERT_TRUE(evaluate_raster(surface, {}, out.view(), 0, Outside::Nearest, &locator).ok());
    EXPECT_NEAR(out(3, 3), out(2, 2), 1e-12);
    EXPECT_FALSE(Surface::create(space, {}).ok());
}

TEST(PsSurface, RasterSameBytesForAnyThreadCount) {
    const Space space = grid_space(17, 23, 0.18);
    const Surface surface = surface_of(space, {random_spline(space, 9)});
    const RasterFrame frame{{-0.3, 23.2}, {0.05, -0.07}};
    Grid<double> several(340, 350);
    Grid<double> one(340, 350);
    ASSERT_TRUE(evaluate_raster(surface, frame, several.view()).ok());
    set_thread_count(1);
    ASSERT_TRUE(evaluate_raster(surface, frame, one.view()).ok());
    set_thread_count(0);
    for (std::int64_t r = 0; r < one.rows(); ++r)
        EXPECT_EQ(std::memcmp(one.view().row(r), several.view().row(r),
                              static_cast<std::size_t>(one.cols()) * sizeof(double)),
                  0);
}

TEST(PsSurface, Normals) {
    const PlaneJet jet{3, {2, -1}, 0, 0, 0};
    const Vec3<double> up = graph_normal(jet);
    EXPECT_NEAR(up.x, -2 / std::sqrt(6), 1e-15);
    EXPECT_NEAR(up.y, 1 / std::sqrt(6), 1e-15);
    EXPECT_NEAR(up.z, 1 / std::sqrt(6), 1e-15);
    // The graph as a parametric surface (u, v, f).
    const std::array<PlaneJet, 3> graph = {PlaneJet{0, {1, 0}, 0, 0, 0}, {0, {0, 1}, 0, 0, 0}, jet};
    const Vec3<double> normal = parametric_normal(graph);
    EXPECT_NEAR(length(normal - up), 0, 1e-15);
    const std::array<PlaneJet, 3> flat = {PlaneJet{0, {1, 2}, 0, 0, 0}, {0, {2, 4}, 0, 0, 0}, {}};
    EXPECT_TRUE(std::isnan(parametric_normal(flat).z));
}

}  // namespace
}  // namespace relief::multires::ps
