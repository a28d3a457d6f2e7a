#include <cstring>

#include "io/mesh_formats.h"
#include "io/mesh_testing.h"
#include "io/weld.h"

namespace relief::io {
namespace {

using Facet = std::array<std::array<float, 3>, 3>;

std::string binary(const std::vector<Facet>& facets, const std::string& title = "") {
    std::string bytes = title;
    bytes.resize(80);
    detail::append_little_endian(bytes, static_cast<std::uint32_t>(facets.size()));
    for (const Facet& facet : facets) {
        bytes.append(12, '\x7F');  // the normal is not read
        for (const auto& corner : facet)
            for (const float coordinate : corner) detail::append_little_endian(bytes, coordinate);
        bytes.append(2, '\1');
    }
    return bytes;
}

std::string ascii(const std::vector<std::string>& facets) {
    std::string text = "solid a facet of #1\n";
    for (const std::string& facet : facets)
        text += " facet normal 0 0 0\n  outer loop\n" + facet + "  endloop\n endfacet\n";
    return text + "endsolid a\n";
}

TEST(Weld, NumbersInOrderOfAppearance) {
    const std::vector<double> rows = {1, 2, -0.0, 0, 1, 2, 0, 0, 0, 1, 1, 2};
    const detail::Welded pairs = detail::weld(rows, 2);
    EXPECT_EQ(pairs.numbers, (Indices{0, 1, 0, 1, 2, 0}));
    EXPECT_EQ(pairs.firsts, (Indices{0, 1, 4}));
    EXPECT_TRUE(detail::weld({}, 3).numbers.empty());
}

TEST(Stl, BinaryFacetsShareVertices) {
    const std::string bytes = binary({{{{0, 0, 0}, {1, 0, 0}, {0, 0.1F, 0}}},
                                      {{{0, 0.1F, 0}, {1, 0, -0.0F}, {1, 1, 0}}},
                                      {{{0, 0, 0}, {1, 1, 0}, {-0.0F, 0, 0}}},
                                      {{{5, 5, 5}, {1, 1, 0}, {0, 0, 0}}}},
                                     "solid, but binary");
    const LoadedMesh loaded = stl(bytes);
    EXPECT_EQ(
        loaded.mesh.vertices,
        (Vertices{{0, 0, 0}, {1, 0, 0}, {0, static_cast<double>(0.1F), 0}, {1, 1, 0}, {5, 5, 5}}));
    EXPECT_EQ(loaded.mesh.corners, (Indices{0, 1, 2, 2, 1, 3, 4, 3, 0}));
    EXPECT_EQ(loaded.mesh.offsets, (std::vector<std::int64_t>{0, 3, 6, 9}));
    EXPECT_EQ(loaded.degenerate_facets, 1);
    EXPECT_EQ(stl(binary({})).mesh, PolygonMesh());
}

TEST(Stl, Ascii) {
    const LoadedMesh loaded = stl(ascii({"vertex 0 0 0.1\nvertex 1 0 0\nVERTEX 0 1e0 0\n",
                                         "vertex 0 1 0\r\nvertex 1 0 -0\nvertex 1 1 0\n",
                                         "vertex 1 1 0\n vertex 1 1 0\nvertex 0 0 7\n"}) +
                                  ascii({}));
    EXPECT_EQ(loaded.mesh.vertices,
              (Vertices{{0, 0, 0.1}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 7}}));
    EXPECT_EQ(loaded.mesh.corners, (Indices{0, 1, 2, 2, 1, 3}));
    EXPECT_EQ(loaded.degenerate_facets, 1);
}

TEST(Stl, ErrorsNameTheByteOrTheLine) {
    const auto refuse = [](const std::string& text, const std::string& where,
                           const std::string& says) {
        expect_refused(parse_stl(bytes_of(text), "a.stl"), "a.stl, " + where, says);
    };
    const Facet facet = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
    refuse("", "byte 0", "at least 84 bytes");
    refuse(std::string(83, 'a'), "byte 83", "cut off");
    std::string lie = binary({facet});
    lie[83] = '\xFF';
    refuse(lie, "byte 80", "4278190081 facets");
    refuse(binary({facet}) + "x", "byte 80", "1 facets take 134 bytes, but the file has 135");
    refuse(binary({facet, {{{0, 0, 0}, {1, 0, 0}, {0, NAN, 0}}}}), "byte 174", "non_finite_vertex");

    const std::string good = "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n";
    refuse("solid\n", "line 1", "cut off");
    refuse("solid\nfacet\n", "line 2", "cut off");
    refuse("solid\nvertex 0 0 0\n", "line 2", "outside");
    refuse("solid\nfacet\nfacet\n", "line 3", "inside");
    refuse("solid\nendfacet\n", "line 2", "3 vertices");
    refuse("solid\nwood\n", "line 2", "'wood'");
    refuse(ascii({good + "vertex 0 0 0\n"}), "line 9", "3 vertices");
    refuse(ascii({"vertex 0 0 0\nvertex 0 0 0\n"}), "line 7", "3 vertices");
    refuse(ascii({"vertex 0 0\n"}), "line 4", "vertex needs 3 numbers");
    refuse(ascii({"vertex 0 0 inf\n"}), "line 4", "non_finite_vertex");
}

TEST(Stl, PolygonsAreWrittenAsFans) {
    PolygonMesh mesh;
    mesh.vertices = {{0, 0, 0.5}, {2, 0, 0.5}, {2, 2, 0.5}, {0, 2, 0.5}, {9, 9, 9}};
    mesh.add_polygon(std::array{0, 1, 2, 3});
    mesh.add_polygon(std::array{2, 2, 2});
    mesh.attributes = {{"normal", 3, SampleType::Float32, Values(15)}};
    mesh.labels = {{"s", {"1"}, {0, 0}}};
    const auto file = detail::encode_stl(mesh);
    ASSERT_TRUE(file.ok());
    EXPECT_EQ(file->left_out, (std::vector<std::string>{"normal", "s"}));
    ASSERT_EQ(file->bytes.size(), 84U + 3 * 50);
    const std::array<std::array<float, 12>, 3> facets = {
        {{0, 0, 1, 0, 0, 0.5F, 2, 0, 0.5F, 2, 2, 0.5F},
         {0, 0, 1, 0, 0, 0.5F, 2, 2, 0.5F, 0, 2, 0.5F},
         {0, 0, 0, 2, 2, 0.5F, 2, 2, 0.5F, 2, 2, 0.5F}}};
    for (std::size_t k = 0; k < facets.size(); ++k)
        EXPECT_EQ(std::memcmp(file->bytes.data() + 84 + 50 * k, facets[k].data(), 48), 0) << k;
    const LoadedMesh loaded = stl(file->bytes);
    EXPECT_EQ(loaded.mesh.vertices, (Vertices{{0, 0, .5}, {2, 0, .5}, {2, 2, .5}, {0, 2, .5}}));
    EXPECT_EQ(loaded.mesh.corners, (Indices{0, 1, 2, 0, 2, 3}));
    EXPECT_EQ(loaded.degenerate_facets, 1);
}

TEST(Stl, CoordinatesThatNoFloatHolds) {
    PolygonMesh mesh;
    mesh.vertices = {{0, 0, 0}, {0, 1e39, 0}};
    expect_refused(detail::encode_stl(mesh), "vertex 1", "too large");
}

}  // namespace
}  // namespace relief::io
