#include "remesh/moving_mesh.h"

#include "meshes.h"
#include "remesh/align.h"
#include "remesh/fit.h"
#include "remesh/levels.h"
#include "remesh/pins.h"
#include "remesh/relax.h"

namespace relief::remesh {

namespace {

using mesh::Index;

/// A surface, its base, and a mesh of two levels on it.
struct Bed {
    Surface surface;
    Levels levels;
    mesh::TriangleTree tree;
    std::vector<double> curvature;

    explicit Bed(const test::Shape& shape, Index base = 80, int steps = 2)
        : surface(test::surface_of(shape)),
          levels(*Levels::create(surface, Simplification(surface, {.faces = base}), steps)),
          tree(mesh::fan_triangles(polygons(surface.points, surface.mesh.origin))),
          curvature(relative_curvature(surface)) {}

    template <class Corners>
    static PolygonMesh polygons(const std::vector<Vec3<double>>& points, const Corners& corners) {
        PolygonMesh mesh;
        for (const auto& p : points) mesh.vertices.push_back({p.x, p.y, p.z});
        for (std::size_t k = 0; k < corners.size(); k += 3)
            mesh.add_polygon(std::array{static_cast<std::int32_t>(corners[k]),
                                        static_cast<std::int32_t>(corners[k + 1]),
                                        static_cast<std::int32_t>(corners[k + 2])});
        return mesh;
    }
    [[nodiscard]] mesh::SurfaceDistance distance(const MovingMesh& mesh) const {
        return *mesh::surface_distance(polygons(surface.points, surface.mesh.origin),
                                       polygons(mesh.points, mesh.corners), 20000);
    }
};

TEST(MovingMesh, VerticesOfTheBaseLieOnThoseOfTheSurface) {
    const Bed bed(test::bumpy_sphere(5, 0.3));
    const MovingMesh mesh = bed.levels.mapped(2);
    for (std::size_t v = 0; v < bed.levels.base().vertices().size(); ++v)
        EXPECT_LT(length(mesh.points[v] - bed.surface.points[bed.levels.base().vertices()[v]]),
                  1e-12);
    EXPECT_EQ(mesh.points.size(), bed.levels.hierarchy().vertices(2));
}

TEST(MovingMesh, BoundaryVerticesAreSpreadOverTheBoundary) {
    const Bed bed(test::tube(60, 20, 3));
    const MovingMesh mesh = bed.levels.mapped(2);
    const mesh::Topology& fine = bed.levels.hierarchy().topology(2);
    std::size_t count = 0;
    for (Index h = 0; h < fine.half_edge_count(); ++h) {
        if (fine.twin.size() > 0 && !fine.on_boundary(h)) continue;
        if (fine.twin.size() == 0) break;
        const Vec3<double> p = bed.surface.original(mesh.points[fine.origin[h]]);
        EXPECT_NEAR(std::min(std::abs(p.z), std::abs(p.z - 3)), 0, 1e-12);
        EXPECT_TRUE(mesh.fixed[fine.origin[h]]);
        ++count;
    }
    std::size_t fixed = 0;
    for (Index v = 0; v < mesh.points.size(); ++v) {
        if (!mesh.fixed[v]) continue;
        const Vec3<double> p = bed.surface.original(mesh.points[v]);
        EXPECT_NEAR(std::min(std::abs(p.z), std::abs(p.z - 3)), 0, 1e-12);
        EXPECT_NEAR(std::hypot(p.x, p.y), 1, 2e-3);  // chords of 60 sides: 1 - cos(pi/60)
        ++fixed;
    }
    EXPECT_GE(fixed, 2 * 3 * 4U);
}

TEST(MovingMesh, MovesAddNoFlips) {
    const Bed bed(test::bumpy_sphere(4, 0.3));
    MovingMesh mesh = bed.levels.mapped(2);
    mesh.untangle();
    ASSERT_TRUE(mesh.flips().empty());
    // Steps of several edges, everywhere into one direction: most would tear the mesh.
    for (const Vec3<double>& step : {Vec3<double>{0.2, 0, 0}, {0, -0.1, 0.1}, {0.05, 0.3, 0}}) {
        std::vector<Vec3<double>> steps(mesh.points.size(), step);
        for (std::size_t v = 0; v < steps.size(); v += 3) steps[v] = -2.0 * step;
        mesh.move(steps);
        EXPECT_TRUE(mesh.flips().empty());
    }
}

TEST(MovingMesh, UntanglesWhatIsFlipped) {
    const Bed bed(test::bumpy_sphere(5, 0.3));
    MovingMesh mesh = bed.levels.mapped(2);
    relax(mesh, bed.curvature, bed.tree, 5);
    for (Index v = 100; v < mesh.points.size(); v += 60)  // beyond their neighbours
        mesh.put(v, walk(bed.surface, mesh.places[v], {0.08, -0.05, 0.06}));
    ASSERT_GT(mesh.flips().size(), 5U);
    mesh.untangle();
    EXPECT_TRUE(mesh.flips().empty());
}

TEST(Relax, BringsVerticesWhereTheSurfaceCurves) {
    const Bed bed(test::bumpy_sphere(6, 0.35));
    MovingMesh mesh = bed.levels.mapped(2);
    mesh.untangle();
    const double before = bed.distance(mesh).rms();
    relax(mesh, bed.curvature, bed.tree, 30);
    EXPECT_LT(bed.distance(mesh).rms(), 0.9 * before);
    EXPECT_TRUE(mesh.flips().empty());
}

TEST(Align, TurnsDetailsTowardsNormals) {
    const Bed bed(test::bumpy_sphere(6, 0.3));
    MovingMesh mesh = bed.levels.mapped(2);
    relax(mesh, bed.curvature, bed.tree, 20);
    double last = *tangential_rms(mesh, bed.levels.hierarchy());
    const double first = last;
    for (int round = 0; round < 4; ++round) {
        ASSERT_TRUE(align(mesh, bed.levels.hierarchy(), 1).ok());
        const double now = *tangential_rms(mesh, bed.levels.hierarchy());
        EXPECT_LT(now, last) << round;
        last = now;
        EXPECT_TRUE(mesh.flips().empty());
    }
    EXPECT_LT(last, 0.5 * first);
}

TEST(Fit, HalvesTheDistanceOfASphere) {
    const Bed bed(test::bumpy_sphere(6, 0));
    MovingMesh mesh = bed.levels.mapped(2);
    relax(mesh, bed.curvature, bed.tree, 10);
    const double before = bed.distance(mesh).rms();
    fit(mesh, bed.tree, 2);
    EXPECT_LT(bed.distance(mesh).rms(), 0.6 * before);
    EXPECT_TRUE(mesh.flips().empty());
}

TEST(Pins, BringTheFarthestVerticesBack) {
    const Bed bed(test::bumpy_sphere(6, 0.35));
    MovingMesh mesh = bed.levels.mapped(2);
    mesh.untangle();
    const Reverse before = distances_from(mesh);
    const double most = *std::max_element(before.distances.begin(), before.distances.end());
    const std::size_t pinned = pin_far_vertices(mesh, 0.7 * most);
    EXPECT_GE(pinned, 1U);
    const auto far =
        static_cast<Index>(std::max_element(before.distances.begin(), before.distances.end()) -
                           before.distances.begin());
    EXPECT_LT(distances_from(mesh).distances[far], 1e-12);
    EXPECT_TRUE(mesh.flips().empty());
}

TEST(Pins, FarVerticesKeepOthersAway) {
    const Surface surface = test::surface_of(test::grid(30, 30, true));
    std::vector<double> distances(surface.points.size(), 1);
    const auto chosen = far_vertices(surface, distances, 0.5, 0.1, 1000);
    // Each keeps others away by twice its distance: all of them.
    EXPECT_EQ(chosen, std::vector<Index>{0});
    for (double& d : distances) d = 0.01;
    const auto many = far_vertices(surface, distances, 0.005, 0.1, 1000);
    EXPECT_GT(many.size(), 30U);
    for (const Index a : many)
        for (const Index b : many)
            EXPECT_TRUE(a == b || length(surface.points[a] - surface.points[b]) >= 0.1);
}

}  // namespace

}  // namespace relief::remesh
