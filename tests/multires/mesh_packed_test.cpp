#include "relief/multires/mesh_packed.h"

#include <gtest/gtest.h>

#include "multires/mesh_support.h"
#include "relief/multires/mesh_hierarchy.h"

namespace relief::multires {
namespace {

using mesh::Split;
using test::distance;
using test::Level;
using test::noisy;
using test::Points;
using test::points_of;

TEST(MeshPacked, ReferenceVectors) {
    const auto golden = test::reference("reverse_subdivision.json");
    int packed = 0;
    for (const auto& record : golden["decompositions"]) {
        if (!record.contains("explicit") || !record.contains("plain")) continue;
        const Level level = test::level_of(record);
        const Points g = points_of(record["g"]);
        auto [fine, residuals] = level.analysed(g);
        const auto coarse = static_cast<long>(level.coarse.vertex_count);
        pack_residuals(level.step(), residuals.data(), fine.data() + coarse);
        EXPECT_LT(
            distance(Points(fine.begin() + coarse, fine.end()), points_of(record["plain"]["d"])),
            10 * golden["tolerances"]["plain"].get<double>())
            << record["name"];
        ++packed;
    }
    EXPECT_EQ(packed, 1);
}

/// What comes out is what went in; tolerance: rounding, weights are at most 4.
TEST(MeshPacked, RoundTrips) {
    for (const auto& [name, level] : test::all_levels()) {
        if (!check_packed(level.rules).ok()) continue;
        const std::size_t coarse = level.coarse.vertex_count;
        const Points g = noisy(Points(coarse + level.rules.new_count), 4, 1);
        const auto [fine, residuals] = level.analysed(g);
        Points details(fine.begin() + static_cast<long>(coarse), fine.end());
        const Points before = details;
        pack_residuals(level.step(), residuals.data(), details.data());
        Points found(residuals.size());
        unpack_residuals(level.step(), details.data(), found.data());
        EXPECT_LT(distance(details, before), 1e-13) << name;
        EXPECT_LT(distance(found, residuals), 1e-13) << name;
    }
}

/// In every mode as many numbers as the mesh has, and the mesh again.
TEST(MeshPacked, Hierarchies) {
    const test::Shape shapes[] = {test::double_torus(),
                                  test::voxels({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}),
                                  test::voxels({{0, 0, 0}, {1, 0, 0}}),
                                  test::both(test::tetrahedron(), test::grid(3, 2, false))};
    for (const test::Shape& shape : shapes) {
        mesh::Topology base = shape.topology();
        const MeshTags tags = test::some_tags(base, 3);
        const MeshHierarchy hierarchy =
            *MeshHierarchy::create(std::move(base), tags, {.scheme = MeshScheme::CatmullClark}, 2);
        const Points g = noisy(Points(hierarchy.vertices(2)), 2, 1);
        for (const LiftKind lift : {LiftKind::None, LiftKind::Chebyshev})
            for (const bool local : {false, true}) {
                const MeshTransform transform{.lift = lift, .local_frames = local, .packed = true};
                const MeshMaps maps = *MeshMaps::create(hierarchy, transform);
                Points points = g;
                StiffResiduals residuals;
                maps.analyse(points.data(), residuals);
                for (const Points& of_step : residuals) EXPECT_TRUE(of_step.empty());
                maps.synthesise(0, 2, points.data(), residuals);
                EXPECT_LT(distance(points, g), 1e-11);  // plain reversal amplifies rounding
            }
    }
}

TEST(MeshPacked, NotReversible) {
    const test::Shape prism = [] {
        test::Shape shape;
        std::vector<mesh::Index> top, bottom;
        for (mesh::Index k = 0; k < 6; ++k) {
            const double angle = M_PI * k / 3;
            shape.points.push_back({std::cos(angle), std::sin(angle), 0});
            shape.points.push_back({std::cos(angle), std::sin(angle), 1});
            shape.add({2 * k, 2 * ((k + 1) % 6), 2 * ((k + 1) % 6) + 1, 2 * k + 1});
            top.push_back(2 * k + 1);
            bottom.insert(bottom.begin(), 2 * k);
        }
        shape.faces.add(top);
        shape.faces.add(bottom);
        return shape;
    }();
    for (const test::Shape& shape : {test::cube(), prism}) {
        const Level level(shape.topology(), {}, Split::CatmullClark);
        const Status status = check_packed(level.rules);
        ASSERT_FALSE(status.ok());
        EXPECT_EQ(status.error().message.rfind("not_reversible: ", 0), 0U);
        EXPECT_EQ(status.error().where, "component of vertex 0");
        const auto hierarchy =
            *MeshHierarchy::create(shape.topology(), {}, {.scheme = MeshScheme::CatmullClark}, 2);
        EXPECT_FALSE(MeshMaps::create(hierarchy, {.packed = true}).ok());
        EXPECT_TRUE(MeshMaps::create(hierarchy, {}).ok());
        // One level less, all is well.
        EXPECT_TRUE(check_packed(hierarchy.rules(1)).ok());
    }
}

}  // namespace
}  // namespace relief::multires
