#include "io/mesh_formats.h"
#include "io/mesh_testing.h"

namespace relief::io {
namespace {

const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

TEST(Obj, FacesInAllNotations) {
    const PolygonMesh mesh = obj(
        "# head\nmtllib x.mtl\no thing\nv 0 0 0\nv 1 0 1 1.0\nv 1 1 2 .1 .2 .3\nvt 0 0\nvn 0 0 1\n"
        "f 1 2/1 3/1/1 4//1\nv 0 1 3\ns off\nf -1 -2 -3\r\nf 1/-1 2/-1 3/-1 # tail\n");
    EXPECT_EQ(mesh.vertices, (Vertices{{0, 0, 0}, {1, 0, 1}, {1, 1, 2}, {0, 1, 3}}));
    EXPECT_EQ(mesh.offsets, (std::vector<std::int64_t>{0, 4, 7, 10}));
    EXPECT_EQ(mesh.corners, (Indices{0, 1, 2, 3, 3, 2, 1, 0, 1, 2}));
    // The first face has texture places and normals at some corners only; no face is left with one.
    EXPECT_EQ(mesh.attributes,
              (std::vector<MeshAttribute>{
                  {"uv", 2, SampleType::Float64, {0, 0}, {-1, -1, -1, -1, -1, -1, -1, 0, 0, 0}},
                  {"colour", 3, SampleType::Float64, {1, 1, 1, 1, 1, 1, .1, .2, .3, 1, 1, 1}}}));
    EXPECT_EQ(mesh.labels, (std::vector<FaceLabels>{{"o", {"thing"}, {0, 0, 0}}}));
    EXPECT_EQ(mesh.libraries, (std::vector<std::string>{"x.mtl"}));
}

TEST(Obj, AttributesOfVerticesAndOfCorners) {
    const std::string places = "vt 0 0\nvt 1 0\nvt 0 1\n";
    EXPECT_EQ(obj(kTriangle + places + "f 1/1 2/2 3/3\n").attributes,
              (std::vector<MeshAttribute>{{"uv", 2, SampleType::Float64, {0, 0, 1, 0, 0, 1}}}));
    EXPECT_EQ(obj(kTriangle + places + "f 1/1 2/2 3/1\n").attributes,
              (std::vector<MeshAttribute>{
                  {"uv", 2, SampleType::Float64, {0, 0, 1, 0, 0, 1}, {0, 1, 0}}}));
    EXPECT_EQ(
        obj(kTriangle + "f 1/1/1 2/1/1 3/2/1\nvt 1 2 3\nvt 4\nvn 0 0 -1\n").attributes,
        (std::vector<MeshAttribute>{{"uv", 3, SampleType::Float64, {1, 2, 3, 4, 0, 0}, {0, 0, 1}},
                                    {"normal", 3, SampleType::Float64, {0, 0, -1}, {0, 0, 0}}}));
    EXPECT_TRUE(obj(kTriangle + "vt 1 2\nf 1 2 3\n").attributes.empty()) << "no corner names it";
}

TEST(Obj, Colours) {
    const auto colours = [](const std::string& a, const std::string& b) {
        return obj("v 0 0 0 " + a + "\nv 0 0 0 " + b + "\n").attributes.at(0);
    };
    EXPECT_EQ(colours("0 0 1", "1 .5 0"),
              (MeshAttribute{"colour", 3, SampleType::Float64, {0, 0, 1, 1, 0.5, 0}}));
    EXPECT_EQ(colours("0 0 1", "1 1 0").type, SampleType::Float64);
    EXPECT_EQ(colours("0 0 1 .5", "1 1 0"),
              (MeshAttribute{"colour", 4, SampleType::Float64, {0, 0, 1, .5, 1, 1, 0, 1}}));
    EXPECT_EQ(colours("0 17 1", ""),
              (MeshAttribute{"colour", 3, SampleType::UInt8, {0, 17, 1, 255, 255, 255}}));
    EXPECT_EQ(colours("0 17.5 1", "").type, SampleType::Float64);
}

TEST(Obj, LabelsOfFaces) {
    const PolygonMesh mesh =
        obj(kTriangle +
            "f 1 2 3\ng a  b\nusemtl Material#25 # not the name\nf 1 2 3\ns 1\ng c\nf 1 2 3\n"
            "g a  b\ns off\nf 1 2 3\ng\nusemtl old brass\nf 1 2 3\n");
    EXPECT_EQ(mesh.labels,
              (std::vector<FaceLabels>{{"g", {"a  b", "c"}, {-1, 0, 1, 0, -1}},
                                       {"usemtl", {"Material#25", "old brass"}, {-1, 0, 0, 0, 1}},
                                       {"s", {"1"}, {-1, -1, 0, -1, -1}}}));
}

TEST(Obj, ContinuedLines) {
    const PolygonMesh mesh =
        obj("v 0 0 \\\n0\nv 1 0 0\\\r\n\nv 0 1 0\nusemtl a\\b \\\n c\n"
            "f 1\\\n 2 \\\n3\nf 1 2 3 \\");
    EXPECT_EQ(mesh.vertices, (Vertices{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_EQ(mesh.corners, (Indices{0, 1, 2, 0, 1, 2}));
    EXPECT_EQ(mesh.labels, (std::vector<FaceLabels>{{"usemtl", {"a\\b   c"}, {0, 0}}}));
    EXPECT_EQ(obj("mtllib a.m\\\\ # not continued\nmtllib \\ #\n").libraries,
              (std::vector<std::string>{"a.m"}));
    expect_refused(parse_obj(bytes_of(kTriangle + "f 1 2 \\\n4\n"), "a.obj"), "a.obj, line 5",
                   "vertex 4 of 3");
}

TEST(Obj, CreasesAndCorners) {
    const PolygonMesh mesh = obj(
        "t crease 2/1/0 0 1 2.5\n" + kTriangle +
        "t crease 2/1/0  2 1  10\nt crease 3/1/0 0 1 2 3\nt crease 3/2/0 0 1 2 3 4\n"
        "t crease 2/1/0 0 1 0\nt crease 2/1/0 1 1 5\nt corner 1/1/0 2 inf\n"
        "t corner 2/2/0 0 1 7 -1\nt interpolateboundary 1/0/0 2\nt creasemethod 0/0/1 chaikin\n");
    EXPECT_EQ(mesh.creases,
              (std::vector<CreaseEdge>{
                  {0, 1, 2.5}, {2, 1, HUGE_VAL}, {0, 1, 3}, {1, 2, 3}, {0, 1, 3}, {1, 2, 4}}));
    EXPECT_EQ(mesh.sharp_vertices, (std::vector<SharpVertex>{{2, HUGE_VAL}, {0, 7}}));
}

TEST(Obj, ErrorsNameTheLine) {
    const auto refuse = [](const std::string& text, const std::string& where,
                           const std::string& says) {
        expect_refused(parse_obj(bytes_of(text), "a.obj"), "a.obj, " + where, says);
    };
    refuse("v 0 0\n", "line 1", "vertex needs 3 numbers");
    refuse("v 0 0 nan\n", "line 1", "non_finite_vertex");
    refuse("v 0 0 -INF\n", "line 1", "non_finite_vertex");
    refuse("v 0 0 0 a\n", "line 1", "colour");
    refuse("vt\n", "line 1", "texture place");
    refuse("vt 0 inf\n", "line 1", "non_finite_value");
    refuse("vn 0 0\n", "line 1", "normal needs 3 numbers");
    refuse(kTriangle + "f 1 2\n", "line 4", "at least 3");
    refuse(kTriangle + "f\n", "line 4", "at least 3");
    refuse(kTriangle + "f 1 2 0\n", "line 4", "vertex 0 of 3");
    refuse(kTriangle + "f 1 2 -4\n", "line 4", "vertex -4 of 3");
    refuse(kTriangle + "f 1 2 5\nf 1 2 4\nv 1 1 1\n", "line 4", "vertex 5 of 4");
    refuse(kTriangle + "f 1 2 3\nf 1 2 99999999999\n", "line 5", "index_out_of_range");
    refuse(kTriangle + "f 1/1 2/1 3/1\n", "line 4", "texture place 1 of 0");
    refuse(kTriangle + "vn 0 0 1\nf 1//1 2//1 3//2\n", "line 5", "normal 2 of 1");
    refuse(kTriangle + "vn 0 0 1\nf 1//1 2//1 3//-2\n", "line 5", "normal -2 of 1");
    for (const std::string corner :
         {"3/", "3//", "3/1/", "/3", "a", "3.0", "3/1/1/1", "3///", "3/a", "3//a", "3/1//1", "/"})
        refuse(kTriangle + "vt 0 0\nvn 0 0 1\nf 1 2 " + corner + "\n", "line 6",
               "corner of a face");
    for (const std::string tag :
         {"crease", "crease 2/1", "crease -2/1/0 0 1 1", "crease 2/1/0 0 1", "crease 1/1/0 0 1",
          "crease 0/1/0 1", "corner 0/1/0 1", "crease 3/3/0 0 1 2 1 1 1", "crease 2/0/0 0 1",
          "crease 99999999/1/0 0 1 2", "corner 1/9999999999/0 0 1", "crease 2/1/0 0 1 nan"})
        refuse(kTriangle + "t " + tag + "\n", "line 4", "a tag");
    refuse(kTriangle + "t crease 2/1/0 0 -1 1\n", "line 4", "index_out_of_range");
    refuse(kTriangle + "t corner 1/1/0 3 1\n", "line 4", "vertex 4 of 3; they count from 1");
}

TEST(Obj, WhatIsWritten) {
    const std::string text =
        "mtllib a b.mtl\nmtllib c.mtl\n"
        "v 0.1 -0 1e+300 0 0.5 1\nv 1 2 3 1 1 1\nv 4 5 6 0 0 0\n"
        "vt 0 0\nvt 1 0.25\nvn 0 0 1\nvn 0 1 0\nvn 1 0 0\n"
        "f 1//1 2//2 3//3\ng a b\ns 1\nf 3/1/3 2/2/2 1/1/1\ng c\ns off\nf 1//1 2//2 3//3\ng\nf "
        "1//1 2//2 3//3\n"
        "t crease 2/1/0 0 1 2.5\nt crease 2/1/0 1 2 10\nt corner 1/1/0 2 0.5\n";
    const PolygonMesh mesh = obj(text);
    const detail::EncodedMesh file = detail::encode_obj(mesh);
    EXPECT_EQ(file.bytes, text);
    EXPECT_TRUE(file.left_out.empty());
}

TEST(Obj, ColoursAreWrittenAsFractions) {
    PolygonMesh mesh;
    mesh.vertices = Vertices(1);
    mesh.attributes = {{"colour", 3, SampleType::UInt8, {0, 51, 255}},
                       {"heat", 1, SampleType::Float64, {5}}};
    const detail::EncodedMesh file = detail::encode_obj(mesh);
    EXPECT_EQ(file.bytes, "v 0 0 0 0 0.2 1\n");
    EXPECT_EQ(file.left_out, (std::vector<std::string>{"heat"}));
    mesh.add_polygon(std::array{0, 0, 0});
    mesh.attributes = {{"colour", 3, SampleType::UInt8, {0, 51, 255}, {0, 0, 0}}};
    EXPECT_EQ(detail::encode_obj(mesh).left_out, (std::vector<std::string>{"colour"}));
}

}  // namespace
}  // namespace relief::io
