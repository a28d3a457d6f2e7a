#include <cmath>
#include <nlohmann/json.hpp>

#include "io/mesh_formats.h"
#include "io/mesh_testing.h"

namespace relief::io {
namespace {

using Json = nlohmann::json;

/// A GLB file taken apart as the specification of glTF 2.0 says; what it demands is checked.
class Glb {
  public:
    explicit Glb(const std::string& bytes) {
        const auto word = [&](std::size_t at) {
            return detail::load_number<std::uint32_t>(bytes_of(bytes).data() + at);
        };
        EXPECT_EQ(bytes.substr(0, 4), "glTF");
        EXPECT_EQ(word(4), 2U);
        EXPECT_EQ(word(8), bytes.size());
        const std::size_t json_size = word(12);
        EXPECT_EQ(bytes.substr(16, 4), "JSON");
        EXPECT_EQ(json_size % 4, 0U);
        json = Json::parse(bytes.substr(20, json_size));
        const std::size_t start = 20 + json_size;
        EXPECT_EQ(word(start) % 4, 0U);
        EXPECT_EQ(bytes.substr(start + 4, 4), std::string("BIN\0", 4));
        binary_ = bytes.substr(start + 8);
        EXPECT_EQ(binary_.size(), word(start));
        EXPECT_EQ(json["asset"]["version"], "2.0");
        EXPECT_EQ(json["buffers"].size(), 1U);
        const std::size_t size = json["buffers"][0]["byteLength"];
        EXPECT_TRUE(size <= binary_.size() && binary_.size() <= size + 3);
        EXPECT_EQ(json["scenes"][json["scene"].get<std::size_t>()]["nodes"], Json::array({0}));
        EXPECT_EQ(json["nodes"][0]["mesh"], 0);
        EXPECT_EQ(json["meshes"].size(), 1U);
        EXPECT_EQ(json["meshes"][0]["primitives"].size(), 1U);
    }

    [[nodiscard]] const Json& primitive() const { return json["meshes"][0]["primitives"][0]; }
    [[nodiscard]] const Json& accessor(const std::string& attribute) const {
        const Json& number =
            attribute == "indices" ? primitive()["indices"] : primitive()["attributes"][attribute];
        return json["accessors"][number.get<std::size_t>()];
    }

    /// All numbers of an attribute, or the indices; normalised bytes are fractions.
    [[nodiscard]] Values numbers(const std::string& attribute) const {
        const Json& numbers = accessor(attribute);
        const Json& view = json["bufferViews"][numbers["bufferView"].get<std::size_t>()];
        const std::size_t components = std::map<std::string, std::size_t>{
            {"SCALAR", 1},
            {"VEC2", 2},
            {"VEC3", 3},
            {"VEC4", 4}}.at(numbers["type"]);
        const int type = numbers["componentType"];
        const std::size_t width = type == 5121 ? 1 : type == 5123 ? 2 : 4;
        const std::size_t offset = view["byteOffset"];
        const std::size_t length = view["byteLength"];
        const std::size_t count = numbers["count"];
        EXPECT_GE(count, 1U);
        EXPECT_EQ(view["buffer"], 0);
        EXPECT_EQ(offset % 4, 0U);
        EXPECT_EQ(length, count * components * width);
        EXPECT_LE(offset + length, json["buffers"][0]["byteLength"].get<std::size_t>());
        EXPECT_EQ(view["target"], attribute == "indices" ? 34963 : 34962);
        EXPECT_TRUE(attribute == "indices" || components * width % 4 == 0) << attribute;
        Values values;
        const auto* bytes = bytes_of(binary_).data() + offset;
        for (std::size_t k = 0; k < count * components; ++k, bytes += width) {
            if (type == 5121) values.push_back(*bytes / 255.0);
            if (type == 5123) values.push_back(detail::load_number<std::uint16_t>(bytes));
            if (type == 5125) values.push_back(detail::load_number<std::uint32_t>(bytes));
            if (type == 5126) values.push_back(detail::load_number<float>(bytes));
        }
        return values;
    }

    Json json;

  private:
    std::string binary_;
};

Glb glb(const PolygonMesh& mesh) {
    const auto file = detail::encode_glb(mesh);
    EXPECT_TRUE(file.ok()) << file.error().text();
    return Glb(file->bytes);
}

PolygonMesh square() {
    PolygonMesh mesh;
    mesh.vertices = {{0, 0, 0}, {2, 0, 0}, {2, 4, 0}, {0, 4, 0}};
    mesh.add_polygon(std::array{0, 1, 2, 3});
    return mesh;
}

TEST(Glb, TrianglesAroundTheCentre) {
    PolygonMesh mesh = square();
    // Millimetres far from the origin, which floats there do not have.
    for (auto& [x, y, z] : mesh.vertices) x += 4e6, y += 5e6 + 0.001;
    const Glb file = glb(mesh);
    EXPECT_EQ(file.json["nodes"][0]["translation"], (Json{4000001.0, 5000002.001, 0.0}));
    const Values places = file.numbers("POSITION");
    ASSERT_EQ(places.size(), 12U);
    const Values expected = {-1, -2, 0, 1, -2, 0, 1, 2, 0, -1, 2, 0};
    for (std::size_t k = 0; k < 12; ++k)
        EXPECT_NEAR(places[k], expected[k], 1e-9) << "a unit in the last place of 5e6 as a double";
    EXPECT_EQ(file.accessor("POSITION")["min"], (Json{places[0], places[1], 0.0}));
    EXPECT_EQ(file.accessor("POSITION")["max"], (Json{places[6], places[7], 0.0}));
    EXPECT_EQ(file.numbers("indices"), (Values{0, 1, 2, 0, 2, 3}));
    EXPECT_EQ(file.accessor("indices")["componentType"], 5123);
    EXPECT_EQ(file.primitive().value("mode", 4), 4);
    EXPECT_EQ(file.numbers("NORMAL"), (Values{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}));
    EXPECT_FALSE(file.primitive()["attributes"].contains("TEXCOORD_0"));
    EXPECT_FALSE(file.primitive()["attributes"].contains("COLOR_0"));
}

TEST(Glb, HeightsPointUp) {
    PolygonMesh mesh = square();
    for (auto& [x, y, z] : mesh.vertices) x += 10, y += 20, z += 30;
    const auto encoded = detail::encode_glb(mesh, Up::Z);
    ASSERT_TRUE(encoded.ok());
    const Glb file(encoded->bytes);
    const Json& node = file.json["nodes"][0];
    // The middle (11, 22, 30) with z up is (11, 30, -22) with y up.
    EXPECT_EQ(node["translation"], (Json{11.0, 30.0, -22.0}));
    // A quaternion (x, y, z, w) that takes (0, 0, 1) to (0, 1, 0): v + 2 q x (q x v + w v).
    const Values q = node["rotation"].get<Values>();
    EXPECT_EQ(q[1], 0);
    EXPECT_EQ(q[2], 0);
    EXPECT_NEAR(-2 * q[0] * q[3], 1, 1e-15) << "y of the turned z axis: -2 x w";
    EXPECT_NEAR(1 - 2 * q[0] * q[0], 0, 1e-15) << "its z: 1 - 2 x^2";
    EXPECT_EQ(file.numbers("POSITION"), glb(mesh).numbers("POSITION"));
}

TEST(Glb, BoundsAreThoseOfTheStoredFloats) {
    PolygonMesh mesh = square();
    mesh.vertices = {{0.1, 0.2, 0.3}, {1.0 / 3, 2.0 / 3, -0.7}, {-0.9, 1e-9, 0}, {5e-324, 7, 1}};
    const Glb file = glb(mesh);
    const Values places = file.numbers("POSITION");
    for (std::size_t k = 0; k < 3; ++k) {
        double low = HUGE_VAL;
        double high = -HUGE_VAL;
        for (std::size_t v = 0; v < 4; ++v) {
            low = std::min(low, places[3 * v + k]);
            high = std::max(high, places[3 * v + k]);
        }
        EXPECT_EQ(file.accessor("POSITION")["min"][k], low);
        EXPECT_EQ(file.accessor("POSITION")["max"][k], high);
    }
}

TEST(Glb, NormalsAreMeansByArea) {
    PolygonMesh mesh;
    mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 3, 0}, {0, 0, 1}, {9, 9, 9}};
    mesh.add_polygon(std::array{0, 1, 2});  // doubled area 3, normal +z
    mesh.add_polygon(std::array{0, 3, 1});  // doubled area 1, normal +y
    const Values normals = glb(mesh).numbers("NORMAL");
    const auto normal = [&](std::size_t v) {
        return std::array{normals[3 * v], normals[3 * v + 1], normals[3 * v + 2]};
    };
    const auto f = [](double number) { return static_cast<double>(static_cast<float>(number)); };
    const double root = std::sqrt(10.0);
    EXPECT_EQ(normal(0), (std::array{0.0, f(1 / root), f(3 / root)}));
    EXPECT_EQ(normal(1), normal(0));
    EXPECT_EQ(normal(2), (std::array{0.0, 0.0, 1.0}));
    EXPECT_EQ(normal(3), (std::array{0.0, 1.0, 0.0}));
    EXPECT_EQ(normal(4), (std::array{0.0, 0.0, 1.0})) << "of no polygon";
}

TEST(Glb, GivenNormalsGetLengthOne) {
    PolygonMesh mesh = square();
    mesh.attributes = {{"normal", 3, SampleType::Float64, {3, 0, 4, 0, 0, 0, 0, -2, 0, 1, 0, 0}}};
    const Glb file = glb(mesh);
    const Values normals = file.numbers("NORMAL");
    const Values expected = {
        static_cast<double>(0.6F), 0, static_cast<double>(0.8F), 0, 0, 1, 0, -1, 0, 1, 0, 0};
    EXPECT_EQ(normals, expected) << "a normal of length zero is replaced";
}

TEST(Glb, TexturePlacesAndColours) {
    PolygonMesh mesh = square();
    mesh.attributes = {{"uv", 2, SampleType::Float64, {0, 0, 1, 0.25, 0.5, 1, 0, 1}},
                       {"colour", 3, SampleType::UInt8, {255, 0, 0, 0, 51, 0, 0, 0, 255, 1, 2, 3}}};
    const Glb file = glb(mesh);
    EXPECT_EQ(file.numbers("TEXCOORD_0"), (Values{0, 1, 1, 0.75, 0.5, 0, 0, 0}));
    EXPECT_EQ(file.numbers("COLOR_0"), (Values{1, 0, 0, 1, 0, 51 / 255.0, 0, 1, 0, 0, 1, 1,
                                               1 / 255.0, 2 / 255.0, 3 / 255.0, 1}));
    EXPECT_EQ(file.accessor("COLOR_0")["normalized"], true);
    mesh.attributes = {
        {"colour", 4, SampleType::Float32, {0.5, 2, -1, 0.25, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}}};
    const Values colours = glb(mesh).numbers("COLOR_0");
    EXPECT_EQ(Values(colours.begin(), colours.begin() + 4), (Values{0.5, 1, 0, 0.25}));
    mesh.attributes = {
        {"colour", 3, SampleType::UInt16, {65535, 0, 13107, 0, 0, 0, 0, 0, 0, 0, 0, 0}}};
    const Values words = glb(mesh).numbers("COLOR_0");
    EXPECT_EQ(Values(words.begin(), words.begin() + 4),
              (Values{1, 0, static_cast<double>(0.2F), 1}));
}

TEST(Glb, VerticesAreSplitAtSeams) {
    PolygonMesh mesh = square();
    mesh.add_polygon(std::array{1, 0, 2});
    mesh.attributes = {
        {"uv", 2, SampleType::Float64, {0, 0, 1, 0, 0.5, 0.5}, {0, 1, 1, 0, 2, 0, 1}}};
    const Glb file = glb(mesh);
    // (0, 0) (1, 1) (2, 1) (3, 0) (1, 2): corner (0, 0) and corner (2, 1) are shared.
    EXPECT_EQ(file.numbers("indices"), (Values{0, 1, 2, 0, 2, 3, 4, 0, 2}));
    EXPECT_EQ(file.numbers("POSITION"), (Values{-1, -2, 0, 1, -2, 0, 1, 2, 0, -1, 2, 0, 1, -2, 0}));
    EXPECT_EQ(file.numbers("TEXCOORD_0"), (Values{0, 1, 1, 1, 1, 1, 0, 1, 0.5, 0.5}));
    mesh.attributes[0].corners = {0, 1, 1, 0, -1, -1, -1};
    EXPECT_EQ(glb(mesh).numbers("TEXCOORD_0"), (Values{0, 1, 1, 1, 1, 1, 0, 1, 0, 0, 0, 0, 0, 0}));
}

TEST(Glb, WideIndices) {
    for (const std::int32_t count : {65535, 65536}) {
        PolygonMesh mesh;
        mesh.vertices.resize(static_cast<std::size_t>(count), {1, 2, 3});
        mesh.add_polygon(std::array{0, 1, count - 1});
        const Glb file = glb(mesh);
        EXPECT_EQ(file.accessor("indices")["componentType"], count == 65535 ? 5123 : 5125);
        EXPECT_EQ(file.numbers("indices"), (Values{0, 1, static_cast<double>(count - 1)}));
    }
}

TEST(Glb, WhatItCanNotHold) {
    PolygonMesh mesh = square();
    mesh.attributes = {{"heat", 1, SampleType::Float64, Values(4)}};
    mesh.creases = {{0, 1, 1}};
    EXPECT_EQ(detail::encode_glb(mesh)->left_out, (std::vector<std::string>{"heat", "crease"}));
    mesh.vertices[1][0] = 1e39;
    expect_refused(detail::encode_glb(mesh), "vertex 0", "too far from the centre");
    expect_refused(detail::encode_glb(PolygonMesh()), "", "at least one polygon");
}

}  // namespace
}  // namespace relief::io
