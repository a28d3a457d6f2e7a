#include "wire.h"

#include <array>
#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>

namespace relief::editor {

namespace {

static_assert(std::endian::native == std::endian::little,
              "arrays are sent as they lie in memory, and the protocol is little-endian");

using Json = nlohmann::ordered_json;

constexpr std::uint32_t kMagic = 0x464C4552;
constexpr std::size_t kAlignment = 8;

constexpr std::size_t padded(std::size_t bytes) {
    return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

/// How an element looks in `arrays`: a scalar, or some of them.
template <class T>
struct Element;
template <>
struct Element<float> {
    static constexpr const char* kType = "f32";
    static constexpr std::size_t kWidth = 1;
};
template <>
struct Element<std::uint32_t> {
    static constexpr const char* kType = "u32";
    static constexpr std::size_t kWidth = 1;
};
template <>
struct Element<std::int16_t> {
    static constexpr const char* kType = "i16";
    static constexpr std::size_t kWidth = 1;
};
template <>
struct Element<std::uint8_t> {
    static constexpr const char* kType = "u8";
    static constexpr std::size_t kWidth = 1;
};
template <class T, std::size_t N>
struct Element<std::array<T, N>> {
    static constexpr const char* kType = Element<T>::kType;
    static constexpr std::size_t kWidth = N * Element<T>::kWidth;
};

/// A head and the arrays that it lists, which must live until finish().
class Message {
  public:
    Message(const char* what, const Stamp& stamp)
        : head_{{"what", what}, {"id", stamp.id}, {"revision", stamp.revision}} {}

    template <class Value>
    void say(const char* key, Value&& value) {
        head_[key] = std::forward<Value>(value);
    }

    /// `width`: scalars of an element as the page counts them; 0: those of T.
    template <class T>
    void add(const char* name, const std::vector<T>& elements, std::size_t width = 0) {
        const std::size_t scalars = elements.size() * Element<T>::kWidth;
        const std::size_t wide = width == 0 ? Element<T>::kWidth : width;
        arrays_.push_back(Json{{"name", name},
                               {"type", Element<T>::kType},
                               {"width", wide},
                               {"count", scalars / wide}});
        bytes_.push_back(std::as_bytes(std::span(elements)));
    }
    /// What may be left out.
    template <class T>
    void add_some(const char* name, const std::vector<T>& elements) {
        if (!elements.empty()) add(name, elements);
    }

    [[nodiscard]] Bytes finish() {
        head_["arrays"] = std::move(arrays_);
        std::string head = head_.dump();
        head.resize(padded(head.size()), ' ');
        const std::array<std::uint32_t, 2> start = {kMagic,
                                                    static_cast<std::uint32_t>(head.size())};
        std::size_t size = sizeof start + head.size();
        for (const auto& array : bytes_) size += padded(array.size());
        Bytes message(size);
        std::uint8_t* at = message.data();
        const auto put = [&](const void* data, std::size_t count) {
            if (count > 0) std::memcpy(at, data, count);
            at += padded(count);
        };
        put(start.data(), sizeof start);
        put(head.data(), head.size());
        for (const auto& array : bytes_) put(array.data(), array.size());
        return message;
    }

  private:
    Json head_;
    Json arrays_ = Json::array();
    std::vector<std::span<const std::byte>> bytes_;
};

/// What surfaces, tiles and parts of them share.
template <class Geometry>
void add_samples(Message& message, const Geometry& geometry) {
    message.add_some("position", geometry.position);
    message.add_some("normal", geometry.normal);
    message.add_some("error", geometry.error);
    message.add_some("curvature", geometry.curvature);
}

void add_tile_samples(Message& message, const edit::TileGeometry& tile) {
    message.add_some("height", tile.height);
    message.add_some("valid", tile.valid);
    add_samples(message, tile);
}

Message of_level(const char* what, int level, const Stamp& stamp) {
    Message message(what, stamp);
    message.say("level", level);
    return message;
}

Message of_tile(const char* what, const edit::TileName& tile, const Stamp& stamp) {
    Message message(what, stamp);
    message.say("tile", Json::array({tile.lod, tile.row, tile.col}));
    return message;
}

}  // namespace

Bytes surface_message(const edit::SurfaceGeometry& surface, const Stamp& stamp) {
    Message message = of_level("surface", surface.level, stamp);
    add_samples(message, surface);
    message.add("index", surface.index, 3);
    message.add("line", surface.line, 2);
    message.add_some("uv", surface.uv);
    return message.finish();
}

Bytes surface_patch(const edit::SurfacePatch& patch, const Stamp& stamp) {
    Message message = of_level("patch", patch.level, stamp);
    message.add("at", patch.at);
    add_samples(message, patch);
    return message.finish();
}

Bytes tile_message(const edit::TileGeometry& tile, const Stamp& stamp) {
    Message message = of_tile("tile", tile.tile, stamp);
    message.say("rows", tile.rect.rows);
    message.say("cols", tile.rect.cols);
    message.say("x0", tile.x0);
    message.say("y0", tile.y0);
    message.say("x1", tile.x1);
    message.say("y1", tile.y1);
    message.say("dx", tile.dx);
    message.say("dy", tile.dy);
    add_tile_samples(message, tile);
    return message.finish();
}

Bytes tile_patch(const edit::TileGeometry& part, const Stamp& stamp) {
    Message message = of_tile("patch", part.tile, stamp);
    const LatticeBox& rect = part.rect;
    message.say("rect", Json::array({rect.row0, rect.col0, rect.rows, rect.cols}));
    add_tile_samples(message, part);
    return message.finish();
}

Bytes net_message(const edit::NetGeometry& net, const Stamp& stamp) {
    Message message = of_level("net", net.level, stamp);
    message.add("position", net.position);
    message.add("index", net.point);
    message.add("line", net.line, 2);
    message.add_some("corner", net.corner);
    return message.finish();
}

Bytes net_patch(const edit::NetGeometry& part, const Stamp& stamp) {
    Message message = of_level("net", part.level, stamp);
    message.say("patch", true);
    message.add("at", part.point);
    message.add("position", part.position);
    message.add_some("corner", part.corner);
    return message.finish();
}

}  // namespace relief::editor
