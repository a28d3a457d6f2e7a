#include "relief/io/mesh_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "relief/core/parallel.h"

namespace relief::io {
namespace {

using Points = std::vector<std::array<double, 3>>;
using Rgb = std::array<std::uint8_t, 3>;

PolygonMesh mesh_of(const Points& points, const std::vector<std::vector<std::int32_t>>& faces) {
    PolygonMesh mesh{.vertices = points};
    for (const auto& face : faces) mesh.add_polygon(face);
    return mesh;
}

/// A square of the plane z that is seen from above.
PolygonMesh square(double low, double high, double z) {
    return mesh_of({{low, low, z}, {high, low, z}, {high, high, z}, {low, high, z}},
                   {{0, 1, 2, 3}});
}

PolygonMesh both(const PolygonMesh& a, const PolygonMesh& b) {
    PolygonMesh all = a;
    all.vertices.insert(all.vertices.end(), b.vertices.begin(), b.vertices.end());
    for (std::int64_t f = 0; f < b.polygon_count(); ++f) {
        std::vector<std::int32_t> face(b.polygon(f).begin(), b.polygon(f).end());
        for (std::int32_t& v : face) v += static_cast<std::int32_t>(a.vertices.size());
        all.add_polygon(face);
    }
    return all;
}

PolygonMesh cube() {
    PolygonMesh mesh;
    for (int k = 0; k < 8; ++k)
        mesh.vertices.push_back({k & 1 ? 1.0 : 0, k & 2 ? 1.0 : 0, k / 4.0});
    for (auto& p : mesh.vertices) p[2] = p[2] >= 1 ? 1 : 0;
    for (const auto& face : {std::array{0, 2, 3, 1},
                             {4, 5, 7, 6},
                             {0, 1, 5, 4},
                             {2, 6, 7, 3},
                             {0, 4, 6, 2},
                             {1, 3, 7, 5}})
        mesh.add_polygon(face);
    return mesh;
}

PolygonMesh sphere(std::int32_t n) {
    PolygonMesh mesh;
    for (int k = 0; k <= n; ++k)
        for (int i = 0; i < 2 * n; ++i) {
            const double u = M_PI * i / n;
            const double v = M_PI * k / n;
            mesh.vertices.push_back(
                {std::sin(v) * std::cos(u), std::sin(v) * std::sin(u), std::cos(v)});
        }
    for (std::int32_t k = 0; k < n; ++k)
        for (std::int32_t i = 0; i < 2 * n; ++i) {
            const std::int32_t a = 2 * n * k;
            const std::int32_t next = (i + 1) % (2 * n);
            mesh.add_polygon(std::array{a + i, a + 2 * n + i, a + 2 * n + next, a + next});
        }
    return mesh;
}

PolygonMesh coloured(PolygonMesh mesh, const std::vector<double>& values,
                     SampleType type = SampleType::UInt8) {
    mesh.attributes.push_back({"colour", 3, type, values});
    return mesh;
}

/// From straight above without perspective, north at the top.
MeshPictureOptions above(int width) {
    MeshPictureOptions options;
    options.width = width;
    options.azimuth = 180;
    options.altitude = 90;
    options.field_of_view = 0;
    return options;
}

Rgb at(const Image& image, int row, int col) {
    const std::uint8_t* p = image.pixel(row, col);
    return {p[0], p[1], p[2]};
}
Rgb middle(const Image& image) {
    return at(image, image.height / 2, image.width / 2);
}

/// In pixels, of a transparent picture.
double covered(const Image& image) {
    double sum = 0;
    for (int r = 0; r < image.height; ++r)
        for (int c = 0; c < image.width; ++c) sum += image.pixel(r, c)[3] / 255.0;
    return sum;
}

TEST(MeshPicture, CoversWhatATriangleCovers) {
    MeshPictureOptions options = above(300);
    options.background = HoleStyle::Transparent;
    const Image image = draw_mesh(mesh_of({{0, 0, 5}, {4, 0, 5}, {0, 3, 5}}, {{0, 1, 2}}), options);
    ASSERT_EQ(image.width, 300);
    EXPECT_EQ(image.height, 230);  // 3 : 4 and a margin of 9 pixels, rounded up
    const double pixels = 282 / 4.0;
    // Half a sample along the outline at most: 12 units of 70.5 pixels, of which a sixth.
    EXPECT_NEAR(covered(image), 6 * pixels * pixels, 12 * pixels / 6);
    EXPECT_EQ(image.pixel(225, 5)[3], 0);
    EXPECT_EQ(image.pixel(218, 12)[3], 255);  // the right angle is south-west
    EXPECT_EQ(image.pixel(12, 285)[3], 0);
}

TEST(MeshPicture, ConcaveQuadsAreCutInside) {
    const Points arrow = {{0, 0, 0}, {4, 2, 0}, {0, 4, 0}, {1, 2, 0}};
    for (std::int32_t first = 0; first < 4; ++first) {
        MeshPictureOptions options = above(400);
        options.background = HoleStyle::Transparent;
        const Image image = draw_mesh(
            mesh_of(arrow, {{first, (first + 1) % 4, (first + 2) % 4, (first + 3) % 4}}), options);
        const double pixels = 376 / 4.0;
        EXPECT_NEAR(covered(image), 6 * pixels * pixels, 14 * pixels / 6) << first;
    }
}

TEST(MeshPicture, NearerFacesHideOthers) {
    const std::vector<double> red_then_blue = {255, 0, 0,   255, 0, 0,   255, 0, 0,   255, 0, 0,
                                               0,   0, 255, 0,   0, 255, 0,   0, 255, 0,   0, 255};
    for (const double height : {1.0, -1.0}) {
        const PolygonMesh mesh =
            coloured(both(square(1, 3, height), square(0, 4, 0)), red_then_blue);
        const Image image = draw_mesh(mesh, above(100));
        const Rgb centre = middle(image);
        const Rgb corner = at(image, 8, 8);
        EXPECT_EQ(centre[height > 0 ? 2 : 0], 0);
        EXPECT_GT(centre[height > 0 ? 0 : 2], 150);
        EXPECT_GT(corner[2], 150);
        EXPECT_EQ(corner[0], 0);
    }
}

TEST(MeshPicture, ColoursOfEveryTypeAreTheSame) {
    const PolygonMesh plate = square(0, 1, 0);
    std::vector<double> codes;
    for (int k = 0; k < 4; ++k) codes.insert(codes.end(), {51, 102, 255});
    const Image bytes = draw_mesh(coloured(plate, codes), above(64));
    for (const auto& [type, factor] :
         {std::pair{SampleType::UInt16, 257.0}, {SampleType::Float64, 1 / 255.0}}) {
        std::vector<double> values = codes;
        for (double& value : values) value *= factor;
        EXPECT_EQ(draw_mesh(coloured(plate, values, type), above(64)).pixels, bytes.pixels);
    }
    PolygonMesh corners = plate;
    corners.attributes.push_back(
        {"colour", 3, SampleType::UInt8, {51, 102, 255, 9, 9, 9}, {0, 0, 0, 0}});
    EXPECT_EQ(draw_mesh(corners, above(64)).pixels, bytes.pixels);
    corners.attributes[0].corners = {-1, -1, -1, -1};
    EXPECT_EQ(draw_mesh(corners, above(64)).pixels, draw_mesh(plate, above(64)).pixels);
}

/// Framed by its own outline, a ball is a disk in any perspective.
TEST(MeshPicture, TheOutlineOfASphereIsACircle) {
    for (const double field : {0.0, 25.0, 60.0}) {
        MeshPictureOptions options;
        options.width = 200;
        options.field_of_view = field;
        options.background = HoleStyle::Transparent;
        const Image image = draw_mesh(sphere(60), options);
        EXPECT_NEAR(image.height, 200, 1);
        const double radius = (200 - 12) / 2.0;
        // Facets sag by 3.4e-4 of the radius at most; half a sixth of a pixel along the outline.
        EXPECT_NEAR(covered(image), M_PI * radius * radius, 2 * M_PI * radius * 0.11) << field;
        for (int r = 0; r < image.height; ++r)
            for (int c = 0; c < image.width; ++c) {
                const double off = std::hypot(r + 0.5 - image.height / 2.0, c + 0.5 - 100);
                if (off < radius - 2) {
                    ASSERT_EQ(image.pixel(r, c)[3], 255);
                }
                if (off > radius + 2) {
                    ASSERT_EQ(image.pixel(r, c)[3], 0);
                }
            }
        // The light comes from the upper left.
        EXPECT_GT(at(image, 70, 70)[0], at(image, 130, 130)[0] + 25);
    }
}

TEST(MeshPicture, BacksAreBrown) {
    const Rgb front = middle(draw_mesh(square(0, 1, 0), above(64)));
    EXPECT_NEAR(front[0], front[2], 15);
    PolygonMesh turned = square(0, 1, 0);
    std::reverse(turned.corners.begin(), turned.corners.end());
    const Rgb back = middle(draw_mesh(turned, above(64)));
    EXPECT_GT(back[0], back[2] + 50);
}

TEST(MeshPicture, SharpEdgesStaySharp) {
    MeshPictureOptions options;
    options.width = 150;
    const PolygonMesh box = cube();
    const Image smooth = draw_mesh(box, options);
    const Image round = draw_mesh(sphere(6), options);
    options.shading = MeshShading::Facets;
    EXPECT_EQ(draw_mesh(box, options).pixels, smooth.pixels);
    EXPECT_NE(draw_mesh(sphere(6), options).pixels, round.pixels);
}

TEST(MeshPicture, YUpIsTurnedZUp) {
    MeshPictureOptions options;
    options.width = 120;
    PolygonMesh standing = sphere(9);
    for (auto& p : standing.vertices) p[1] *= 2;
    const Image image = draw_mesh(standing, options);
    for (auto& p : standing.vertices) p = {p[0], p[2], -p[1]};
    options.up = UpAxis::Y;
    EXPECT_EQ(draw_mesh(standing, options).pixels, image.pixels);
}

TEST(MeshPicture, ValuesAreColoursWithALegend) {
    const PolygonMesh plate = square(0, 1, 0);
    MeshPictureOptions options = above(200);
    const int bare = draw_mesh(plate, options).height;
    const auto seen = [&](const std::vector<double>& values) {
        options.values = values;
        const Image image = draw_mesh(plate, options);
        EXPECT_GT(image.height, bare + 20);
        return at(image, bare / 2, 100);
    };
    const Rgb zero = seen({0, 0, 0, 0});
    EXPECT_NEAR(zero[0], zero[2], 3);
    const Rgb most = seen({2, 2, 2, 2});
    EXPECT_GT(most[0], most[2] + 80);
    const Rgb least = seen({-2, -2, -2, -2});
    EXPECT_GT(least[2], least[0] + 50);
    const Rgb none = seen({HUGE_VAL, NAN, 1, 2});
    EXPECT_EQ(none, at(draw_mesh(plate, above(200)), bare / 2, 100));
    options.scale = 200;
    const Rgb little = seen({2, 2, 2, 2});
    EXPECT_LT(little[0], zero[0] + 8);
    EXPECT_GT(little[2], most[2] + 80);
}

/// How much of a picture has the colour of a pen: white paper and grey meshes count for nothing.
double inked(const Image& image) {
    double sum = 0;
    for (int r = 0; r < image.height; ++r)
        for (int c = 0; c < image.width; ++c)
            sum += std::max(0, image.pixel(r, c)[0] - image.pixel(r, c)[1] - 20) / 235.0;
    return sum;
}

TEST(MeshPicture, HiddenLinesAreRemoved) {
    const PolygonMesh plate = square(0, 4, 0);
    const PolygonMesh over = square(1, 3, 0.5);
    const PolygonMesh under = square(1, 3, -0.5);
    MeshPictureOptions options = above(200);
    options.net_lines = {.width = 4, .colour = {255, 0, 0}};
    options.net = &over;
    // Four sides of 94 pixels, 4 wide, with round ends.
    EXPECT_NEAR(inked(draw_mesh(plate, options)), 4 * 94 * 4, 60);
    options.net = &under;
    EXPECT_EQ(inked(draw_mesh(plate, options)), 0);
    options.net_lines.hidden_opacity = 0.5;
    const double faint = inked(draw_mesh(plate, options));
    EXPECT_GT(faint, 200);
    EXPECT_LT(faint, 4 * 94 * 4 * 0.6);
    // A net in the surface lies on it, and dots of radius 6 are larger than lines.
    const PolygonMesh in = square(1, 3, 0);
    options.net_lines = {.width = 0, .colour = {255, 0, 0}, .dot_radius = 6};
    options.net = &in;
    EXPECT_NEAR(inked(draw_mesh(plate, options)), 4 * M_PI * 36, 40);
}

TEST(MeshPicture, EdgesOfTheMeshLieOnIt) {
    MeshPictureOptions options;
    options.width = 300;
    options.edges = {.width = 2, .colour = {255, 0, 0}};
    const Image image = draw_mesh(cube(), options);
    options.edges.width = 0;
    EXPECT_EQ(inked(draw_mesh(cube(), options)), 0);
    const double visible = inked(image);
    options.edges = {.width = 2, .hidden_opacity = 1, .colour = {255, 0, 0}};
    const double all = inked(draw_mesh(cube(), options));
    EXPECT_GT(visible, 1000);
    EXPECT_NEAR(visible / all, 9 / 12.0, 0.04);  // nine of twelve edges, by perspective longer
}

TEST(MeshPicture, AnythingThatIsAMeshCanBeDrawn) {
    EXPECT_TRUE(draw_mesh({}).pixels.empty());
    EXPECT_TRUE(draw_mesh({.vertices = {{0, 0, 0}}}).pixels.empty());
    MeshPictureOptions options;
    options.width = 40;
    options.edges.width = 1;
    for (const Points& points :
         {Points{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, Points{{0, 0, 0}, {0, 0, 9}, {0, 0, 2}},
          Points{{-1e308, 0, 0}, {1e308, 0, 0}, {0, 1e308, -1e308}},
          Points{{0, 0, 0}, {1e-310, 0, 0}, {0, 1e-310, 0}}}) {
        const Image image = draw_mesh(mesh_of(points, {{0, 1, 2}}), options);
        EXPECT_EQ(image.width, 40);
        EXPECT_GE(image.height, 1);
        EXPECT_LE(image.height, 84);
    }
    // A vertex without faces does not move the frame.
    PolygonMesh stray = cube();
    stray.vertices.push_back({1e6, 0, 0});
    EXPECT_EQ(draw_mesh(stray, options).pixels, draw_mesh(cube(), options).pixels);
}

TEST(MeshPicture, SameForAnyThreadCount) {
    const PolygonMesh ball = sphere(40);
    const PolygonMesh net = sphere(5);
    std::vector<double> values;
    for (const auto& p : ball.vertices) values.push_back(p[0] * p[1]);
    MeshPictureOptions options;
    options.width = 160;
    options.edges = {.width = 0.7, .opacity = 0.5};
    options.net = &net;
    options.values = values;
    set_thread_count(1);
    const Image one = draw_mesh(ball, options);
    set_thread_count(4);
    const Image four = draw_mesh(ball, options);
    set_thread_count(0);
    EXPECT_EQ(one.pixels, four.pixels);
}

}  // namespace
}  // namespace relief::io
