#include "relief/core/polygon_mesh.h"

#include <gtest/gtest.h>

#include <cmath>

namespace relief {
namespace {

/// Two quads side by side, with one of everything.
PolygonMesh everything() {
    PolygonMesh mesh;
    mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}};
    mesh.add_polygon(std::array{0, 1, 4, 3});
    mesh.add_polygon(std::array{1, 2, 5, 4});
    mesh.attributes = {
        {"uv", 2, SampleType::Float32, {0, 0, 1, 0, 1, 1, 0, 1}, {0, 1, 2, 3, -1, -1, -1, -1}},
        {"colour", 3, SampleType::UInt8, std::vector<double>(18, 255)}};
    mesh.labels = {{"usemtl", {"wood", "old brass"}, {1, -1}}};
    mesh.libraries = {"a b.mtl"};
    mesh.creases = {{1, 4, 2.5}, {0, 1, HUGE_VAL}};
    mesh.sharp_vertices = {{5, 1}};
    return mesh;
}

TEST(PolygonMesh, PolygonsAndAttributes) {
    const PolygonMesh mesh = everything();
    EXPECT_TRUE(check(mesh).ok());
    EXPECT_TRUE(check(PolygonMesh()).ok());
    EXPECT_EQ(mesh.polygon_count(), 2);
    EXPECT_EQ(std::vector(mesh.polygon(1).begin(), mesh.polygon(1).end()),
              (std::vector<std::int32_t>{1, 2, 5, 4}));
    EXPECT_EQ(mesh.attribute("uv")->element_count(), 4);
    EXPECT_EQ(mesh.attribute("uv")->element(2)[1], 1);
    EXPECT_TRUE(mesh.attribute("uv")->face_varying());
    EXPECT_FALSE(mesh.attribute("colour")->face_varying());
    EXPECT_EQ(mesh.attribute("normal"), nullptr);
}

TEST(PolygonMesh, EveryRuleIsChecked) {
    const auto refuse = [](const char* rule, const std::string& where, auto spoil) {
        PolygonMesh mesh = everything();
        spoil(mesh);
        const Status status = check(mesh);
        ASSERT_FALSE(status.ok()) << rule << ' ' << where;
        EXPECT_EQ(status.error().message.substr(0, status.error().message.find(':')), rule);
        EXPECT_EQ(status.error().where, where);
        EXPECT_EQ(status.error().code, ErrorCode::BadInput);
    };
    using M = PolygonMesh&;
    refuse("wrong_size", "", [](M m) { m.offsets.clear(); });
    refuse("wrong_size", "", [](M m) { m.offsets[0] = 1; });
    refuse("wrong_size", "", [](M m) { m.offsets[2] = 7; });
    refuse("wrong_size", "polygon 0", [](M m) { m.offsets[1] = 2; });
    refuse("wrong_size", "polygon 1", [](M m) { m.offsets[1] = 9; });
    refuse("index_out_of_range", "polygon 1", [](M m) { m.corners[6] = 6; });
    refuse("index_out_of_range", "polygon 0", [](M m) { m.corners[0] = -1; });
    refuse("non_finite_vertex", "vertex 3", [](M m) { m.vertices[3][1] = NAN; });
    refuse("wrong_size", "attribute uv", [](M m) { m.attributes[0].components = 4; });
    refuse("wrong_size", "attribute colour", [](M m) { m.attributes[1].components = 2; });
    refuse("wrong_size", "attribute heat", [](M m) { m.attributes[1] = {"heat", 0}; });
    refuse("wrong_size", "attribute uv", [](M m) { m.attributes[0].values.pop_back(); });
    refuse("wrong_size", "attribute colour", [](M m) { m.attributes[1].values.resize(15); });
    refuse("wrong_size", "attribute uv", [](M m) { m.attributes[0].corners.pop_back(); });
    refuse("index_out_of_range", "attribute uv", [](M m) { m.attributes[0].corners[1] = 4; });
    refuse("index_out_of_range", "attribute uv", [](M m) { m.attributes[0].corners[1] = -2; });
    refuse("index_out_of_range", "attribute uv", [](M m) { m.attributes[0].corners[1] = -1; });
    refuse("non_finite_value", "attribute uv", [](M m) { m.attributes[0].values[1] = NAN; });
    refuse("inexact_value", "attribute uv", [](M m) { m.attributes[0].values[1] = 0.1; });
    refuse("inexact_value", "attribute colour", [](M m) { m.attributes[1].values[1] = 256; });
    refuse("named_twice", "", [](M m) { m.attributes[0].name = "colour"; });
    refuse("named_twice", "", [](M m) { m.labels.push_back(m.labels[0]); });
    refuse("unknown_keyword", "labels lod", [](M m) { m.labels[0].keyword = "lod"; });
    refuse("wrong_size", "labels usemtl", [](M m) { m.labels[0].of_face.pop_back(); });
    refuse("index_out_of_range", "labels usemtl", [](M m) { m.labels[0].of_face[0] = 2; });
    for (const char* name : {"", " wood", "wood ", "a\nb", "#wood", "wood #1"})
        refuse("bad_name", "labels usemtl", [&](M m) { m.labels[0].names[0] = name; });
    refuse("bad_name", "libraries", [](M m) { m.libraries = {"a\nv 0 0 0"}; });
    refuse("index_out_of_range", "crease 0", [](M m) { m.creases[0].b = 1; });
    refuse("index_out_of_range", "crease 1", [](M m) { m.creases[1].b = 6; });
    for (const double sharpness : {0.0, -1.0, 10.0, static_cast<double>(NAN)}) {
        refuse("bad_sharpness", "crease 0", [&](M m) { m.creases[0].sharpness = sharpness; });
        refuse("bad_sharpness", "sharp vertex 0",
               [&](M m) { m.sharp_vertices[0].sharpness = sharpness; });
    }
    refuse("index_out_of_range", "sharp vertex 0", [](M m) { m.sharp_vertices[0].vertex = -1; });
}

TEST(PolygonMesh, NamesThatALineCanEndWith) {
    for (const char* name : {"wood", "old brass", "Material#25", "a\tb", "off"})
        EXPECT_TRUE(is_label_name(name)) << name;
    for (const char* name : {"", " ", "a ", "\ta", "a\nb", "# a", "a #b", "a\\"})
        EXPECT_FALSE(is_label_name(name)) << name;
}

}  // namespace
}  // namespace relief
