#include "codec/mesh_coarse.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "relief/codec/mesh_codec.h"
#include "shapes.h"
#include "support.h"

/// Seams and labels at coarser levels of sqrt(3) hierarchies over a plane of parallelograms: points
/// in the middle of faces and at thirds of edges keep all meshes in the plane, and every second one
/// within the triangles of those before.
namespace relief::codec {
namespace {

using mesh::Index;
using multires::MeshScheme;

constexpr Index kCells = 8;

/// Where x p.x + y p.y <= at.
struct HalfPlane {
    double x = 0;
    double y = 0;
    double at = 0;
};
/// What lies in all of them is one chart and label, what lies outside is another.
using Chart = std::vector<HalfPlane>;

/// Bounded by an edge of the grid across all of it.
const Chart kHalf = {{1, 0, 3}};
/// By edges of the grid and by those of the mesh after an odd number of steps, away from the
/// boundary: there, faces after odd steps are not parts of parallelograms, and points beside them
/// not in place.
const Chart kSquare = {{1, 0, 6}, {-1, 0, -2}, {0, 1, 6}, {0, -1, -2}};
const Chart kHexagon = {{1, -2, -1}, {-1, 2, 7}, {2, -1, 7}, {-2, 1, -1}, {1, 1, 11}, {-1, -1, -5}};

struct Plane {
    MeshHierarchy hierarchy;
    std::vector<Vec3<double>> points;
};

/// Means and thirds in place of the smooth rules.
void subdivide(Plane& plane) {
    for (int step = 0; step < plane.hierarchy.steps(); ++step) {
        const mesh::Topology& mesh = plane.hierarchy.topology(step);
        const multires::StepRules& rules = plane.hierarchy.rules(step);
        plane.points.resize(plane.hierarchy.vertices(step + 1));
        const auto& c = plane.points;
        for (Index f = 0; f < mesh.face_count; ++f) {
            const auto v = mesh.corners(f);
            plane.points[rules.face_points[f]] = 1.0 / 3 * (c[v[0]] + c[v[1]] + c[v[2]]);
        }
        for (const multires::Trisection& third : rules.trisections) {
            Vec3<double>* p = plane.points.data() + mesh.vertex_count + third.point;
            p[0] = 1.0 / 3 * (2.0 * c[third.from] + c[third.to]);
            p[1] = 1.0 / 3 * (c[third.from] + 2.0 * c[third.to]);
        }
    }
}

Plane grid_plane(int steps) {
    const test::Shape base = test::grid(kCells, kCells, true);
    Plane plane{*MeshHierarchy::create(base.topology(), {}, {.scheme = MeshScheme::Sqrt3}, steps),
                {}};
    for (const auto& p : base.points) plane.points.push_back({p[0], p[1], 0});
    subdivide(plane);
    return plane;
}

/// From the mesh after one step on: the first step of the rest is an even one.
Plane even_plane(int steps) {
    const Plane first = grid_plane(1);
    const mesh::Topology& base = first.hierarchy.topology(1);
    Plane plane{*MeshHierarchy::create(*mesh::build(mesh::faces_of(base), base.vertex_count), {},
                                       {.scheme = MeshScheme::Sqrt3, .first_even = true}, steps),
                first.points};
    subdivide(plane);
    return plane;
}

/// Thirds of thirds are rounded a few times; faces are far larger.
constexpr double kClose = 1e-9;

PolygonMesh faces_at(const Plane& plane, int depth) {
    PolygonMesh mesh;
    for (std::size_t v = 0; v < plane.hierarchy.vertices(depth); ++v)
        mesh.vertices.push_back({plane.points[v].x, plane.points[v].y, 0});
    const mesh::FaceList faces = mesh::faces_of(plane.hierarchy.topology(depth));
    mesh.offsets = faces.offsets;
    mesh.corners.assign(faces.corners.begin(), faces.corners.end());
    return mesh;
}

/// How far the corners of a face are outside a chart; negative: inside.
struct Reach {
    double least = HUGE_VAL;
    double most = -HUGE_VAL;

    [[nodiscard]] bool is_crossed() const { return least < -kClose && most > kClose; }
    [[nodiscard]] bool is_outside() const { return most > kClose; }
};
Reach reach_of(const PolygonMesh& mesh, std::int64_t f, const Chart& chart) {
    Reach reach;
    for (const std::int32_t v : mesh.polygon(f)) {
        const auto& p = mesh.vertices[static_cast<std::size_t>(v)];
        double off = -HUGE_VAL;
        for (const HalfPlane& half : chart)
            off = std::max(off, half.x * p[0] + half.y * p[1] - half.at);
        reach.least = std::min(reach.least, off);
        reach.most = std::max(reach.most, off);
    }
    return reach;
}

/// Texture places: that of the vertex, moved by 100 in the chart outside.
std::array<double, 2> place_in(const PolygonMesh& mesh, std::int32_t v, bool outside) {
    const auto& p = mesh.vertices[static_cast<std::size_t>(v)];
    return {p[0] + (outside ? 100 : 0), p[1]};
}

void add_charts(PolygonMesh& mesh, const Chart& chart) {
    MeshAttribute uv{"uv", 2, SampleType::Float64, {}, {}};
    FaceLabels labels{"g", {"inside", "outside"}, {}};
    std::map<std::pair<std::int32_t, bool>, std::int32_t> elements;
    for (std::int64_t f = 0; f < mesh.polygon_count(); ++f) {
        const Reach reach = reach_of(mesh, f, chart);
        ASSERT_FALSE(reach.is_crossed());
        labels.of_face.push_back(reach.is_outside());
        for (const std::int32_t v : mesh.polygon(f)) {
            const auto [at, is_new] = elements.try_emplace(
                {v, reach.is_outside()}, static_cast<std::int32_t>(elements.size()));
            const auto place = place_in(mesh, v, reach.is_outside());
            if (is_new) uv.values.insert(uv.values.end(), place.begin(), place.end());
            uv.corners.push_back(at->second);
        }
    }
    mesh.attributes = {uv};
    mesh.labels = {labels};
}

/// Every corner has its place in the chart of its face; faces across the seam have none.
void expect_charts(const PolygonMesh& mesh, const Chart& chart, bool may_cross) {
    const MeshAttribute& uv = *mesh.attribute("uv");
    ASSERT_EQ(uv.corners.size(), mesh.corners.size());
    for (std::int64_t f = 0; f < mesh.polygon_count(); ++f) {
        const Reach reach = reach_of(mesh, f, chart);
        ASSERT_TRUE(may_cross || !reach.is_crossed());
        if (!reach.is_crossed()) {
            EXPECT_EQ(mesh.labels[0].of_face[static_cast<std::size_t>(f)], reach.is_outside());
        }
        for (std::int64_t c = 3 * f; c < 3 * f + 3; ++c) {
            const auto corner = static_cast<std::size_t>(c);
            const std::int32_t element = uv.corners[corner];
            ASSERT_EQ(element < 0, reach.is_crossed()) << "face " << f;
            if (element < 0) continue;
            const auto place = place_in(mesh, mesh.corners[corner], reach.is_outside());
            EXPECT_EQ(uv.element(element)[0], place[0]) << "face " << f;
            EXPECT_EQ(uv.element(element)[1], place[1]) << "face " << f;
        }
    }
}

void expect_charts_at_all_levels(const Plane& plane, const Chart& chart) {
    const int steps = plane.hierarchy.steps();
    PolygonMesh finest = faces_at(plane, steps);
    ASSERT_NO_FATAL_FAILURE(add_charts(finest, chart));
    const MeshOrder order = same_order(plane.hierarchy.topology(steps));
    for (int depth = 0; depth < steps; ++depth) {
        SCOPED_TRACE("depth " + std::to_string(depth));
        PolygonMesh coarse = faces_at(plane, depth);
        take_coarse_extras(finest, order, plane.hierarchy, depth, coarse);
        expect_charts(coarse, chart, (steps - depth) % 2 != 0);
    }
}

/// Edges on the boundary are trisected by the second or by the first of two steps.
TEST(MeshCoarse, Sqrt3SeamsAlongEdgesOfTheBase) {
    expect_charts_at_all_levels(grid_plane(4), kHalf);
    expect_charts_at_all_levels(grid_plane(4), kSquare);
    expect_charts_at_all_levels(even_plane(4), kHexagon);
}

/// An odd number of levels: the base has faces across the seam.
TEST(MeshCoarse, Sqrt3SeamsAcrossTheBase) {
    expect_charts_at_all_levels(grid_plane(3), kHexagon);
    expect_charts_at_all_levels(even_plane(3), kSquare);
}

/// Through a file, shuffled: the finest level is exact, coarser ones have the charts of their
/// faces.
TEST(MeshCoarse, Sqrt3SeamsInFiles) {
    const Plane plane = grid_plane(4);
    const PolygonMesh plain = faces_at(plane, 4);
    test::Shape shape;
    for (const auto& v : plain.vertices) shape.points.push_back({v[0], v[1], v[2]});
    for (std::int64_t f = 0; f < plain.polygon_count(); ++f)
        shape.faces.add(std::vector<Index>(plain.polygon(f).begin(), plain.polygon(f).end()));
    for (const unsigned seed : {0U, 8U}) {
        const test::Shape mixed = seed ? test::shuffled(shape, seed) : shape;
        PolygonMesh finest;
        finest.vertices = mixed.points;
        finest.offsets = mixed.faces.offsets;
        finest.corners.assign(mixed.faces.corners.begin(), mixed.faces.corners.end());
        ASSERT_NO_FATAL_FAILURE(add_charts(finest, kHalf));
        MeshEncodeOptions options;
        options.scheme = MeshScheme::Sqrt3;
        const auto encoded = encode_mesh(finest, options);
        ASSERT_TRUE(encoded.ok()) << encoded.error().text();
        const MeshFile file = *MeshFile::open(encoded->bytes);
        ASSERT_EQ(file.levels(), 4);
        EXPECT_EQ(*file.decode(0), finest);
        for (int level = 1; level <= 4; ++level) {
            PolygonMesh coarse = *file.decode(level);
            const MeshAttribute& uv = *coarse.attribute("uv");
            const bool even = level % 2 == 0;
            for (std::int64_t f = 0; f < coarse.polygon_count(); ++f) {
                const std::int32_t label = coarse.labels[0].of_face[static_cast<std::size_t>(f)];
                for (std::size_t c = static_cast<std::size_t>(3 * f), k = 0; k < 3; ++c, ++k) {
                    EXPECT_TRUE(!even || uv.corners[c] >= 0);
                    if (uv.corners[c] < 0) continue;
                    // All three corners in the chart that the label names.
                    EXPECT_EQ(uv.element(uv.corners[c])[0] > 50, label == 1);
                }
            }
        }
    }
}

}  // namespace
}  // namespace relief::codec
