#include <bit>
#include <cstring>

#include "io/mesh_formats.h"
#include "io/mesh_testing.h"

namespace relief::io {
namespace {

const std::string kPlaces = "property float x\nproperty float y\nproperty float z\n";

std::string head(const std::string& format, const std::string& rest) {
    return "ply\nformat " + format + " 1.0\n" + rest + "end_header\n";
}

/// The bytes of numbers in either order.
class Binary {
  public:
    explicit Binary(bool big) : big_(big) {}

    template <class Number>
    Binary& add(std::initializer_list<Number> numbers) {
        for (const Number number : numbers) {
            std::string raw;
            detail::append_little_endian(raw, number);
            bytes_.append(big_ ? std::string(raw.rbegin(), raw.rend()) : raw);
        }
        return *this;
    }
    [[nodiscard]] const std::string& bytes() const { return bytes_; }

  private:
    bool big_;
    std::string bytes_;
};

TEST(Ply, Ascii) {
    const PolygonMesh mesh =
        ply(head("ascii", "comment made by hand\nobj_info no\nelement vertex 4\n" + kPlaces +
                              "element face 2\nproperty list uchar int vertex_index\n") +
            "0 0 0.1\r\n1 0 -1e300\n\n1 1 0\n0 1 0\n4 0 1 2 3\n3 2 1 0\n\n");
    EXPECT_EQ(mesh.vertices, (Vertices{{0, 0, 0.1}, {1, 0, -1e300}, {1, 1, 0}, {0, 1, 0}}));
    EXPECT_EQ(mesh.offsets, (std::vector<std::int64_t>{0, 4, 7}));
    EXPECT_EQ(mesh.corners, (Indices{0, 1, 2, 3, 2, 1, 0}));
    EXPECT_EQ(ply(head("ascii", "element vertex 1\n" + kPlaces) + "1 2 3\n").vertices,
              (Vertices{{1, 2, 3}}));
}

TEST(Ply, BinaryOfEitherOrderAndAllTypes) {
    for (const bool big : {false, true}) {
        const std::string format = big ? "binary_big_endian" : "binary_little_endian";
        const std::string text = head(
            format,
            "element before 2\nproperty list ushort double a\nproperty int8 b\n"
            "element vertex 3\nproperty short nx\nproperty double z\nproperty uint y\n"
            "property list uchar float skipped\nproperty char x\nproperty short ny\n"
            "property short nz\nproperty uchar red\nproperty uint8 green\nproperty uchar blue\n"
            "element none 5\n"
            "element face 1\nproperty float quality\nproperty list int32 ushort vertex_indices\n");
        Binary body(big);
        body.add<std::uint16_t>({2}).add<double>({1, 2}).add<std::int8_t>({-1});
        body.add<std::uint16_t>({0}).add<std::int8_t>({-1});
        const double places[3][3] = {{-128, 4294967295.0, 0.1}, {127, 0, -0.0}, {5, 6, 1e300}};
        for (const auto& [x, y, z] : places) {
            body.add<std::int16_t>({-7}).add<double>({z}).add({static_cast<std::uint32_t>(y)});
            body.add<std::uint8_t>({1}).add<float>({NAN}).add({static_cast<std::int8_t>(x)});
            body.add<std::int16_t>({300, -32768}).add<std::uint8_t>({0, 128, 255});
        }
        body.add<float>({NAN}).add<std::int32_t>({3}).add<std::uint16_t>({2, 1, 0});
        const PolygonMesh mesh = ply(text + body.bytes());
        EXPECT_EQ(mesh.vertices,
                  (Vertices{{-128, 4294967295.0, 0.1}, {127, 0, -0.0}, {5, 6, 1e300}}));
        EXPECT_EQ(mesh.corners, (Indices{2, 1, 0}));
        EXPECT_EQ(mesh.attributes,
                  (std::vector<MeshAttribute>{
                      {"colour", 3, SampleType::UInt8, {0, 128, 255, 0, 128, 255, 0, 128, 255}},
                      {"normal",
                       3,
                       SampleType::Int16,
                       {-7, 300, -32768, -7, 300, -32768, -7, 300, -32768}}}));
    }
}

TEST(Ply, NamesOfAttributes) {
    const auto attributes = [](const std::string& properties, const std::string& numbers) {
        return ply(head("ascii", "element vertex 1\n" + kPlaces + properties) + "1 2 3 " + numbers)
            .attributes;
    };
    using List = std::vector<MeshAttribute>;
    const auto properties = [](std::initializer_list<const char*> names) {
        std::string text;
        for (const char* name : names) text += std::string("property float ") + name + "\n";
        return text;
    };
    const List uv = {{"uv", 2, SampleType::Float32, {0.25, 0.5}}};
    EXPECT_EQ(attributes(properties({"s", "t"}), "0.25 0.5"), uv);
    EXPECT_EQ(attributes(properties({"v", "u"}), "0.5 0.25"), uv);
    EXPECT_EQ(attributes(properties({"texture_u", "texture_v"}), "0.25 0.5"), uv);
    EXPECT_EQ(attributes(properties({"s", "u", "t", "v"}), "0.25 7 0.5 7"), uv);
    EXPECT_EQ(attributes(properties({"s", "t", "p"}), "1 2 3"),
              (List{{"uv", 3, SampleType::Float32, {1, 2, 3}}}));
    EXPECT_EQ(attributes(properties({"red", "green", "blue", "alpha"}), "0 0.5 1 0.1"),
              (List{{"colour", 4, SampleType::Float32, {0, 0.5, 1, static_cast<double>(0.1F)}}}));
    EXPECT_EQ(
        attributes("property uchar red\nproperty uchar green\nproperty float blue\n", "1 2 3"),
        (List{{"colour", 3, SampleType::Float64, {1, 2, 3}}}));
    EXPECT_TRUE(attributes(properties({"s", "nx", "ny", "red"}), "1 2 3 4").empty());
}

TEST(Ply, TexturePlacesOfCorners) {
    const std::string text =
        head("ascii",
             "element vertex 4\n" + kPlaces +
                 "property float s\nproperty float t\nelement face 3\n"
                 "property list uchar int vertex_indices\nproperty list uchar float texcoord\n"
                 "property int texnumber\n") +
        "0 0 0 5 5\n1 0 0 5 5\n1 1 0 5 5\n0 1 0 5 5\n"
        "3 0 1 2 6 0 0 1 0 1 1 0\n3 0 2 3 0 0\n4 0 1 2 3 8 1 0 -0 0 0.5 0.5 1 1 0\n";
    EXPECT_EQ(ply(text).attributes,
              (std::vector<MeshAttribute>{{"uv",
                                           2,
                                           SampleType::Float32,
                                           {0, 0, 1, 0, 1, 1, 0.5, 0.5},
                                           {0, 1, 2, -1, -1, -1, 1, 0, 3, 2}}}));
}

TEST(Ply, ErrorsNameTheLine) {
    const auto refuse = [](const std::string& text, const std::string& where,
                           const std::string& says) {
        expect_refused(parse_ply(bytes_of(text), "a.ply"), "a.ply, " + where, says);
    };
    const std::string vertices = "element vertex 3\n" + kPlaces;
    const std::string faces = "element face 1\nproperty list uchar int vertex_indices\n";
    const std::string triangle = "0 0 0\n1 0 0\n0 1 0\n";
    refuse("", "line 0", "word ply");
    refuse("plyx\n", "line 1", "word ply");
    refuse("ply\nformat ascii 1.0\n", "line 2", "no end_header");
    refuse("ply\nformat ascii 2.0\n", "line 2", "version 1.0");
    refuse("ply\nformat text 1.0\n", "line 2", "'text'");
    refuse("ply\nend_header\n", "line 2", "does not name a format");
    refuse("ply\nlight on\n", "line 2", "'light'");
    refuse("ply\nproperty int x\n", "line 2", "before all elements");
    refuse("ply\nelement vertex\n", "line 2", "number of rows");
    refuse("ply\nelement vertex -1\n", "line 2", "number of rows");
    refuse("ply\nelement vertex 1\nelement vertex 1\n", "line 3", "twice");
    refuse("ply\nelement vertex 1\nproperty half x\n", "line 3", "'half'");
    refuse("ply\nelement vertex 1\nproperty int\n", "line 3", "a name");
    refuse("ply\nelement vertex 1\nproperty list float int x\n", "line 3", "integer type");
    refuse("ply\ncomment label_g\n", "line 2", "a name");
    refuse(head("ascii", "element vertex 0\nproperty float x\n"), "line 5", "x, y, z");
    refuse(head("ascii", "element face 0\n"), "line 4", "x, y, z");
    refuse(head("ascii", "element vertex 3000000000\n" + kPlaces), "line 7", "too_many_elements");
    refuse(head("ascii", "element vertex 2000000000\n" + kPlaces) + "0 0 0\n", "line 7",
           "too short for 2000000000 rows");
    refuse(head("ascii", vertices + "element face 1\nproperty int vertex_indices\n"), "line 9",
           "list of vertex_indices");
    refuse(head("ascii", vertices) + "0 0 0\n0 00000000 0\n", "line 9", "after 2 of 3 rows");
    refuse(head("ascii", vertices) + "0 0 0\n0 a 0\n0 0 0\n", "line 9", "'y'");
    refuse(head("ascii", vertices) + "0 0 0\n0 0\n0 00 0\n", "line 9", "'z'");
    refuse(head("ascii", vertices) + "0 0 0\n0 nan 0\n0 0 0\n", "line 9", "non_finite_vertex");
    refuse(head("ascii", vertices + "property float s\nproperty float t\n") +
               "0 0 0 0 inf\n0 0 0 0 0\n0 0 0 0 0\n",
           "line 10", "non_finite_value");
    refuse(head("ascii", vertices) + triangle + "1\n", "line 11", "more than");
    refuse(head("ascii", vertices) + "0 0 0 0\n1 0 0\n0 1 0\n", "line 8", "more numbers");
    refuse(head("ascii", vertices + faces) + triangle + "2 0 1\n", "line 13", "at least 3");
    refuse(head("ascii", vertices + faces) + triangle + "3 0 1\n", "line 13", "'vertex_indices'");
    refuse(head("ascii", vertices + faces) + triangle + "256 0 1 2\n", "line 13",
           "none of its type");
    refuse(head("ascii", vertices + faces) + triangle + "3 0 1 1.5\n", "line 13",
           "none of its type");
    refuse(
        head("ascii", vertices + faces) + triangle + "3 0 1 3\n", "line 13",
        "index_out_of_range: 'vertex_indices' of element 'face' names number 3, but there are 3");
    refuse(head("ascii", vertices + faces + "property list uchar float texcoord\n") + triangle +
               "3 0 1 2 5 0 0 0 0 0\n",
           "line 14", "5 numbers");
    refuse(head("ascii", vertices + "comment label_g a\n" + faces + "property int label_g\n") +
               triangle + "3 0 1 2 1\n",
           "line 15", "'label_g'");
}

TEST(Ply, ErrorsNameTheByte) {
    const std::string text =
        head("binary_little_endian", "element vertex 1\n" + kPlaces +
                                         "element face 1\nproperty list uint int vertex_indices\n");
    const auto refuse = [&](const std::string& body, std::size_t byte, const std::string& says) {
        expect_refused(parse_ply(bytes_of(text + body), "a.ply"),
                       "a.ply, byte " + std::to_string(text.size() + byte), says);
    };
    const std::string places(12, '\0');
    Binary lie(false);
    lie.add<std::uint32_t>({4000000000U}).add<std::int32_t>({0, 0, 0});
    refuse(std::string(11, '\0'), 0, "too short for 1 rows");
    refuse(places, 12, "too short for 1 rows of element 'face'");
    refuse(places + lie.bytes(), 28, "missing");
    refuse(places + Binary(false).add<std::int32_t>({3, 0, 0, 1}).bytes(), 24,
           "index_out_of_range");
    refuse(places + Binary(false).add<std::int32_t>({3, 0, 0, 0, 0}).bytes(), 28, "more than");
    refuse(Binary(false).add<float>({0, INFINITY, 0}).bytes() + lie.bytes(), 4,
           "non_finite_vertex");
}

TEST(Ply, HeadsThatGrowAreRefused) {
    std::string elements;
    for (int k = 0; k < 200; ++k) elements += "element e" + std::to_string(k) + " 0\n";
    expect_refused(parse_ply(bytes_of("ply\n" + elements), "a.ply"), "a.ply, line 102",
                   "too many elements");
    // Elements without properties take no room, however many there are.
    EXPECT_EQ(ply(head("ascii", "element e 9000000000000000000\nelement vertex 1\n" + kPlaces) +
                  "1 2 3\n")
                  .vertices,
              (Vertices{{1, 2, 3}}));
}

PolygonMesh everything() {
    PolygonMesh mesh;
    mesh.vertices = {{0, 0.5, -2}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.add_polygon(std::array{0, 1, 2, 3});
    mesh.add_polygon(std::array{2, 1, 0});
    mesh.attributes = {{"uv", 2, SampleType::Float32, {0, 0.5, 1, 0.25}, {-1, -1, -1, -1, 0, 1, 0}},
                       {"colour", 3, SampleType::UInt8, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 255}}};
    mesh.labels = {{"g", {"a b", "c"}, {1, -1}}};
    mesh.libraries = {"a.mtl"};
    mesh.creases = {{0, 1, HUGE_VAL}};
    mesh.sharp_vertices = {{2, 0.5}};
    return mesh;
}

TEST(Ply, WhatIsWritten) {
    const detail::EncodedMesh file = detail::encode_ply(everything(), PlyEncoding::Ascii);
    EXPECT_EQ(file.bytes,
              "ply\nformat ascii 1.0\ncomment mtllib a.mtl\ncomment label_g a b\n"
              "comment label_g c\nelement vertex 4\nproperty float x\nproperty float y\n"
              "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
              "element face 2\nproperty list uchar int vertex_indices\n"
              "property list uchar float texcoord\nproperty int label_g\n"
              "element crease_edge 1\nproperty int vertex1\nproperty int vertex2\n"
              "property double sharpness\nelement sharp_vertex 1\nproperty int vertex1\n"
              "property double sharpness\nend_header\n"
              "0 0.5 -2 1 2 3\n1 0 0 4 5 6\n1 1 0 7 8 9\n0 1 0 10 11 255\n"
              "4 0 1 2 3 0 1\n3 2 1 0 6 0 0.5 1 0.25 0 0.5 -1\n0 1 10\n2 0.5\n");
    EXPECT_TRUE(file.left_out.empty());
    EXPECT_EQ(ply(file.bytes), everything());
    EXPECT_EQ(ply(detail::encode_ply(everything(), PlyEncoding::Binary).bytes), everything());
}

TEST(Ply, CoordinatesAreFloatsOnlyIfAllAre) {
    PolygonMesh mesh = everything();
    mesh.vertices[3][2] = 0.1;
    const std::string bytes = detail::encode_ply(mesh, PlyEncoding::Binary).bytes;
    EXPECT_NE(bytes.find("property double x"), std::string::npos);
    EXPECT_EQ(ply(bytes), mesh);
    mesh.vertices[3][2] = 1e300;
    EXPECT_EQ(ply(detail::encode_ply(mesh, PlyEncoding::Binary).bytes), mesh);
}

TEST(Ply, ListsOfMoreThan255) {
    PolygonMesh mesh = everything();
    Indices many(130);
    for (std::size_t k = 0; k < many.size(); ++k) many[k] = static_cast<std::int32_t>(k % 4);
    mesh.add_polygon(many);
    mesh.attributes[0].corners.resize(mesh.corners.size(), 1);
    mesh.labels[0].of_face.push_back(0);
    for (const PlyEncoding encoding : {PlyEncoding::Binary, PlyEncoding::Ascii})
        EXPECT_EQ(ply(detail::encode_ply(mesh, encoding).bytes), mesh);
}

TEST(Ply, NamesWhatIsLeftOut) {
    PolygonMesh mesh = everything();
    mesh.attributes.push_back({"heat", 1, SampleType::Float64, Values(4)});
    EXPECT_EQ(detail::encode_ply(mesh, PlyEncoding::Binary).left_out,
              (std::vector<std::string>{"heat"}));
}

}  // namespace
}  // namespace relief::io
