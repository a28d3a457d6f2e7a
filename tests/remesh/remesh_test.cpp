#include "relief/remesh/remesh.h"

#include <fstream>
#include <sstream>

#include "meshes.h"
#include "relief/core/parallel.h"
#include "relief/mesh/closest.h"
#include "relief/multires/mesh_hierarchy.h"

namespace relief::remesh {

namespace {

using mesh::Index;
using test::Shape;

Remeshed remeshed(const PolygonMesh& mesh, const RemeshOptions& options = {}) {
    auto result = remesh(mesh, options);
    if (!result.ok()) throw std::runtime_error(result.error().text());
    return *std::move(result);
}

mesh::Topology topology_of(const PolygonMesh& mesh) {
    auto built =
        mesh::build(mesh.offsets, std::vector<Index>(mesh.corners.begin(), mesh.corners.end()),
                    static_cast<Index>(mesh.vertices.size()));
    if (!built.ok()) throw std::runtime_error(built.error().text());
    return *std::move(built);
}

/// The result is a subdivision of its base, in the order of one, of the same topology.
void expect_subdivision(const PolygonMesh& mesh, const Remeshed& result) {
    const mesh::Topology fine = topology_of(result.mesh);
    std::vector<Vec3<double>> points;
    for (const auto& v : result.mesh.vertices) points.push_back({v[0], v[1], v[2]});
    const auto origin =
        multires::origin_of(fine, points, {}, multires::MeshScheme::Loop, result.levels);
    ASSERT_TRUE(origin.ok()) << origin.error().text();
    EXPECT_EQ(origin->steps, result.levels);
    EXPECT_TRUE(origin->in_order());
    EXPECT_EQ(origin->base.face_count, result.base.polygon_count());
    EXPECT_EQ(mesh::euler_characteristic(fine), mesh::euler_characteristic(topology_of(mesh)));
    EXPECT_EQ(mesh::components(fine).count, mesh::components(topology_of(mesh)).count);
    EXPECT_TRUE(check(result.mesh).ok());
}

/// The report says what another measurement finds.
void expect_report(const PolygonMesh& mesh, const Remeshed& result, double rms, double most) {
    const auto distance = mesh::surface_distance(mesh, result.mesh);
    ASSERT_TRUE(distance.ok());
    const RemeshReport& report = result.report;
    EXPECT_NEAR(report.rms_error, distance->rms(), 1e-3 * report.rms_error + 1e-12);
    EXPECT_NEAR(report.max_error, distance->largest(), 1e-3 * report.max_error + 1e-12);
    EXPECT_LT(report.rms_error, rms * report.diagonal);
    EXPECT_LE(report.max_error, most * report.diagonal);
    EXPECT_EQ(report.flips, 0);
    EXPECT_GT(report.quality, 0.4);
}

TEST(Remesh, ClosedSurfacesOfAnyGenus) {
    const PolygonMesh sphere = test::polygons_of(test::bumpy_sphere(5, 0.2));
    const Remeshed round = remeshed(sphere);
    expect_subdivision(sphere, round);
    expect_report(sphere, round, 5e-4, 2e-3);
    const PolygonMesh torus = test::polygons_of(test::grid(100, 60, true, true));
    const Remeshed ring = remeshed(torus);
    expect_subdivision(torus, ring);
    expect_report(torus, ring, 5e-4, 2e-3);
}

TEST(Remesh, BoundariesStayWhereTheyAre) {
    const PolygonMesh tube = test::polygons_of(test::tube(96, 48, 3));
    const Remeshed result = remeshed(tube);
    expect_subdivision(tube, result);
    expect_report(tube, result, 5e-4, 2e-3);
    const mesh::Topology fine = topology_of(result.mesh);
    for (Index h = 0; h < fine.half_edge_count(); ++h) {
        if (!fine.on_boundary(h)) continue;
        const double z = result.mesh.vertices[fine.origin[h]][2];
        EXPECT_NEAR(std::min(std::abs(z), std::abs(z - 3)), 0, 1e-12);
    }
}

TEST(Remesh, FeaturesBecomeCreases) {
    std::set<test::Cell> cells;
    for (int x = 0; x < 10; ++x)
        for (int y = 0; y < 10; ++y)
            for (int z = 0; z < 6; ++z) cells.insert({x, y, z});
    const PolygonMesh box = test::polygons_of(test::voxels(cells));
    const Remeshed result = remeshed(box, {.base_faces = 40, .levels = 2, .feature_degrees = 40.0});
    EXPECT_EQ(result.mesh.sharp_vertices.size(), 8U);
    EXPECT_FALSE(result.mesh.creases.empty());
    EXPECT_LT(result.report.max_error, 1e-9);  // planes, and edges along the edges of the box
    const auto on_edge = [](const std::array<double, 3>& p) {
        int faces = 0;
        const std::array<double, 3> most = {10, 10, 6};
        for (std::size_t k = 0; k < 3; ++k)
            faces += std::min(std::abs(p[k]), std::abs(p[k] - most[k])) < 1e-9;
        return faces >= 2;
    };
    double length_of_creases = 0;
    for (const CreaseEdge& crease : result.mesh.creases) {
        const auto& a = result.mesh.vertices[static_cast<std::size_t>(crease.a)];
        const auto& b = result.mesh.vertices[static_cast<std::size_t>(crease.b)];
        EXPECT_TRUE(on_edge(a) && on_edge(b));
        EXPECT_TRUE(std::isinf(crease.sharpness));
        length_of_creases += std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    }
    EXPECT_NEAR(length_of_creases, 8 * 10 + 4 * 6, 1e-9);
}

TEST(Remesh, ComponentsStayApart) {
    Shape two = test::bumpy_sphere(4, 0.2);
    const Shape torus = test::grid(40, 30, true, true);
    const Index first = two.size();
    for (const auto& p : torus.points) two.points.push_back({p[0] + 6, p[1], p[2]});
    for (std::size_t f = 0; f < torus.faces.size(); ++f) {
        const auto c = torus.faces[f];
        two.add({c[0] + first, c[1] + first, c[2] + first});
    }
    const PolygonMesh mesh = test::polygons_of(two);
    const Remeshed result = remeshed(mesh, {.tolerance = 5e-3});
    expect_subdivision(mesh, result);
    expect_report(mesh, result, 2e-3, 5e-3);
}

TEST(Remesh, AttributesAreThoseOfTheSurface) {
    PolygonMesh sphere = test::polygons_of(test::bumpy_sphere(5, 0.1));
    MeshAttribute colour{"colour", 3, SampleType::Float64, {}, {}};
    MeshAttribute uv{"uv", 2, SampleType::Float64, {}, {}};
    for (const auto& v : sphere.vertices)
        colour.values.insert(colour.values.end(), {v[0] / 4 + 0.5, v[1] / 4 + 0.5, v[2] / 4 + 0.5});
    // Two charts, above and below: there are two elements for each vertex.
    for (const double side : {0.0, 10.0})
        for (const auto& v : sphere.vertices)
            uv.values.insert(uv.values.end(), {side + v[0], v[1]});
    FaceLabels material{"usemtl", {"below", "above"}, {}};
    for (std::int64_t f = 0; f < sphere.polygon_count(); ++f) {
        double z = 0;
        for (const auto c : sphere.polygon(f)) z += sphere.vertices[static_cast<std::size_t>(c)][2];
        material.of_face.push_back(z > 0);
        for (const auto c : sphere.polygon(f))
            uv.corners.push_back(c +
                                 (z > 0 ? static_cast<std::int32_t>(sphere.vertices.size()) : 0));
    }
    sphere.attributes = {colour, uv};
    sphere.labels = {material};
    const PolygonMesh result = remeshed(sphere).mesh;
    ASSERT_TRUE(check(result).ok());
    const MeshAttribute& colours = *result.attribute("colour");
    // Vertices are off the surface by less than the largest distance, which is below 0.01.
    for (std::size_t v = 0; v < result.vertices.size(); ++v)
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_NEAR(4 * (colours.values[3 * v + k] - 0.5), result.vertices[v][k], 0.01);
    const MeshAttribute& places = *result.attribute("uv");
    for (std::int64_t f = 0; f < result.polygon_count(); ++f) {
        const double side = result.labels[0].of_face[static_cast<std::size_t>(f)] == 1 ? 10 : 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto corner = static_cast<std::size_t>(3 * f) + k;
            const double* element = places.element(places.corners[corner]);
            const auto& p = result.vertices[static_cast<std::size_t>(result.corners[corner])];
            // A face across the seam has values from its own side, as far as that goes.
            EXPECT_NEAR(element[0] - side, p[0], 0.15);
            EXPECT_NEAR(element[1], p[1], 0.15);
        }
    }
}

TEST(Remesh, AnyNumberOfThreadsGivesTheSame) {
    const PolygonMesh mesh = test::polygons_of(test::grid(80, 50, true, true));
    set_thread_count(1);
    const PolygonMesh one = remeshed(mesh).mesh;
    set_thread_count(4);
    const PolygonMesh four = remeshed(mesh).mesh;
    set_thread_count(0);
    EXPECT_EQ(one, four);
}

TEST(Remesh, TinyMeshesStayWhatTheyAre) {
    const PolygonMesh tetrahedron = test::polygons_of(test::tetrahedron());
    const Remeshed result = remeshed(tetrahedron, {.levels = 1, .tolerance = 0.5});
    EXPECT_EQ(result.base.corners.size(), 12U);
    EXPECT_EQ(result.mesh.polygon_count(), 16);
    Shape triangle{{}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
    triangle.add({0, 1, 2});
    const Remeshed flat = remeshed(test::polygons_of(triangle), {.levels = 2});
    EXPECT_EQ(flat.mesh.polygon_count(), 16);
    EXPECT_LT(flat.report.max_error, 1e-12);
}

TEST(Remesh, SaysWhatCanNotBeDone) {
    const PolygonMesh sphere = test::polygons_of(test::bumpy_sphere(4, 0.3));
    const auto code = [&](const RemeshOptions& options) {
        return remesh(sphere, options).error().code;
    };
    EXPECT_EQ(code({.base_faces = 0}), ErrorCode::InvalidArgument);
    EXPECT_EQ(code({.levels = 13}), ErrorCode::InvalidArgument);
    EXPECT_EQ(code({.feature_degrees = 200.0}), ErrorCode::InvalidArgument);
    EXPECT_EQ(code({.tolerance = 0}), ErrorCode::InvalidArgument);
    EXPECT_EQ(code({.tolerance = NAN}), ErrorCode::InvalidArgument);
    const auto coarse = remesh(sphere, {.base_faces = 8, .levels = 0, .tolerance = 1e-4});
    ASSERT_FALSE(coarse.ok());
    EXPECT_EQ(coarse.error().message.substr(0, 18), "tolerance_not_met:");
    EXPECT_EQ(coarse.error().where[0], '(');
    EXPECT_EQ(code({.progress = [](double done) { return done < 0.1; }}), ErrorCode::Cancelled);
}

TEST(Remesh, SaysHowManyHolesThereAre) {
    Shape holed{{}, test::bumpy_sphere(4, 0.3).points};
    const Shape whole = test::bumpy_sphere(4, 0.3);
    std::int64_t holes = 0;
    std::vector<std::uint8_t> beside(whole.points.size(), 0);
    for (std::size_t f = 0; f < whole.faces.size(); ++f) {
        const auto c = whole.faces[f];
        const bool free = !beside[c[0]] && !beside[c[1]] && !beside[c[2]] && f % 5 == 0;
        if (free) {  // no two holes share a vertex
            ++holes;
            for (const mesh::Index v : c) beside[v] = 1;
        } else {
            holed.add({c[0], c[1], c[2]});
        }
    }
    const auto result = remesh(test::polygons_of(holed), {.levels = 1, .tolerance = 1e-9});
    ASSERT_FALSE(result.ok());
    EXPECT_NE(result.error().message.find("its " + std::to_string(holes) + " boundaries"),
              std::string::npos)
        << result.error().text();
}

TEST(Remesh, PlaceAndSizeDoNotMatter) {
    const PolygonMesh sphere = test::polygons_of(test::bumpy_sphere(4, 0.3));
    const Remeshed plain = remeshed(sphere, {});
    EXPECT_EQ(plain.report.vertices, static_cast<std::int64_t>(sphere.vertices.size()));
    for (const auto& [scale, shift] :
         {std::pair{0x1p-100, 0.0}, std::pair{0x1p200, 0.0}, std::pair{0x1p-3, 0x1p20}}) {
        PolygonMesh moved = sphere;
        for (auto& v : moved.vertices)
            for (double& x : v) x = scale * x + shift;
        const Remeshed result = remeshed(moved, {});
        EXPECT_EQ(result.report.flips, 0);
        EXPECT_LT(result.report.max_error, 2e-3 * result.report.diagonal);
        EXPECT_NEAR(result.report.diagonal / scale, plain.report.diagonal,
                    1e-8 * plain.report.diagonal)
            << "coordinates near 2^20 are multiples of 2^-32";
    }
}

/// A scan whose ears are lost when vertices are spread without regard to the surface.
TEST(Remesh, EarsSurvive) {
    std::ifstream file(std::string(RELIEF_SHARED_DATA) + "/meshes/bunny00.off");
    if (!file) GTEST_SKIP() << "the scan is not there";
    std::string off;
    std::size_t vertices = 0;
    std::size_t faces = 0;
    std::size_t edges = 0;
    file >> off >> vertices >> faces >> edges;
    PolygonMesh bunny;
    bunny.vertices.resize(vertices);
    for (auto& v : bunny.vertices) file >> v[0] >> v[1] >> v[2];
    for (std::size_t f = 0; f < faces; ++f) {
        std::array<std::int32_t, 4> c{};
        file >> c[0] >> c[1] >> c[2] >> c[3];
        bunny.add_polygon(std::span(c).subspan(1));
    }
    const Remeshed result = remeshed(bunny);
    expect_subdivision(bunny, result);
    expect_report(bunny, result, 1e-4, 2e-3);
}

}  // namespace

}  // namespace relief::remesh
