#include "relief/multires/subdivide.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <sstream>

#include "multires/mesh_support.h"

namespace relief::multires {
namespace {

using mesh::Index;
using test::distance;
using test::noisy;
using test::Points;
using test::points_of;

SubdividedMesh<double> mesh_of(const test::Shape& shape) {
    return {shape.topology(), {points_of(shape)}, {}};
}

/// A shape file of OpenSubdiv.
test::Shape read_shape(const std::string& name) {
    const char* folder = std::getenv("RELIEF_DATA");
    std::ifstream file(std::string(folder ? folder : RELIEF_SHARED_DATA) + "/meshes/" + name);
    test::Shape shape;
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string key;
        words >> key;
        if (key == "v") {
            test::Point p{};
            words >> p[0] >> p[1] >> p[2];
            shape.points.push_back(p);
        } else if (key == "f") {
            std::vector<Index> face;
            for (std::string corner; words >> corner;)
                face.push_back(static_cast<Index>(std::stoul(corner)) - 1);
            shape.faces.add(face);
        }
    }
    return shape;
}

/// Boundary vertices with one face stay.
void keep_corners(SubdividedMesh<double>& mesh) {
    MeshTags tags;
    tag_boundary_corners(mesh.mesh, tags);
    mesh.sharpness.vertices.assign(tags.corner.size(), 0);
    for (std::size_t v = 0; v < tags.corner.size(); ++v)
        if (tags.corner[v]) mesh.sharpness.vertices[v] = HUGE_VAL;
}

TEST(Subdivide, OpenSubdivShapes) {
    const struct {
        const char* name;
        MeshScheme scheme;
        bool corners;
    } shapes[] = {{"catmark_cube", MeshScheme::CatmullClark, false},
                  {"catmark_tent", MeshScheme::CatmullClark, false},
                  {"catmark_flap", MeshScheme::CatmullClark, false},
                  {"loop_icosahedron", MeshScheme::Loop, false},
                  {"catmark_edgecorner", MeshScheme::CatmullClark, true},
                  {"loop_saddle_edgecorner", MeshScheme::Loop, true}};
    for (const auto& shape : shapes) {
        const std::string name = std::string("osd_") + shape.name;
        const test::Shape base = read_shape(name + "_level0.obj");
        const test::Shape fine = read_shape(name + "_level4.obj");
        if (base.points.empty()) GTEST_SKIP() << "RELIEF_DATA has no meshes";
        SubdividedMesh<double> mesh = mesh_of(base);
        if (shape.corners) keep_corners(mesh);
        mesh = *subdivide(std::move(mesh), {.scheme = shape.scheme}, 4);
        ASSERT_EQ(mesh.arrays[0].size(), fine.points.size()) << name;
        EXPECT_EQ(mesh.mesh.face_count, fine.faces.size()) << name;
        // Another order of vertices: each has one within the digits that are printed.
        for (const auto& p : points_of(fine)) {
            double nearest = 1;
            for (const auto& q : mesh.arrays[0]) nearest = std::min(nearest, length(p - q));
            ASSERT_LT(nearest, 5e-7) << name;
        }
    }
}

/// A crease of sharpness 1 is sharp for one step; 0.4 blends; 1.5 blends the second step.
TEST(Subdivide, SemiSharpCreases) {
    const test::Shape base = test::grid(4, 4, false, true);
    const auto run = [&](double sharpness, int steps) {
        SubdividedMesh<double> mesh = mesh_of(base);
        mesh.sharpness.edges.assign(mesh.mesh.edge_count, 0);
        for (Index h = 0; h < mesh.mesh.half_edge_count(); ++h)
            if (mesh.mesh.origin[h] / 4 == 1 && mesh.mesh.target(h) / 4 == 1)
                mesh.sharpness.edges[mesh.mesh.edge[h]] = sharpness;
        return *subdivide(std::move(mesh), {.scheme = MeshScheme::CatmullClark}, steps);
    };
    const auto smooth = run(0, 1).arrays[0];
    const auto sharp = run(HUGE_VAL, 1).arrays[0];
    const auto one = run(1, 1).arrays[0];
    const auto part = run(0.4, 1).arrays[0];
    EXPECT_LT(distance(sharp, one), 1e-15);
    EXPECT_GT(distance(sharp, smooth), 0.01);
    for (std::size_t v = 0; v < part.size(); ++v)
        EXPECT_LT(length(part[v] - (0.4 * sharp[v] + 0.6 * smooth[v])), 1e-15) << v;
    const auto twice = run(1.5, 2);
    SubdividedMesh<double> again = run(1.5, 1);
    for (const double s : again.sharpness.edges) EXPECT_TRUE(s == 0 || s == 0.5);
    const auto second = *subdivide(std::move(again), {.scheme = MeshScheme::CatmullClark}, 1);
    EXPECT_EQ(twice.arrays[0], second.arrays[0]);
    // The crease is the curve of its own vertices.
    const auto crease = run(HUGE_VAL, 1);
    for (Index k = 0; k < 4; ++k) {
        const auto& c = base.points;
        const auto at = [&](Index i) {
            return Vec3<double>{c[4 + i % 4][0], c[4 + i % 4][1], c[4 + i % 4][2]};
        };
        EXPECT_LT(
            length(crease.arrays[0][4 + k] - (0.75 * at(k) + 0.125 * (at(k + 1) + at(k + 3)))),
            1e-15);
    }
}

TEST(Subdivide, CornersAndSharpVertices) {
    SubdividedMesh<double> mesh = mesh_of(test::icosahedron());
    mesh.sharpness.vertices.assign(12, 0);
    mesh.sharpness.vertices[3] = HUGE_VAL;
    mesh.sharpness.vertices[4] = 1;
    mesh.sharpness.vertices[5] = 0.25;
    const auto smooth = *subdivide(mesh_of(test::icosahedron()), {}, 1);
    const auto sharp = *subdivide(std::move(mesh), {}, 1);
    const Points base = points_of(test::icosahedron());
    EXPECT_EQ(sharp.arrays[0][3], base[3]);
    EXPECT_EQ(sharp.arrays[0][4], base[4]);
    EXPECT_LT(length(sharp.arrays[0][5] - (0.25 * base[5] + 0.75 * smooth.arrays[0][5])), 1e-15);
    EXPECT_EQ(sharp.arrays[0][7], smooth.arrays[0][7]);
    EXPECT_TRUE(std::isinf(sharp.sharpness.vertices[3]));
    EXPECT_EQ(sharp.sharpness.vertices[4], 0);
}

/// Floats are doubles to their precision; further arrays follow the same rules.
TEST(Subdivide, FloatsAndFurtherArrays) {
    const test::Shape base = test::flipped(test::icosahedron(), 30, 2);
    SubdividedMesh<double> mesh = mesh_of(base);
    mesh.arrays.push_back(noisy(Points(12), 2, 1));
    const auto fine = *subdivide(std::move(mesh), {.scheme = MeshScheme::Sqrt3}, 3);
    EXPECT_EQ(fine.arrays[1].size(), fine.arrays[0].size());
    SubdividedMesh<float> single{base.topology(), {{}}, {}};
    for (const auto& p : base.points)
        single.arrays[0].push_back({float(p[0]), float(p[1]), float(p[2])});
    const auto rounded = *subdivide(std::move(single), {.scheme = MeshScheme::Sqrt3}, 3);
    for (std::size_t v = 0; v < fine.arrays[0].size(); ++v) {
        const auto& p = rounded.arrays[0][v];
        EXPECT_LT(length(fine.arrays[0][v] - Vec3<double>{p.x, p.y, p.z}), 2e-6);
    }
}

/// Subdividing brings points to their limits, which stay where they are.
TEST(Subdivide, Limits) {
    const struct {
        test::Shape shape;
        MeshScheme scheme;
    } cases[] = {{test::flipped(test::icosahedron(), 40, 3), MeshScheme::Loop},
                 {test::flipped(test::icosahedron(), 40, 3), MeshScheme::Sqrt3},
                 {test::grid(3, 4, true), MeshScheme::Loop},
                 {test::grid(3, 4, false), MeshScheme::CatmullClark},
                 {test::double_torus(), MeshScheme::CatmullClark},
                 {test::octahedron(), MeshScheme::CatmullClark}};
    for (const auto& c : cases) {
        const SubdividedMesh<double> base = mesh_of(c.shape);
        const std::span<const Vec3<double>> points(base.arrays[0]);
        const auto limits = limit_points<double>(base.mesh, points, {}, c.scheme);
        ASSERT_TRUE(limits.ok());
        const auto normals = *limit_normals<double>(base.mesh, points, {}, c.scheme);
        SubdividedMesh<double> fine = mesh_of(c.shape);
        const int steps = c.scheme == MeshScheme::Sqrt3 ? 8 : 6;
        fine = *subdivide(std::move(fine), {.scheme = c.scheme}, steps);
        const std::span<const Vec3<double>> fine_points(fine.arrays[0]);
        const auto fine_limits = *limit_points<double>(fine.mesh, fine_points, {}, c.scheme);
        const auto fine_normals = *limit_normals<double>(fine.mesh, fine_points, {}, c.scheme);
        for (std::size_t v = 0; v < base.arrays[0].size(); ++v) {
            EXPECT_LT(length((*limits)[v] - fine_limits[v]), 1e-12) << v;
            EXPECT_NEAR(length(normals[v]), 1, 1e-12);
            const auto out = mesh::outgoing(base.mesh);
            if (base.mesh.on_boundary(out[v])) continue;
            EXPECT_LT(length(normals[v] - fine_normals[v]), 1e-9) << v;
        }
        // The faces around a vertex turn towards its normal.
        Vec3<double> mean;
        const auto out = mesh::outgoing(fine.mesh);
        Index h = out[0];
        for (Index k = 0; k < 2 && h != mesh::kNone; ++k, h = mesh::rotated(fine.mesh, h))
            mean += cross(fine.arrays[0][fine.mesh.target(h)] - fine.arrays[0][0],
                          fine.arrays[0][fine.mesh.origin[fine.mesh.prev(h)]] - fine.arrays[0][0]);
        EXPECT_GT(dot(mean, normals[0]), 0.9 * length(mean));
    }
}

TEST(Subdivide, Refusals) {
    for (const double bad : {-1.0, std::nan("")}) {
        SubdividedMesh<double> mesh = mesh_of(test::icosahedron());
        mesh.sharpness.vertices.assign(12, bad);
        EXPECT_FALSE(subdivide(std::move(mesh), {}, 1).ok());
    }
    SubdividedMesh<double> creased = mesh_of(test::icosahedron());
    creased.sharpness.edges.assign(30, 1);
    EXPECT_FALSE(subdivide(std::move(creased), {.scheme = MeshScheme::Sqrt3}, 1).ok());
    SubdividedMesh<double> cut = mesh_of(test::icosahedron());
    cut.arrays[0].pop_back();
    EXPECT_FALSE(subdivide(std::move(cut), {}, 1).ok());
    const auto huge = subdivide(mesh_of(test::icosahedron()), {}, 15);
    ASSERT_FALSE(huge.ok());
    EXPECT_NE(huge.error().text().find("too_many_elements"), std::string::npos);
}

}  // namespace
}  // namespace relief::multires
