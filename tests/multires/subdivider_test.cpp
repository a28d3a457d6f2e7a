#include "relief/multires/subdivider.h"

#include <gtest/gtest.h>

#include "multires/mesh_support.h"

namespace relief::multires {
namespace {

using mesh::Index;
using mesh::Topology;
using test::Points;
using test::points_of;

template <class T>
struct Finest {
    std::vector<Index> corners;
    std::vector<Vec3<T>> points;

    friend bool operator==(const Finest&, const Finest&) = default;
};

template <class T>
Finest<T> finest_of(Subdivider& subdivider, const std::vector<Vec3<T>>& base) {
    Finest<T> finest{std::vector<Index>(subdivider.counts().half_edges),
                     std::vector<Vec3<T>>(subdivider.counts().vertices)};
    subdivider.faces(finest.corners);
    subdivider.points<T>(base, finest.points);
    return finest;
}

std::vector<Index> vector_of(const Buffer<Index>& buffer) {
    return {buffer.data(), buffer.data() + buffer.size()};
}

Sharpness for_ever(const MeshTags& tags) {
    Sharpness sharpness;
    for (const auto sharp : tags.sharp) sharpness.edges.push_back(sharp ? HUGE_VAL : 0);
    for (const auto corner : tags.corner) sharpness.vertices.push_back(corner ? HUGE_VAL : 0);
    return sharpness;
}

/// The steps of the transform have the same rules in another form, without details.
void expect_same_as_steps(const test::Shape& shape, const MeshSpec& spec, const MeshTags& tags,
                          int steps) {
    SCOPED_TRACE(std::string(mesh_scheme_name(spec.scheme)) + ", " + std::to_string(shape.size()) +
                 " vertices, " + std::to_string(steps) + " steps");
    const auto hierarchy = MeshHierarchy::create(shape.topology(), tags, spec, steps);
    ASSERT_TRUE(hierarchy.ok()) << hierarchy.error().text();
    Points expected = points_of(shape);
    for (int step = 0; step < steps; ++step) {
        Points fine(hierarchy->vertices(step + 1));
        hierarchy->step(step).apply(expected.data(), fine.data(), fine.data() + expected.size());
        expected = std::move(fine);
    }
    const Topology base = shape.topology();
    Subdivider subdivider;
    ASSERT_TRUE(subdivider.prepare(base, for_ever(tags), spec, steps).ok());
    const auto finest = finest_of(subdivider, points_of(shape));
    const Topology& faces = hierarchy->topology(steps);
    const Topology mesh = *mesh::build(mesh::faces_of(faces), faces.vertex_count);
    EXPECT_EQ(finest.corners, vector_of(mesh.origin));
    // Some roundings of coordinates up to 8.
    EXPECT_LT(test::distance(finest.points, expected), 2e-14);
    const Topology again = *subdivider.finest();
    EXPECT_EQ(vector_of(again.origin), vector_of(mesh.origin));
    EXPECT_EQ(vector_of(again.twin), vector_of(mesh.twin));
    EXPECT_EQ(vector_of(again.edge), vector_of(mesh.edge));
    EXPECT_EQ(subdivider.sharpness(again), for_ever(hierarchy->tags(steps)));
}

const std::vector<test::Shape>& triangle_shapes() {
    static const std::vector<test::Shape> shapes = {
        test::tetrahedron(),
        test::flipped(test::icosahedron(), 60, 5),
        test::triangulated(test::double_torus()),
        test::flipped(test::grid(4, 3, true), 20, 2),
        test::without_faces(test::grid(5, 5, true, true), {7, 8, 30}),
        test::both(test::octahedron(), test::grid(1, 1, true))};
    return shapes;
}

TEST(Subdivider, SameAsTheStepsOfTheTransform) {
    for (const test::Shape& shape : triangle_shapes())
        for (const int steps : {1, 2, 4}) {
            expect_same_as_steps(shape, {.scheme = MeshScheme::Loop}, {}, steps);
            expect_same_as_steps(shape, {.scheme = MeshScheme::Sqrt3}, {}, steps);
            expect_same_as_steps(shape, {.scheme = MeshScheme::Sqrt3, .alpha = 0.2}, {}, steps);
            expect_same_as_steps(shape, {.scheme = MeshScheme::Sqrt3, .alpha = 0.0}, {}, steps);
        }
    for (const test::Shape& shape :
         {test::cube(), test::double_torus(), test::grid(4, 3, false), test::icosahedron(),
          test::grid(3, 3, true), test::both(test::tetrahedron(), test::double_torus())})
        for (const int steps : {1, 3})
            expect_same_as_steps(shape, {.scheme = MeshScheme::CatmullClark}, {}, steps);
}

TEST(Subdivider, SharpFeatures) {
    for (const test::Shape& shape : triangle_shapes()) {
        const MeshTags tags = test::some_tags(shape.topology(), 7);
        expect_same_as_steps(shape, {.scheme = MeshScheme::Loop}, tags, 3);
        expect_same_as_steps(shape, {.scheme = MeshScheme::CatmullClark}, tags, 2);
        MeshTags corners;
        tag_boundary_corners(shape.topology(), corners);
        expect_same_as_steps(shape, {.scheme = MeshScheme::Loop}, corners, 2);
        expect_same_as_steps(shape, {.scheme = MeshScheme::Sqrt3}, corners, 4);
    }
    const test::Shape quads = test::grid(5, 4, false);
    const MeshTags tags = test::some_tags(quads.topology(), 3);
    expect_same_as_steps(quads, {.scheme = MeshScheme::CatmullClark}, tags, 3);
}

/// A base whose first step is an even one: apexes of its boundary faces get further edges.
TEST(Subdivider, EvenStepFirst) {
    const MeshSpec even{.scheme = MeshScheme::Sqrt3, .first_even = true};
    const test::Shape odd = test::flipped(test::grid(4, 4, true), 30, 9);
    const Topology mesh = *mesh::refine(odd.topology(), mesh::Split::Sqrt3Odd);
    test::Shape shape{mesh::faces_of(mesh), {}};
    test::Noise noise(4);
    for (Index v = 0; v < mesh.vertex_count; ++v)
        shape.points.push_back({noise(), noise(), noise()});
    for (const int steps : {1, 2, 3}) expect_same_as_steps(shape, even, {}, steps);
    // Vertices of the base can be apexes too.
    test::Shape fan{{}, {{0, 0, 0}, {2, 0, 1}, {0, 2, 0}, {-2, 0, 1}, {0, -2, 0}}};
    for (const auto& f : {std::array<Index, 3>{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}})
        fan.faces.add(f);
    for (const int steps : {1, 2, 3}) expect_same_as_steps(fan, even, {}, steps);
}

/// Memory of earlier calls does not show.
TEST(Subdivider, KeptMemory) {
    const std::vector<test::Shape> shapes = {test::double_torus(), test::grid(3, 3, false),
                                             test::both(test::icosahedron(), test::cube())};
    Subdivider kept;
    for (int round = 0; round < 2; ++round)
        for (const test::Shape& shape : shapes)
            for (const int steps : {3, 1, 2}) {
                const Topology base = shape.topology();
                const MeshSpec spec{.scheme = MeshScheme::CatmullClark};
                Sharpness sharpness;
                sharpness.edges.assign(base.edge_count, 0);
                sharpness.edges[2] = 1.5;
                Subdivider fresh;
                ASSERT_TRUE(kept.prepare(base, sharpness, spec, steps).ok());
                ASSERT_TRUE(fresh.prepare(base, sharpness, spec, steps).ok());
                EXPECT_EQ(finest_of(kept, points_of(shape)), finest_of(fresh, points_of(shape)));
                EXPECT_EQ(kept.sharpness(*kept.finest()), fresh.sharpness(*fresh.finest()));
            }
}

/// `subdivide` is the same, and floats are doubles to their precision.
TEST(Subdivider, SameAsSubdivide) {
    const test::Shape shape = test::flipped(test::grid(4, 4, true), 30, 9);
    for (const MeshScheme scheme :
         {MeshScheme::Loop, MeshScheme::CatmullClark, MeshScheme::Sqrt3}) {
        const Topology base = shape.topology();
        Sharpness sharpness;
        sharpness.vertices.assign(shape.size(), 0);
        sharpness.vertices[7] = 1.25;
        Subdivider subdivider;
        ASSERT_TRUE(subdivider.prepare(base, sharpness, {.scheme = scheme}, 3).ok());
        const auto finest = finest_of(subdivider, points_of(shape));
        std::vector<Vec3<float>> singles;
        for (const auto& p : points_of(shape))
            singles.push_back({float(p.x), float(p.y), float(p.z)});
        const auto rounded = finest_of(subdivider, singles);
        const auto subdivided =
            *subdivide(SubdividedMesh<double>{shape.topology(), {points_of(shape)}, sharpness},
                       {.scheme = scheme}, 3);
        EXPECT_EQ(finest.points, subdivided.arrays[0]);
        EXPECT_EQ(finest.corners, vector_of(subdivided.mesh.origin));
        for (std::size_t v = 0; v < finest.points.size(); ++v) {
            const auto& p = rounded.points[v];
            EXPECT_LT(length(finest.points[v] - Vec3<double>{p.x, p.y, p.z}), 4e-6);
        }
    }
}

TEST(Subdivider, Refusals) {
    const Topology base = test::icosahedron().topology();
    const auto error = [&](const MeshSpec& spec, int steps, const Sharpness& sharpness = {}) {
        const Status status = Subdivider().prepare(base, sharpness, spec, steps);
        return status.ok() ? std::string() : status.error().text();
    };
    EXPECT_NE(error({}, 0).find("steps: invalid_parameter"), std::string::npos);
    EXPECT_NE(error({.scheme = MeshScheme::Sqrt3, .alpha = 0.7}, 1).find("alpha"),
              std::string::npos);
    EXPECT_NE(error({}, 15).find("too_many_elements"), std::string::npos);
    EXPECT_NE(error({}, 1, {{1, 2}, {}}).find("sharpness"), std::string::npos);
    const Topology quads = test::cube().topology();
    EXPECT_NE(Subdivider().prepare(quads, {}, {}, 1).error().text().find("not_triangles"),
              std::string::npos);
    const Topology square = test::grid(1, 1, true).topology();
    const MeshSpec even{.scheme = MeshScheme::Sqrt3, .first_even = true};
    EXPECT_NE(Subdivider().prepare(square, {}, even, 1).error().text().find("sqrt3_parity"),
              std::string::npos);
}

}  // namespace
}  // namespace relief::multires
