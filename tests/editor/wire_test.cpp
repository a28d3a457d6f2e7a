#include "wire.h"

#include <cstring>
#include <nlohmann/json.hpp>

namespace relief::editor {
namespace {

using Json = nlohmann::json;

/// A message taken apart as docs/protocol.md says, apart from the writer.
struct Parts {
    Json head;
    std::size_t head_end = 0;

    explicit Parts(const Bytes& message) {
        std::uint32_t start[2] = {};
        std::memcpy(start, message.data(), sizeof start);
        EXPECT_EQ(start[0], 0x464C4552U);
        head_end = 8 + start[1];
        EXPECT_EQ(head_end % 8, 0U);
        head = Json::parse(message.begin() + 8, message.begin() + static_cast<long>(head_end));
    }
};

/// The array of a name, as bytes.
template <class T>
std::vector<T> array_of(const Bytes& message, const char* name) {
    const Parts parts(message);
    std::size_t at = parts.head_end;
    for (const Json& array : parts.head["arrays"]) {
        const std::string type = array["type"];
        const std::size_t scalar = type == "u8" ? 1 : type == "i16" ? 2 : 4;
        const std::size_t count =
            array["width"].get<std::size_t>() * array["count"].get<std::size_t>();
        if (array["name"] == name) {
            EXPECT_EQ(sizeof(T), scalar) << name;
            std::vector<T> values(count);
            std::memcpy(values.data(), message.data() + at, count * scalar);
            return values;
        }
        at += (count * scalar + 7) / 8 * 8;
    }
    ADD_FAILURE() << "no array " << name;
    return {};
}

Json shape(const char* name, const char* type, int width, int count) {
    return {{"name", name}, {"type", type}, {"width", width}, {"count", count}};
}

edit::SurfaceGeometry triangle() {
    edit::SurfaceGeometry surface;
    surface.level = 2;
    surface.position = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5F}};
    surface.normal = {{0, 0, 32767, 0}, {0, 0, 32767, 0}, {1, -2, 3, 0}};
    surface.index = {0, 1, 2};
    surface.line = {0, 1, 1, 2, 2, 0};
    return surface;
}

// Written by hand from docs/protocol.md.
TEST(Wire, PatchOfOneVertexByteByByte) {
    edit::SurfacePatch patch;
    patch.level = 3;
    patch.at = {7};
    patch.error = {0.5F};
    const std::string head = R"({"what":"patch","id":9,"revision":4,"level":3,"arrays":[)"
                             R"({"name":"at","type":"u32","width":1,"count":1},)"
                             R"({"name":"error","type":"f32","width":1,"count":1}]})";
    std::string expected = "RELF";
    const std::size_t padded = (head.size() + 7) / 8 * 8;
    expected += static_cast<char>(padded);
    expected += std::string(3, '\0') + head + std::string(padded - head.size(), ' ');
    expected += std::string("\x07\0\0\0\0\0\0\0", 8) + std::string("\0\0\0\x3f\0\0\0\0", 8);
    const Bytes message = surface_patch(patch, {9, 4});
    EXPECT_EQ(std::string(message.begin(), message.end()), expected);
}

TEST(Wire, SurfaceHasItsArraysInOrder) {
    const Bytes message = surface_message(triangle(), {7, 1});
    const Json head = Parts(message).head;
    EXPECT_EQ(head["what"], "surface");
    EXPECT_EQ(head["id"], 7);
    EXPECT_EQ(head["revision"], 1);
    EXPECT_EQ(head["level"], 2);
    EXPECT_EQ(head["arrays"],
              Json::array({shape("position", "f32", 3, 3), shape("normal", "i16", 4, 3),
                           shape("index", "u32", 3, 1), shape("line", "u32", 2, 3)}));
    EXPECT_EQ(array_of<float>(message, "position"),
              (std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0.5F}));
    EXPECT_EQ(array_of<std::int16_t>(message, "normal"),
              (std::vector<std::int16_t>{0, 0, 32767, 0, 0, 0, 32767, 0, 1, -2, 3, 0}));
    EXPECT_EQ(array_of<std::uint32_t>(message, "line"),
              (std::vector<std::uint32_t>{0, 1, 1, 2, 2, 0}));
    EXPECT_EQ(message.size() % 8, 0U);
}

TEST(Wire, ExtrasAreListedOnlyIfTheyAreThere) {
    edit::SurfaceGeometry surface = triangle();
    surface.curvature = {1, 2, 3};
    surface.uv = {{0, 0}, {1, 0}, {0, 1}};
    const Json arrays = Parts(surface_message(surface, {})).head["arrays"];
    ASSERT_EQ(arrays.size(), 6U);
    EXPECT_EQ(arrays[2], shape("curvature", "f32", 1, 3));
    EXPECT_EQ(arrays[5], shape("uv", "f32", 2, 3));
}

TEST(Wire, TileSaysWhereItLies) {
    edit::TileGeometry tile;
    tile.tile = {1, 2, 3};
    tile.rect = {0, 0, 1, 3};
    tile.x0 = 10;
    tile.y0 = 20;
    tile.x1 = 13.5;
    tile.y1 = 20;
    tile.dx = 2;
    tile.dy = -2;
    tile.height = {1, 2, 3};
    tile.normal = {{0, 0, 1, 0}, {0, 0, 2, 0}, {0, 0, 3, 0}};
    tile.valid = {1, 0, 1};
    const Bytes message = tile_message(tile, {5, 6});
    Json head = Parts(message).head;
    EXPECT_EQ(head.erase("arrays"), 1U);
    EXPECT_EQ(head, (Json{{"what", "tile"},
                          {"id", 5},
                          {"revision", 6},
                          {"tile", {1, 2, 3}},
                          {"rows", 1},
                          {"cols", 3},
                          {"x0", 10.0},
                          {"y0", 20.0},
                          {"x1", 13.5},
                          {"y1", 20.0},
                          {"dx", 2.0},
                          {"dy", -2.0}}));
    EXPECT_EQ(array_of<float>(message, "height"), (std::vector<float>{1, 2, 3}));
    EXPECT_EQ(array_of<std::uint8_t>(message, "valid"), (std::vector<std::uint8_t>{1, 0, 1}));

    tile.rect = {4, 5, 1, 3};
    const Json patch = Parts(tile_patch(tile, {5, 6})).head;
    EXPECT_EQ(patch["what"], "patch");
    EXPECT_EQ(patch["tile"], Json::array({1, 2, 3}));
    EXPECT_EQ(patch["rect"], Json::array({4, 5, 1, 3}));
}

TEST(Wire, NetNamesItsPointsAndPatchesItsPlaces) {
    edit::NetGeometry net;
    net.level = 1;
    net.position = {{0, 0, 1}, {1, 0, 2}};
    net.point = {40, 41};
    net.line = {0, 1};
    net.corner = {{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, {{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}}};
    const Bytes whole = net_message(net, {});
    EXPECT_EQ(Parts(whole).head["arrays"],
              Json::array({shape("position", "f32", 3, 2), shape("index", "u32", 1, 2),
                           shape("line", "u32", 2, 1), shape("corner", "f32", 9, 2)}));
    EXPECT_EQ(array_of<std::uint32_t>(whole, "index"), (std::vector<std::uint32_t>{40, 41}));
    EXPECT_FALSE(Parts(whole).head.contains("patch"));

    net.point = {1, 0};
    const Json patch = Parts(net_patch(net, {})).head;
    EXPECT_EQ(patch["patch"], true);
    EXPECT_EQ(patch["arrays"],
              Json::array({shape("at", "u32", 1, 2), shape("position", "f32", 3, 2),
                           shape("corner", "f32", 9, 2)}));
}

}  // namespace
}  // namespace relief::editor
