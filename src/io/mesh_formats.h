#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "relief/core/polygon_mesh.h"
#include "relief/io/mesh.h"

/// What the readers and writers of mesh files share.
namespace relief::io::detail {

inline std::string_view text_of(std::span<const std::uint8_t> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// What keeps a mesh of a file within the limits of PolygonMesh.
inline constexpr std::int64_t kMostElements = 0x7FFFFFFF;
inline constexpr const char* kTooMany =
    "too_many_elements: a mesh has at most 2^31 - 1 vertices, polygons and corners; split it";

/// Sharpness as files have it, finite, and as meshes have it.
inline double sharpness_in_file(double sharpness) {
    return std::min(sharpness, kSharpest);
}
inline double sharpness_in_mesh(double sharpness) {
    return sharpness >= kSharpest ? HUGE_VAL : sharpness;
}

/// "OFF", perhaps with ST, C and N before it.
[[nodiscard]] bool is_off_keyword(std::string_view word);
[[nodiscard]] bool is_ascii_stl(std::span<const std::uint8_t> bytes);
/// Whether the bytes are as many as a binary STL file says.
[[nodiscard]] bool is_binary_stl(std::span<const std::uint8_t> bytes);

/// The bytes of a file, and the names of what it does not hold.
struct EncodedMesh {
    std::string bytes;
    std::vector<std::string> left_out;
};
/// The names of all that a mesh has besides vertices and polygons, for the formats that keep none
/// of labels, libraries and creases.
[[nodiscard]] std::vector<std::string> extras_of(const PolygonMesh& mesh);

/// Require: the mesh passes relief::check.
[[nodiscard]] EncodedMesh encode_off(const PolygonMesh& mesh);
[[nodiscard]] EncodedMesh encode_obj(const PolygonMesh& mesh);
[[nodiscard]] EncodedMesh encode_ply(const PolygonMesh& mesh, PlyEncoding encoding);
[[nodiscard]] Result<EncodedMesh> encode_stl(const PolygonMesh& mesh);
[[nodiscard]] Result<EncodedMesh> encode_glb(const PolygonMesh& mesh, Up up = Up::Y);

/// Calls triangle(i, j, k) with the places in a polygon of `size` corners: a fan from its first.
template <class Function>
void for_fan(std::size_t size, Function&& triangle) {
    for (std::size_t k = 2; k < size; ++k) triangle(std::size_t{0}, k - 1, k);
}

/// Whether a float can be as large.
inline bool fits_float(double value) {
    return std::abs(value) <= std::numeric_limits<float>::max();
}

using Vec3 = std::array<double, 3>;

/// Across a triangle, as long as twice its area; counter-clockwise seen from its tip.
inline Vec3 area_normal(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 u = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const Vec3 v = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}

/// The same direction with length 1; `otherwise` if there is none.
inline Vec3 unit(const Vec3& v, const Vec3& otherwise) {
    const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!(length > 0) || !std::isfinite(length)) return otherwise;
    return {v[0] / length, v[1] / length, v[2] / length};
}

/// Appends the bytes of a number, the lowest first.
template <class Number>
void append_little_endian(std::string& bytes, Number number) {
    char raw[sizeof number];
    std::memcpy(raw, &number, sizeof number);
    if constexpr (std::endian::native == std::endian::big) std::reverse(raw, raw + sizeof number);
    bytes.append(raw, sizeof number);
}

/// A number of which the first byte is the lowest, or with `big` the highest.
template <class Number>
Number load_number(const std::uint8_t* bytes, bool big = false) {
    std::uint8_t raw[sizeof(Number)];
    std::memcpy(raw, bytes, sizeof raw);
    if (big != (std::endian::native == std::endian::big)) std::reverse(raw, raw + sizeof raw);
    Number number;
    std::memcpy(&number, raw, sizeof raw);
    return number;
}

}  // namespace relief::io::detail
