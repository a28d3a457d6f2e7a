#include "relief/multires/mesh_pyramid.h"

#include <cmath>
#include <random>

#include "mesh_support.h"
#include "relief/multires/subdivide.h"

namespace relief::multires {
namespace {

using test::Points;

/// A subdivided mesh with noise: in the numbers of subdivision.
struct Subdivided {
    mesh::Topology mesh;
    Points points;
};

Subdivided subdivided(const test::Shape& shape, MeshScheme scheme, int steps, double noise) {
    SubdividedMesh<double> mesh;
    mesh.mesh = shape.topology();
    mesh.arrays = {test::points_of(shape)};
    mesh = *subdivide(std::move(mesh), {.scheme = scheme}, steps);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> spread(-noise, noise);
    for (Vec3<double>& p : mesh.arrays[0]) p += {spread(random), spread(random), spread(random)};
    return {std::move(mesh.mesh), std::move(mesh.arrays[0])};
}

MeshPyramid pyramid_of(const Subdivided& fine, MeshScheme scheme, int most = 30) {
    auto pyramid = MeshPyramid::analyse(fine.mesh, fine.points, {}, scheme, most, {});
    EXPECT_TRUE(pyramid.ok()) << pyramid.error().text();
    return *std::move(pyramid);
}

TEST(MeshPyramid, GivesTheMeshBackInItsNumbers) {
    for (const MeshScheme scheme :
         {MeshScheme::Loop, MeshScheme::Sqrt3, MeshScheme::CatmullClark}) {
        const Subdivided fine = subdivided(test::icosahedron(), scheme, 2, 0.01);
        const MeshPyramid pyramid = pyramid_of(fine, scheme);
        ASSERT_EQ(pyramid.levels(), 2);
        const Points points = pyramid.synthesise();
        ASSERT_EQ(points.size(), fine.points.size());
        // Lifting subtracts what it added; coordinates are near 1.
        for (std::size_t v = 0; v < points.size(); ++v)
            EXPECT_LT(length(points[v] - fine.points[pyramid.numbers()[v]]), 1e-14);
    }
}

TEST(MeshPyramid, OfASubdivisionHasTheBaseAndNoDetails) {
    const test::Shape base = test::icosahedron();
    const Subdivided fine = subdivided(base, MeshScheme::Loop, 3, 0);
    MeshPyramid pyramid = pyramid_of(fine, MeshScheme::Loop);
    ASSERT_EQ(pyramid.levels(), 3);
    const Points expected = test::points_of(base);
    for (std::size_t v = 0; v < expected.size(); ++v)
        EXPECT_LT(length(pyramid.band(3)[v] - expected[v]), 1e-14);
    for (int level = 0; level < 3; ++level)
        for (const Vec3<double>& detail : pyramid.band(level)) EXPECT_LT(length(detail), 1e-14);
    // What is done to the base is done to the mesh: subdivision is linear and keeps affine maps.
    for (Vec3<double>& p : pyramid.band(3)) p.z *= 2;
    const Points bent = pyramid.synthesise();
    for (std::size_t v = 0; v < bent.size(); ++v) {
        const Vec3<double>& p = fine.points[pyramid.numbers()[v]];
        EXPECT_LT(length(bent[v] - Vec3<double>{p.x, p.y, 2 * p.z}), 1e-14);
    }
}

TEST(MeshPyramid, CoarserLevelsAreTheFirstVertices) {
    const Subdivided fine = subdivided(test::icosahedron(), MeshScheme::Loop, 3, 0.01);
    const MeshPyramid pyramid = pyramid_of(fine, MeshScheme::Loop, 2);
    ASSERT_EQ(pyramid.levels(), 2);
    EXPECT_EQ(pyramid.synthesise(2).size(), pyramid.topology(2).vertex_count);
    const MeshPyramid shallow = pyramid_of(fine, MeshScheme::Loop, 1);
    // Two steps down and one up: what lifting subtracts is added again, up to rounding.
    EXPECT_LT(test::distance(pyramid.synthesise(1), shallow.synthesise(1)), 1e-14);
}

TEST(MeshPyramid, NamesAVertexThatIsNoPoint) {
    Subdivided fine = subdivided(test::icosahedron(), MeshScheme::Loop, 1, 0);
    fine.points[7].y = NAN;
    const auto pyramid = MeshPyramid::analyse(fine.mesh, fine.points, {}, MeshScheme::Loop, 30, {});
    ASSERT_FALSE(pyramid.ok());
    EXPECT_EQ(pyramid.error().where, "vertex 7");
}

}  // namespace
}  // namespace relief::multires
