#include "io/mesh_formats.h"
#include "io/mesh_testing.h"

namespace relief::io {
namespace {

TEST(Off, VerticesAndPolygonsOfAnySize) {
    const PolygonMesh mesh =
        off("OFF  # a comment\n\n 5 2 0\r\n0 0 0\n1 0 -1.5e2\n\t1 1 +2\n0 1 .5\n-1 .5 1e-300\n"
            "4 0 1 2 3\n3 0 3 4 # last\n\n");
    EXPECT_EQ(mesh.vertices,
              (Vertices{{0, 0, 0}, {1, 0, -150}, {1, 1, 2}, {0, 1, 0.5}, {-1, 0.5, 1e-300}}));
    EXPECT_EQ(mesh.offsets, (std::vector<std::int64_t>{0, 4, 7}));
    EXPECT_EQ(mesh.corners, (Indices{0, 1, 2, 3, 0, 3, 4}));
    EXPECT_TRUE(mesh.attributes.empty());
    EXPECT_EQ(off("OFF\n0 0 0\n"), PolygonMesh());
}

TEST(Off, MoreOnALineThanThePrefixSaysIsLeftOut) {
    const PolygonMesh mesh = off("OFF 3 1 3\n0 0 7 9 9\n1 0 8\n0 1 9\n3 0 1 2 255 0 0");
    EXPECT_EQ(mesh.vertices, (Vertices{{0, 0, 7}, {1, 0, 8}, {0, 1, 9}}));
    EXPECT_EQ(mesh.corners, (Indices{0, 1, 2}));
}

TEST(Off, ColoursInBytesOrFractions) {
    const auto colours = [](const std::string& a, const std::string& b) {
        const PolygonMesh mesh = off("COFF\n2 0\n0 0 7 " + a + "\n1 0 8 " + b + "\n");
        return mesh.attributes.at(0);
    };
    EXPECT_EQ(colours("1 2 3 255", "0 0 1 1"),
              (MeshAttribute{"colour", 4, SampleType::UInt8, {1, 2, 3, 255, 0, 0, 1, 1}}));
    EXPECT_EQ(colours("1 2 3", "0 0 1"),
              (MeshAttribute{"colour", 3, SampleType::UInt8, {1, 2, 3, 0, 0, 1}}));
    EXPECT_EQ(colours("1 0 0", "0 0.5 1"),
              (MeshAttribute{"colour", 3, SampleType::Float64, {1, 0, 0, 0, 0.5, 1}}));
    EXPECT_EQ(colours("1.0 0 0", "0 0 1").type, SampleType::Float64);
    EXPECT_EQ(colours("256 0 0", "0 0 1").type, SampleType::Float64);
}

TEST(Off, AllParts) {
    const PolygonMesh mesh = off("STCNOFF\n1 0\n1 2 3  0 0 1  9 8 7  .25 .75\n");
    EXPECT_EQ(mesh.vertices, (Vertices{{1, 2, 3}}));
    EXPECT_EQ(mesh.attributes,
              (std::vector<MeshAttribute>{{"uv", 2, SampleType::Float64, {0.25, 0.75}},
                                          {"colour", 3, SampleType::UInt8, {9, 8, 7}},
                                          {"normal", 3, SampleType::Float64, {0, 0, 1}}}));
    EXPECT_EQ(off("NOFF 1 0\n1 2 3 0 1 0").attributes,
              (std::vector<MeshAttribute>{{"normal", 3, SampleType::Float64, {0, 1, 0}}}));
    EXPECT_EQ(off("STOFF 1 0\n1 2 3 4 5").attributes,
              (std::vector<MeshAttribute>{{"uv", 2, SampleType::Float64, {4, 5}}}));
}

TEST(Off, ErrorsNameTheLine) {
    const auto refuse = [](const std::string& text, const std::string& where,
                           const std::string& says, ErrorCode code = ErrorCode::BadInput) {
        expect_refused(parse_off(bytes_of(text), "a.off"), "a.off, " + where, says, code);
    };
    const std::string vertices = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n";
    refuse("", "line 0", "empty");
    refuse("PLY\n", "line 1", "'PLY'");
    refuse("4OFF\n1 1 1\n", "line 1", "'4OFF'", ErrorCode::Unsupported);
    refuse("OFF BINARY\n", "line 1", "binary", ErrorCode::Unsupported);
    refuse("OFF\n3\n", "line 2", "numbers of vertices");
    refuse("OFF\n-1 0 0\n", "line 2", "numbers of vertices");
    refuse("OFF\n3000000000 0 0\n", "line 2", "too_many_elements");
    refuse("OFF\n2000000000 0 0\n0 0 0\n", "line 2", "too short for 2000000000 vertices");
    refuse("OFF\n1 2000000000 0\n0 0 0\n", "line 2", "too short");
    refuse("OFF\n2 0 0\n0 0 0\n# one is missing\n", "line 4", "after 1 of 2 vertices");
    refuse("OFF\n1 0 0\n0 x 0\n", "line 3", "'x'");
    refuse("OFF\n1 0 0\n0 0 1e999\n", "line 3", "'1e999'");
    refuse("OFF\n1 0 0\n0 nan 0\n", "line 3", "non_finite_vertex");
    refuse("OFF\n1 0 0\n0 0 -inf\n", "line 3", "non_finite_vertex");
    refuse("NOFF\n1 0 0\n0 0 0 0 0 inf\n", "line 3", "non_finite_value");
    refuse("NOFF\n1 0 0\n0 0 0 0 0\n", "line 3", "normal needs 3 numbers");
    refuse("COFF\n1 0 0\n0 0 0 1 1\n", "line 3", "3 or 4 numbers; this line has 5");
    refuse("COFF\n2 0 0\n0 0 0 1 1 1 1\n0 0 0 1 1 1\n", "line 4", "colour needs 4 numbers");
    refuse(vertices + "# 3 0 1 2\n\n", "line 7", "after 0 of 1 polygons");
    refuse(vertices + "2 0 1 2\n", "line 6", "at least 3");
    refuse(vertices + "3 0 1\n   ", "line 6", "3 corners");
    refuse(vertices + "3 0 1 3\n", "line 6", "index_out_of_range: a polygon names vertex 3 of 3");
    refuse(vertices + "3 0 1 -1\n", "line 6", "index_out_of_range");
    refuse(vertices + "999999999999 0 1 2\n", "line 6", "999999999999 corners");
    refuse(vertices + "3 0 1 2\n3 0 1 2\n", "line 7", "more than");
}

TEST(Off, WhatIsWritten) {
    PolygonMesh mesh;
    mesh.vertices = {{0.1, -0.0, 1e300}, {1, 2, 3}, {4, 5, 6}};
    mesh.add_polygon(std::array{0, 1, 2});
    mesh.attributes = {{"uv", 2, SampleType::Float32, {0, 0.5, 1, 0, 0, 1}},
                       {"colour", 3, SampleType::Float64, {0, 0.5, 1, 0, 0, 0, 1, 1, 1}},
                       {"normal", 3, SampleType::Float64, Values(9, 0.25), {}}};
    const detail::EncodedMesh file = detail::encode_off(mesh);
    EXPECT_EQ(file.bytes,
              "STCNOFF\n3 1 0\n"
              "0.1 -0 1e+300 0.25 0.25 0.25 0.0 0.5 1.0 0 0.5\n"
              "1 2 3 0.25 0.25 0.25 0.0 0.0 0.0 1 0\n"
              "4 5 6 0.25 0.25 0.25 1.0 1.0 1.0 0 1\n"
              "3 0 1 2\n");
    EXPECT_TRUE(file.left_out.empty());
    mesh.attributes[0].type = SampleType::Float64;
    EXPECT_EQ(off(file.bytes), mesh);
}

TEST(Off, NamesWhatIsLeftOut) {
    PolygonMesh mesh;
    mesh.vertices = Vertices(3);
    mesh.add_polygon(std::array{0, 1, 2});
    mesh.attributes = {{"uv", 3, SampleType::Float64, Values(9)},
                       {"normal", 3, SampleType::Float64, Values(3), {0, 0, 0}},
                       {"colour", 4, SampleType::UInt16, {0, 0, 0, 65535, 0, 0, 0, 0, 0, 0, 0, 0}},
                       {"heat", 1, SampleType::Float64, Values(3)}};
    mesh.labels = {{"g", {"a"}, {0}}};
    mesh.libraries = {"a.mtl"};
    mesh.creases = {{0, 1, 1}};
    mesh.sharp_vertices = {{0, 1}};
    const detail::EncodedMesh file = detail::encode_off(mesh);
    EXPECT_EQ(file.left_out, (std::vector<std::string>{"uv", "normal", "heat", "g", "mtllib",
                                                       "crease", "corner"}));
    EXPECT_EQ(off(file.bytes).attributes,
              (std::vector<MeshAttribute>{
                  {"colour", 4, SampleType::Float64, {0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0}}}));
}

}  // namespace
}  // namespace relief::io
