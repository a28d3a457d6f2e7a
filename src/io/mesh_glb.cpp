#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "io/mesh_formats.h"
#include "io/weld.h"

// Binary glTF 2.0, https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html: a header, a chunk of
// JSON and a chunk of the numbers it describes.
namespace relief::io::detail {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kUnsignedByte = 5121;
constexpr int kUnsignedShort = 5123;
constexpr int kUnsignedInt = 5125;
constexpr int kFloat = 5126;
constexpr int kVertexData = 34962;
constexpr int kIndexData = 34963;

/// The vertices of the file, which have one element of each attribute.
struct Corners {
    std::vector<std::int32_t> vertices;  ///< of the mesh, for each vertex of the file
    std::vector<std::int32_t> corners;   ///< one of its corners; empty if these are the vertices
    std::vector<std::int32_t> numbers;   ///< for each corner of the mesh its vertex of the file
};

/// A vertex for each combination of a vertex and elements that occurs.
Corners split(const PolygonMesh& mesh) {
    std::vector<const std::vector<std::int32_t>*> parts = {&mesh.corners};
    for (const char* name : {"uv", "colour", "normal"})
        if (const MeshAttribute* attribute = mesh.attribute(name);
            attribute && attribute->face_varying())
            parts.push_back(&attribute->corners);
    Corners result;
    if (parts.size() == 1) {
        result.numbers = mesh.corners;
        for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
            result.vertices.push_back(static_cast<std::int32_t>(v));
        return result;
    }
    std::vector<double> rows;
    rows.reserve(mesh.corners.size() * parts.size());
    for (std::size_t c = 0; c < mesh.corners.size(); ++c)
        for (const auto* part : parts) rows.push_back((*part)[c]);
    Welded welded = weld(rows, parts.size());
    result.numbers = std::move(welded.numbers);
    result.corners = std::move(welded.firsts);
    for (const std::int32_t corner : result.corners)
        result.vertices.push_back(mesh.corners[static_cast<std::size_t>(corner)]);
    return result;
}

/// The element of vertex v of the file; null: it has none.
const double* element_of(const MeshAttribute& attribute, const Corners& corners, std::size_t v) {
    const std::int32_t element =
        attribute.face_varying() ? attribute.corners[static_cast<std::size_t>(corners.corners[v])]
                                 : corners.vertices[v];
    return element < 0 ? nullptr : attribute.element(element);
}

/// The middle of the box around all vertices.
Vec3 centre_of(const PolygonMesh& mesh) {
    Vec3 low = mesh.vertices[0];
    Vec3 high = low;
    for (const Vec3& vertex : mesh.vertices)
        for (std::size_t k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], vertex[k]);
            high[k] = std::max(high[k], vertex[k]);
        }
    return {0.5 * low[0] + 0.5 * high[0], 0.5 * low[1] + 0.5 * high[1],
            0.5 * low[2] + 0.5 * high[2]};
}

/// Sums of the normals of the triangles around each vertex of the mesh, by area.
std::vector<Vec3> vertex_normals(const PolygonMesh& mesh, const std::vector<Vec3>& places) {
    std::vector<Vec3> normals(places.size(), Vec3{});
    for (std::int64_t f = 0; f < mesh.polygon_count(); ++f) {
        const auto polygon = mesh.polygon(f);
        const auto vertex = [&](std::size_t k) { return static_cast<std::size_t>(polygon[k]); };
        Vec3 sum{};
        for_fan(polygon.size(), [&](std::size_t a, std::size_t b, std::size_t c) {
            const Vec3 normal =
                area_normal(places[vertex(a)], places[vertex(b)], places[vertex(c)]);
            for (std::size_t k = 0; k < 3; ++k) sum[k] += normal[k];
        });
        for (std::size_t c = 0; c < polygon.size(); ++c)
            for (std::size_t k = 0; k < 3; ++k) normals[vertex(c)][k] += sum[k];
    }
    return normals;
}

/// The binary chunk, and the JSON that describes it. Every view begins at a multiple of 4.
class Buffer {
  public:
    /// Appends an accessor of all that `write` appends. Returns its number.
    template <class Write>
    int add(const char* type, int component, std::size_t count, int target, Write write) {
        const std::size_t offset = bytes_.size();
        write(bytes_);
        views_.push_back(Json{{"buffer", 0},
                              {"byteOffset", offset},
                              {"byteLength", bytes_.size() - offset},
                              {"target", target}});
        accessors_.push_back(Json{{"bufferView", views_.size() - 1},
                                  {"componentType", component},
                                  {"count", count},
                                  {"type", type}});
        bytes_.resize((bytes_.size() + 3) / 4 * 4);
        return static_cast<int>(accessors_.size()) - 1;
    }
    Json& accessor(int number) { return accessors_[static_cast<std::size_t>(number)]; }

    [[nodiscard]] const std::string& bytes() const { return bytes_; }
    [[nodiscard]] const Json& views() const { return views_; }
    [[nodiscard]] const Json& accessors() const { return accessors_; }

  private:
    std::string bytes_;
    Json views_ = Json::array();
    Json accessors_ = Json::array();
};

void append_floats(std::string& bytes, std::span<const double> numbers) {
    constexpr double largest = std::numeric_limits<float>::max();
    for (const double number : numbers)
        append_little_endian(bytes, static_cast<float>(std::clamp(number, -largest, largest)));
}

int add_positions(Buffer& buffer, const Corners& corners, const std::vector<Vec3>& places) {
    std::array<float, 3> low{};
    std::array<float, 3> high{};
    low.fill(std::numeric_limits<float>::max());
    high.fill(std::numeric_limits<float>::lowest());
    const int number =
        buffer.add("VEC3", kFloat, corners.vertices.size(), kVertexData, [&](std::string& bytes) {
            for (const std::int32_t v : corners.vertices) {
                const Vec3& place = places[static_cast<std::size_t>(v)];
                append_floats(bytes, place);
                for (std::size_t k = 0; k < 3; ++k) {
                    low[k] = std::min(low[k], static_cast<float>(place[k]));
                    high[k] = std::max(high[k], static_cast<float>(place[k]));
                }
            }
        });
    // Numbers of JSON are doubles: a float has one that reads the same.
    for (const float bound : low) buffer.accessor(number)["min"].push_back(double{bound});
    for (const float bound : high) buffer.accessor(number)["max"].push_back(double{bound});
    return number;
}

int add_normals(Buffer& buffer, const Corners& corners, const PolygonMesh& mesh,
                const std::vector<Vec3>& places) {
    const MeshAttribute* given = mesh.attribute("normal");
    const std::vector<Vec3> computed = vertex_normals(mesh, places);
    return buffer.add(
        "VEC3", kFloat, corners.vertices.size(), kVertexData, [&](std::string& bytes) {
            for (std::size_t v = 0; v < corners.vertices.size(); ++v) {
                const double* element = given ? element_of(*given, corners, v) : nullptr;
                const Vec3& mean = computed[static_cast<std::size_t>(corners.vertices[v])];
                const Vec3 fallback = unit(mean, {0, 0, 1});
                append_floats(bytes, element ? unit({element[0], element[1], element[2]}, fallback)
                                             : fallback);
            }
        });
}

/// The first row of a picture is v = 0 in glTF, and v = 1 elsewhere.
int add_places(Buffer& buffer, const Corners& corners, const MeshAttribute& uv) {
    return buffer.add(
        "VEC2", kFloat, corners.vertices.size(), kVertexData, [&](std::string& bytes) {
            for (std::size_t v = 0; v < corners.vertices.size(); ++v) {
                const double* element = element_of(uv, corners, v);
                append_floats(
                    bytes, element ? std::array{element[0], 1 - element[1]} : std::array{0.0, 0.0});
            }
        });
}

/// Four components, because three bytes would not be aligned.
int add_colours(Buffer& buffer, const Corners& corners, const MeshAttribute& colour) {
    const bool in_bytes = colour.type == SampleType::UInt8;
    const double largest = is_integer(colour.type) ? sample_range(colour.type).second : 1;
    const auto append = [&](std::string& bytes, double value) {
        const double fraction = std::clamp(value / largest, 0.0, 1.0);
        if (in_bytes) {
            bytes += static_cast<char>(static_cast<std::uint8_t>(value));
        } else {
            append_little_endian(bytes, static_cast<float>(fraction));
        }
    };
    const int number = buffer.add(
        "VEC4", in_bytes ? kUnsignedByte : kFloat, corners.vertices.size(), kVertexData,
        [&](std::string& bytes) {
            for (std::size_t v = 0; v < corners.vertices.size(); ++v) {
                const double* element = element_of(colour, corners, v);
                for (int k = 0; k < 4; ++k)
                    append(bytes, element && k < colour.components ? element[k] : largest);
            }
        });
    if (in_bytes) buffer.accessor(number)["normalized"] = true;
    return number;
}

int add_triangles(Buffer& buffer, const Corners& corners, const PolygonMesh& mesh) {
    // The largest number of a type is not a vertex: it restarts primitives.
    const bool narrow = corners.vertices.size() <= std::numeric_limits<std::uint16_t>::max();
    const std::size_t count =
        3 * (mesh.corners.size() - 2 * static_cast<std::size_t>(mesh.polygon_count()));
    return buffer.add(
        "SCALAR", narrow ? kUnsignedShort : kUnsignedInt, count, kIndexData,
        [&](std::string& bytes) {
            for (std::size_t f = 0; f + 1 < mesh.offsets.size(); ++f) {
                const auto first = static_cast<std::size_t>(mesh.offsets[f]);
                const auto size = static_cast<std::size_t>(mesh.offsets[f + 1]) - first;
                for_fan(size, [&](std::size_t a, std::size_t b, std::size_t c) {
                    for (const std::size_t k : {a, b, c}) {
                        const auto vertex = static_cast<std::uint32_t>(corners.numbers[first + k]);
                        if (narrow) {
                            append_little_endian(bytes, static_cast<std::uint16_t>(vertex));
                        } else {
                            append_little_endian(bytes, vertex);
                        }
                    }
                });
            }
        });
}

/// Where the middle goes; what points along z is turned to point along y.
Json node_of(const Vec3& centre, Up up) {
    if (up == Up::Y) return Json{{"mesh", 0}, {"translation", centre}};
    const double root_half = std::sqrt(0.5);
    return Json{{"mesh", 0},
                {"rotation", {-root_half, 0, 0, root_half}},
                {"translation", {centre[0], centre[2], -centre[1]}}};
}

Json scene_of(const Buffer& buffer, const Json& attributes, int triangles, Json node) {
    Json root;
    root["asset"] = Json{{"version", "2.0"}, {"generator", "relief"}};
    root["scene"] = 0;
    root["scenes"] = Json::array({Json{{"nodes", Json::array({0})}}});
    root["nodes"] = Json::array({std::move(node)});
    root["meshes"] = Json::array({Json{{"primitives", Json::array({Json{{"attributes", attributes},
                                                                        {"indices", triangles},
                                                                        {"material", 0}}})}}});
    // Without a material surfaces would be metal, and would not show from behind.
    root["materials"] = Json::array(
        {Json{{"pbrMetallicRoughness", Json{{"metallicFactor", 0}}}, {"doubleSided", true}}});
    root["accessors"] = buffer.accessors();
    root["bufferViews"] = buffer.views();
    root["buffers"] = Json::array({Json{{"byteLength", buffer.bytes().size()}}});
    return root;
}

/// Requires: `numbers` has a multiple of 4 bytes.
Result<std::string> container(std::string json, const std::string& numbers) {
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::size_t total = 12 + 8 + json.size() + 8 + numbers.size();
    if (total > std::numeric_limits<std::uint32_t>::max())
        return Error{ErrorCode::BadInput, "too_many_elements: GLB holds at most 4 GiB; write .ply",
                     ""};
    std::string file = "glTF";
    file.reserve(total);
    append_little_endian(file, std::uint32_t{2});
    append_little_endian(file, static_cast<std::uint32_t>(total));
    for (const auto& [type, chunk] :
         {std::pair<const char*, const std::string&>("JSON", json),
          std::pair<const char*, const std::string&>("BIN\0", numbers)}) {
        append_little_endian(file, static_cast<std::uint32_t>(chunk.size()));
        file.append(type, 4);
        file += chunk;
    }
    return file;
}

}  // namespace

Result<EncodedMesh> encode_glb(const PolygonMesh& mesh, Up up) {
    if (mesh.polygon_count() == 0)
        return Error{ErrorCode::BadInput, "a GLB file needs at least one polygon", ""};
    const Vec3 centre = centre_of(mesh);
    std::vector<Vec3> places = mesh.vertices;
    for (std::size_t v = 0; v < places.size(); ++v)
        for (std::size_t k = 0; k < 3; ++k) {
            places[v][k] -= centre[k];
            if (!fits_float(places[v][k]))
                return Error{ErrorCode::BadInput,
                             "non_finite_vertex: it is too far from the centre for GLB, which "
                             "holds floats; write .ply or .obj",
                             fmt::format("vertex {}", v)};
        }
    const MeshAttribute* uv = mesh.attribute("uv");
    const MeshAttribute* colour = mesh.attribute("colour");
    const Corners corners = split(mesh);
    Buffer buffer;
    const int triangles = add_triangles(buffer, corners, mesh);
    Json attributes;
    attributes["POSITION"] = add_positions(buffer, corners, places);
    attributes["NORMAL"] = add_normals(buffer, corners, mesh, places);
    if (uv) attributes["TEXCOORD_0"] = add_places(buffer, corners, *uv);
    if (colour) attributes["COLOR_0"] = add_colours(buffer, corners, *colour);
    EncodedMesh file;
    RELIEF_TRY(file.bytes,
               container(scene_of(buffer, attributes, triangles, node_of(centre, up)).dump(),
                         buffer.bytes()));
    for (const MeshAttribute& attribute : mesh.attributes)
        if (&attribute != uv && &attribute != colour && attribute.name != "normal")
            file.left_out.push_back(attribute.name);
    for (std::string& name : extras_of(mesh)) file.left_out.push_back(std::move(name));
    return file;
}

}  // namespace relief::io::detail
