#include "relief/multires/mesh_hierarchy.h"

#include <gtest/gtest.h>

#include "multires/mesh_support.h"
#include "relief/core/parallel.h"
#include "relief/multires/mesh_frames.h"

namespace relief::multires {
namespace {

using mesh::Index;
using test::distance;
using test::noisy;
using test::Points;
using test::points_of;

struct Case {
    std::string name;
    test::Shape base;
    MeshScheme scheme;
    int steps;
};

std::vector<Case> cases() {
    const test::Shape holed = test::without_faces(test::grid(5, 5, true, true), {7, 8, 30});
    return {
        {"loop closed", test::flipped(test::icosahedron(), 40, 3), MeshScheme::Loop, 3},
        {"loop open", test::flipped(test::grid(4, 3, true), 20, 2), MeshScheme::Loop, 2},
        {"loop genus 2", test::triangulated(test::double_torus()), MeshScheme::Loop, 2},
        {"loop torus", test::grid(4, 5, true, true), MeshScheme::Loop, 2},
        {"loop two", test::both(test::tetrahedron(), test::grid(3, 2, true)), MeshScheme::Loop, 2},
        {"sqrt3 closed", test::flipped(test::icosahedron(), 40, 3), MeshScheme::Sqrt3, 4},
        {"sqrt3 open", test::flipped(test::grid(4, 3, true), 20, 2), MeshScheme::Sqrt3, 4},
        {"sqrt3 open, odd", holed, MeshScheme::Sqrt3, 3},
        {"quads genus 2", test::double_torus(), MeshScheme::CatmullClark, 3},
        {"quads open", test::grid(3, 4, false), MeshScheme::CatmullClark, 2},
        {"quads torus", test::grid(4, 6, false, true), MeshScheme::CatmullClark, 2},
        {"polygons", test::both(test::tetrahedron(), test::grid(2, 2, false)),
         MeshScheme::CatmullClark, 3},
    };
}

MeshHierarchy hierarchy_of(const Case& c) {
    return *MeshHierarchy::create(c.base.topology(), {}, {.scheme = c.scheme}, c.steps);
}

/// A noisy subdivision surface in the numbers of the hierarchy.
Points surface(const MeshHierarchy& hierarchy, const test::Shape& base, double noise) {
    Points points = points_of(base);
    points.resize(hierarchy.vertices(hierarchy.steps()));
    StiffResiduals residuals;
    for (int step = 0; step < hierarchy.steps(); ++step)
        residuals.emplace_back(hierarchy.rules(step).stiff.size());
    MeshMaps::create(hierarchy, {})->synthesise(0, hierarchy.steps(), points.data(), residuals);
    return noisy(points, 8, noise);
}

/// The finest mesh with its half-edges.
mesh::Topology finest_of(const MeshHierarchy& hierarchy) {
    const mesh::Topology& faces = hierarchy.topology(hierarchy.steps());
    return *mesh::build(mesh::faces_of(faces), faces.vertex_count);
}

/// What the finest level leaves out follows from its faces.
TEST(MeshHierarchy, TheFinestLevelIsTheSplitOfTheOneBefore) {
    for (const Case& c : cases()) {
        const MeshHierarchy hierarchy = hierarchy_of(c);
        const int last = c.steps - 1;
        const mesh::Topology split =
            *mesh::refine(hierarchy.topology(last), hierarchy.rules(last).split);
        const mesh::Topology& faces = hierarchy.topology(c.steps);
        EXPECT_EQ(mesh::faces_of(faces), mesh::faces_of(split)) << c.name;
        EXPECT_EQ(faces.edge_count, split.edge_count) << c.name;
        EXPECT_EQ(faces.vertex_count, split.vertex_count) << c.name;
        EXPECT_EQ(faces.twin.size() + faces.edge.size(), 0U) << c.name;
    }
}

TEST(MeshHierarchy, PerfectReconstruction) {
    for (const Case& c : cases()) {
        const MeshHierarchy hierarchy = hierarchy_of(c);
        const Points points = surface(hierarchy, c.base, 0.05);
        for (const LiftKind lift : {LiftKind::None, LiftKind::Ring, LiftKind::Chebyshev})
            for (const bool local : {false, true}) {
                const MeshTransform transform{.lift = lift, .local_frames = local};
                Points coefficients = points;
                StiffResiduals residuals;
                const MeshMaps maps = *MeshMaps::create(hierarchy, transform);
                maps.analyse(coefficients.data(), residuals);
                maps.synthesise(0, c.steps, coefficients.data(), residuals);
                // Plain reversal amplifies: rounding by the largest row of A for each step.
                const double close = lift == LiftKind::None ? 1e-10 : 1e-12;
                EXPECT_LT(distance(coefficients, points), close) << c.name;
            }
    }
}

/// Pure subdivision surfaces give back their control points, and details that are zero.
TEST(MeshHierarchy, SubdivisionSurfacesHaveNoDetails) {
    for (const Case& c : cases()) {
        const MeshHierarchy hierarchy = hierarchy_of(c);
        Points points = surface(hierarchy, c.base, 0);
        StiffResiduals residuals;
        MeshMaps::create(hierarchy, {})->analyse(points.data(), residuals);
        const std::size_t base = c.base.points.size();
        for (std::size_t v = 0; v < base; ++v)
            EXPECT_LT(length(points[v] - points_of(c.base)[v]), 1e-11) << c.name;
        for (std::size_t k = base; k < points.size(); ++k)
            ASSERT_LT(length(points[k]), 1e-12) << c.name;
    }
}

/// What is shuffled is found again, and its coefficients.
TEST(MeshOrigin, ShuffledHierarchies) {
    for (const Case& c : cases()) {
        const MeshHierarchy hierarchy = hierarchy_of(c);
        const Points points = surface(hierarchy, c.base, 1e-3);
        test::Shape fine{mesh::faces_of(hierarchy.topology(c.steps)), {}};
        for (const auto& p : points) fine.points.push_back({p.x, p.y, p.z});
        const test::Shape mixed = test::shuffled(fine, 77);
        const mesh::Topology topology = mixed.topology();
        const auto found = origin_of(topology, points_of(mixed), {}, c.scheme, 30);
        ASSERT_TRUE(found.ok()) << c.name << " " << found.error().text();
        ASSERT_GE(found->steps, c.steps) << c.name;
        const auto again = MeshHierarchy::create(
            *mesh::build(mesh::faces_of(found->base), found->base.vertex_count), found->tags,
            found->spec, found->steps);
        ASSERT_TRUE(again.ok()) << c.name << " " << again.error().text();
        Points ordered(points.size());
        const mesh::Topology& finest = again->topology(found->steps);
        ASSERT_EQ(finest.half_edge_count(), topology.half_edge_count());
        for (Index h = 0; h < finest.half_edge_count(); ++h) {
            ordered[finest.origin[h]] = points_of(mixed)[topology.origin[found->half_edge(h)]];
            ASSERT_EQ(found->half_edge(finest.next(h)), topology.next(found->half_edge(h)));
        }
        // Same geometry: details are small in the way that was chosen.
        StiffResiduals residuals;
        MeshMaps::create(*again, {})->analyse(ordered.data(), residuals);
        for (std::size_t k = again->vertices(found->steps - c.steps); k < ordered.size(); ++k)
            ASSERT_LT(length(ordered[k]), 0.05) << c.name;
    }
}

/// Closed Catmull-Clark meshes may be seen as made around their vertices or around their faces.
/// Where noise is larger than what subdivision smooths, nearness can not tell, but only one of both
/// goes on.
TEST(MeshOrigin, NoiseDoesNotEndTheDescent) {
    const Case c{"quads", test::double_torus(), MeshScheme::CatmullClark, 3};
    const MeshHierarchy hierarchy = hierarchy_of(c);
    for (const unsigned seed : {1U, 2U, 3U, 4U}) {
        const Points points = noisy(surface(hierarchy, c.base, 0), seed, 0.5);
        test::Shape fine{mesh::faces_of(hierarchy.topology(c.steps)), {}};
        for (const auto& p : points) fine.points.push_back({p.x, p.y, p.z});
        const test::Shape mixed = test::shuffled(fine, seed);
        const auto found = origin_of(mixed.topology(), points_of(mixed), {}, c.scheme, 30);
        ASSERT_TRUE(found.ok());
        EXPECT_EQ(found->steps, 3);
        // Neither base goes on, so that noise may choose there; both give the same first level.
        const auto first = mesh::refine(found->base, mesh::Split::CatmullClark);
        EXPECT_EQ(first->face_count, hierarchy.topology(1).face_count);
        EXPECT_EQ(first->vertex_count, hierarchy.topology(1).vertex_count);
    }
}

/// A mesh that was made by subdivision gives back what it was made of, in its order.
TEST(MeshOrigin, OrderComesBack) {
    for (const Case& c : cases()) {
        if (c.name == "loop torus" || c.name == "quads torus") continue;  // seen in other ways, too
        const test::Shape base = test::shuffled(c.base, 5);
        const MeshHierarchy hierarchy =
            *MeshHierarchy::create(base.topology(), {}, {.scheme = c.scheme}, c.steps);
        const Points points = surface(hierarchy, base, 0);
        const auto found = origin_of(finest_of(hierarchy), points, {}, c.scheme, c.steps);
        ASSERT_TRUE(found.ok()) << c.name;
        // sqrt(3) does not tell where faces begin whose edges others have named.
        if (c.scheme != MeshScheme::Sqrt3) {
            EXPECT_EQ(mesh::faces_of(found->base), base.faces) << c.name;
        }
        EXPECT_TRUE(found->in_order()) << c.name;
    }
}

/// A mesh that is in order but for where one face begins is searched, and gives the same.
TEST(MeshOrigin, SearchedAndReadOff) {
    for (const Case& c : cases()) {
        if (c.name == "loop torus" || c.name == "quads torus") continue;  // seen in other ways, too
        const test::Shape base = test::shuffled(c.base, 5);
        const MeshHierarchy hierarchy =
            *MeshHierarchy::create(base.topology(), {}, {.scheme = c.scheme}, c.steps);
        const Points points = surface(hierarchy, base, 0);
        const mesh::Topology finest = finest_of(hierarchy);
        mesh::FaceList faces = mesh::faces_of(finest);
        const auto last = faces.corners.end() - finest.sides;
        std::rotate(last, last + 1, faces.corners.end());
        const mesh::Topology turned = *mesh::build(faces, finest.vertex_count);
        const auto read = origin_of(finest, points, {}, c.scheme, c.steps);
        const auto searched = origin_of(turned, points, {}, c.scheme, c.steps);
        ASSERT_TRUE(read.ok() && searched.ok()) << c.name;
        EXPECT_EQ(searched->steps, read->steps) << c.name;
        if (c.scheme != MeshScheme::Sqrt3) {
            EXPECT_EQ(mesh::faces_of(searched->base), mesh::faces_of(read->base)) << c.name;
        }
        const Index kept = finest.half_edge_count() - static_cast<Index>(finest.sides);
        for (Index h = 0; h < kept; ++h)
            ASSERT_EQ(searched->half_edge(h), read->half_edge(h)) << c.name << " " << h;
        for (Index h = kept; h < finest.half_edge_count(); ++h)
            ASSERT_EQ(turned.origin[searched->half_edge(h)], finest.origin[read->half_edge(h)]);
    }
}

TEST(MeshMaps, AnyNumberOfThreads) {
    const Case wide[] = {{"loop", test::grid(70, 90, true, true), MeshScheme::Loop, 2},
                         {"sqrt3", test::grid(70, 90, true), MeshScheme::Sqrt3, 2},
                         {"quads", test::grid(70, 90, false), MeshScheme::CatmullClark, 2}};
    for (const Case& c : wide) {
        const MeshHierarchy hierarchy = hierarchy_of(c);
        const Points points = noisy(Points(hierarchy.vertices(c.steps)), 2, 1);
        const MeshMaps maps = *MeshMaps::create(hierarchy, {});
        std::vector<Points> results;
        for (const int threads : {1, 2, 5}) {
            set_thread_count(threads);
            Points& result = results.emplace_back(points);
            StiffResiduals residuals;
            maps.analyse(result.data(), residuals);
        }
        set_thread_count(0);
        EXPECT_EQ(results[0], results[1]) << c.name;
        EXPECT_EQ(results[0], results[2]) << c.name;
    }
}

TEST(MeshOrigin, CreasesComeDown) {
    const test::Shape base = test::cube();
    mesh::Topology mesh = base.topology();
    MeshTags tags;
    tags.sharp.assign(mesh.edge_count, 0);
    for (Index h = 0; h < 4; ++h) tags.sharp[mesh.edge[h]] = 1;
    tags.corner.assign(8, 0);
    tags.corner[5] = 1;
    const MeshHierarchy hierarchy =
        *MeshHierarchy::create(std::move(mesh), tags, {.scheme = MeshScheme::CatmullClark}, 2);
    MeshTags fine = hierarchy.tags(2);
    const mesh::Topology& finest = hierarchy.topology(2);
    // One more, which the cube has not.
    Index extra = 0;
    while (finest.origin[extra] < hierarchy.vertices(1) ||
           finest.target(extra) < hierarchy.vertices(1))
        ++extra;
    const Index lost = finest.edge[extra];
    ASSERT_EQ(fine.sharp[lost], 0);
    fine.sharp[lost] = 1;
    const auto found = origin_of(finest, {}, fine, MeshScheme::CatmullClark, 5);
    ASSERT_TRUE(found.ok());
    EXPECT_EQ(found->lost_creases, (std::vector<Index>{lost}));
    std::size_t sharp = 0;
    for (const auto mark : found->tags.sharp) sharp += mark;
    EXPECT_EQ(sharp, 4U);
    std::size_t corners = 0;
    for (const auto mark : found->tags.corner) corners += mark;
    EXPECT_EQ(corners, 1U);
}

TEST(MeshOrigin, Refusals) {
    const test::Shape shape = test::flipped(test::icosahedron(), 20, 3);
    const mesh::Topology mesh = shape.topology();
    const auto none = origin_of(mesh, points_of(shape), {}, MeshScheme::Loop, 5);
    ASSERT_FALSE(none.ok());
    EXPECT_NE(none.error().text().find("no_subdivision_connectivity"), std::string::npos);
    EXPECT_FALSE(origin_of(mesh, points_of(shape), {}, MeshScheme::CatmullClark, 5).ok());
    const mesh::Topology fine = *mesh::refine(mesh, mesh::Split::Loop);
    EXPECT_FALSE(origin_of(fine, {}, {}, MeshScheme::Loop, 0).ok());
    EXPECT_TRUE(origin_of(fine, {}, {}, MeshScheme::Loop, 1).ok());
}

TEST(MeshFrames, ReferenceVectors) {
    const auto golden = test::reference("reverse_subdivision.json");
    for (const auto& record : golden["decompositions"]) {
        if (!record.contains("local_frames_on_plain_c")) continue;
        const test::Level level = test::level_of(record);
        const Points c = points_of(record["plain"]["c"]);
        const Points d = points_of(record["plain"]["d"]);
        const Points s = level.subdivided(c);
        const mesh::Topology fine = *mesh::refine(level.coarse, level.rules.split);
        const auto all = frames(fine, s.data(), static_cast<Index>(c.size()));
        const auto& expected = record["local_frames_on_plain_c"];
        for (std::size_t k = 0; k < 3; ++k) {
            const auto& rows = expected["first_new_vertices"][k];
            const Vec3<double> tangent{rows[0][0], rows[1][0], rows[2][0]};
            const Vec3<double> normal{rows[0][2], rows[1][2], rows[2][2]};
            EXPECT_LT(length(all[k].tangent - tangent), 1e-11) << record["name"];
            EXPECT_LT(length(all[k].normal - normal), 1e-11) << record["name"];
            const auto& local = expected["d_local"][k];
            EXPECT_LT(length(all[k].in(d[k]) - Vec3<double>{local[0], local[1], local[2]}), 1e-11);
        }
    }
}

/// A rigid motion of the coarse vertices moves the fine ones alike.
TEST(MeshFrames, RigidMotions) {
    const auto moved = [](const Vec3<double>& p) {
        // A rotation by the quaternion (1, 2, 3, 4) / sqrt(30).
        const double m[3][3] = {{4, -20, 22}, {28, 10, 4}, {-10, 20, 20}};
        return Vec3<double>{(m[0][0] * p.x + m[0][1] * p.y + m[0][2] * p.z) / 30 + 1,
                            (m[1][0] * p.x + m[1][1] * p.y + m[1][2] * p.z) / 30 - 2,
                            (m[2][0] * p.x + m[2][1] * p.y + m[2][2] * p.z) / 30 + 3};
    };
    for (const Case& c : cases()) {
        const MeshHierarchy hierarchy = hierarchy_of(c);
        const Points points = surface(hierarchy, c.base, 0.05);
        const MeshTransform transform{.local_frames = true};
        Points coefficients = points;
        StiffResiduals residuals;
        const MeshMaps maps = *MeshMaps::create(hierarchy, transform);
        maps.analyse(coefficients.data(), residuals);
        for (std::size_t v = 0; v < c.base.points.size(); ++v)
            coefficients[v] = moved(coefficients[v]);
        maps.synthesise(0, c.steps, coefficients.data(), residuals);
        for (std::size_t k = 0; k < points.size(); ++k)
            ASSERT_LT(length(coefficients[k] - moved(points[k])), 1e-10) << c.name;
    }
}

}  // namespace
}  // namespace relief::multires
