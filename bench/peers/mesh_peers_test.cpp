#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "mesh_peer.h"
#include "shapes.h"

/// Other libraries as oracles: the same points to rounding, and as many faces.
namespace relief::peers {
namespace {

Polygons polygons_of(const test::Shape& shape) {
    Polygons result{shape.faces, {}};
    for (const auto& p : shape.points) result.points.push_back({p[0], p[1], p[2]});
    return result;
}

/// How far the points of `from` are from those of `to` at most. Libraries number them differently.
double distance(const Polygons& from, const Polygons& to) {
    double most = 0;
    for (const auto& p : from.points) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto& q : to.points) nearest = std::min(nearest, dot(p - q, p - q));
        most = std::max(most, nearest);
    }
    return std::sqrt(most);
}

const MeshPeer* find(const MeshPeers& peers, const std::string& name) {
    for (const auto& peer : peers)
        if (peer->name() == name) return peer.get();
    return nullptr;
}

/// Floats of shapes of extent 8, some steps: 4e-6; doubles: 1e-13.
void expect_same(const std::string& library, const test::Shape& shape, MeshScheme scheme,
                 int steps) {
    SCOPED_TRACE(library + ", " + multires::mesh_scheme_name(scheme) + ", " +
                 std::to_string(shape.size()) + " vertices");
    const MeshPeers peers = all_mesh_peers();
    const MeshPeer* const peer = find(peers, library);
    if (!peer) GTEST_SKIP() << library << " was not there when this was built";
    const Polygons base = polygons_of(shape);
    const Subdividing task{base, scheme, steps};
    const auto ours = find(peers, "relief double")->result(task);
    const auto theirs = peer->result(task);
    ASSERT_TRUE(ours.ok() && theirs.ok());
    ASSERT_EQ(ours->points.size(), theirs->points.size());
    EXPECT_EQ(ours->faces.size(), theirs->faces.size());
    const double tolerance = peer->scalar() == "float" ? 4e-6 : 1e-13;
    EXPECT_LT(distance(*ours, *theirs), tolerance);
    EXPECT_LT(distance(*theirs, *ours), tolerance);
}

test::Shape irregular() {
    return test::flipped(test::icosahedron(), 60, 5);
}

TEST(MeshPeers, OpenSubdivLoop) {
    expect_same("OpenSubdiv", irregular(), MeshScheme::Loop, 3);
    expect_same("OpenSubdiv", test::grid(4, 3, true), MeshScheme::Loop, 3);
    expect_same("OpenSubdiv", test::flipped(test::grid(4, 4, true), 30, 9), MeshScheme::Loop, 3);
}

TEST(MeshPeers, OpenSubdivCatmullClark) {
    expect_same("OpenSubdiv", test::double_torus(), MeshScheme::CatmullClark, 3);
    expect_same("OpenSubdiv", irregular(), MeshScheme::CatmullClark, 3);
    expect_same("OpenSubdiv", test::grid(4, 3, false), MeshScheme::CatmullClark, 3);
    expect_same("OpenSubdiv", test::both(test::tetrahedron(), test::double_torus()),
                MeshScheme::CatmullClark, 2);
}

/// Its Catmull-Clark boundaries have rules of their own.
TEST(MeshPeers, OpenMesh) {
    expect_same("OpenMesh", irregular(), MeshScheme::Loop, 3);
    expect_same("OpenMesh", test::grid(4, 3, true), MeshScheme::Loop, 3);
    expect_same("OpenMesh", test::double_torus(), MeshScheme::CatmullClark, 3);
    expect_same("OpenMesh", irregular(), MeshScheme::Sqrt3, 4);
    expect_same("OpenMesh", test::grid(4, 3, true), MeshScheme::Sqrt3, 2);
    expect_same("OpenMesh", test::grid(4, 3, true), MeshScheme::Sqrt3, 4);
}

TEST(MeshPeers, Cgal) {
    expect_same("CGAL", irregular(), MeshScheme::Loop, 3);
    expect_same("CGAL", test::grid(4, 3, true), MeshScheme::Loop, 3);
    expect_same("CGAL", test::double_torus(), MeshScheme::CatmullClark, 3);
    expect_same("CGAL", test::grid(4, 3, false), MeshScheme::CatmullClark, 3);
    expect_same("CGAL", irregular(), MeshScheme::Sqrt3, 4);
    expect_same("CGAL", test::grid(4, 3, true), MeshScheme::Sqrt3, 2);
    expect_same("CGAL", test::grid(4, 3, true), MeshScheme::Sqrt3, 4);
}

}  // namespace
}  // namespace relief::peers
