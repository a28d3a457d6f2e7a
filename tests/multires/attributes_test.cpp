#include "relief/multires/attributes.h"

#include <gtest/gtest.h>

#include "shapes.h"

namespace relief::multires {
namespace {

using mesh::Index;
using mesh::Split;

/// An element for each vertex: no seams.
CornerValues joined(const mesh::Topology& mesh, const std::vector<double>& values) {
    CornerValues corners{1, values, {}};
    for (Index h = 0; h < mesh.half_edge_count(); ++h)
        corners.of_corner.push_back(static_cast<std::int32_t>(mesh.origin[h]));
    return corners;
}

struct Family {
    test::Shape shape;
    Split split;
};
std::vector<Family> families() {
    return {{test::grid(4, 3, true), Split::Loop},
            {test::flipped(test::icosahedron(), 20, 1), Split::Loop},
            {test::grid(4, 3, false), Split::CatmullClark},
            {test::double_torus(), Split::CatmullClark},
            {test::tetrahedron(), Split::CatmullClark}};
}

/// Without seams there is one element a vertex, and its value is that of midpoints and centres.
TEST(Attributes, JoinedCornersStayJoined) {
    for (const auto& [shape, split] : families()) {
        const mesh::Topology mesh = shape.topology();
        std::vector<double> x;
        for (const auto& p : shape.points) x.push_back(p[0]);
        const CornerValues fine = subdivided(mesh, split, joined(mesh, x));
        const mesh::Topology refined = *mesh::refine(mesh, split);
        ASSERT_EQ(fine.of_corner.size(), refined.half_edge_count());
        EXPECT_EQ(fine.values.size(), refined.vertex_count);
        std::vector<double> at(refined.vertex_count);
        for (Index v = 0; v < mesh.vertex_count; ++v) at[v] = x[v];
        for (Index h = 0; h < mesh.half_edge_count(); ++h)
            at[mesh.vertex_count + mesh.edge[h]] = (x[mesh.origin[h]] + x[mesh.target(h)]) / 2;
        for (Index f = 0; split == Split::CatmullClark && f < mesh.face_count; ++f) {
            double sum = 0;
            for (const Index v : mesh.corners(f)) sum += x[v];
            at[mesh.vertex_count + mesh.edge_count + f] = sum / mesh.size_of(f);
        }
        for (Index h = 0; h < refined.half_edge_count(); ++h)
            EXPECT_DOUBLE_EQ(fine.values[static_cast<std::size_t>(fine.of_corner[h])],
                             at[refined.origin[h]]);
    }
}

/// Faces that are joined to no other stay apart, those without elements have none.
TEST(Attributes, SeamsStay) {
    for (const auto& [shape, split] : families()) {
        const mesh::Topology mesh = shape.topology();
        CornerValues corners{2, {}, {}};
        for (Index h = 0; h < mesh.half_edge_count(); ++h) {
            const bool none = mesh.face_of(h) == 1;
            corners.of_corner.push_back(
                none ? -1 : static_cast<std::int32_t>(corners.values.size() / 2));
            if (!none) corners.values.insert(corners.values.end(), {double(mesh.face_of(h)), 1});
        }
        std::vector<std::int32_t> names;
        for (Index f = 0; f < mesh.face_count; ++f) names.push_back(static_cast<std::int32_t>(f));
        const CornerValues fine = subdivided(mesh, split, corners);
        const auto labels = subdivided_labels(mesh, split, names);
        const mesh::Topology refined = *mesh::refine(mesh, split);
        ASSERT_EQ(labels.size(), refined.face_count);
        for (Index h = 0; h < refined.half_edge_count(); ++h) {
            const std::int32_t label = labels[refined.face_of(h)];
            const std::int32_t element = fine.of_corner[h];
            ASSERT_EQ(element == -1, label == 1);
            if (element == -1) continue;
            EXPECT_EQ(fine.values[2 * static_cast<std::size_t>(element)], label);
            EXPECT_EQ(fine.values[2 * static_cast<std::size_t>(element) + 1], 1);
        }
    }
}

}  // namespace
}  // namespace relief::multires
