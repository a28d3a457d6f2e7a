#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/text_lines.h"
#include "relief/core/raster.h"

/// The head of PLY files: a list of elements, whose rows have the same properties.
namespace relief::io::detail::ply {

enum class Type : std::uint8_t { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };

[[nodiscard]] bool is_integer(Type type);
[[nodiscard]] std::size_t size_of(Type type);
/// The smallest and largest value.
[[nodiscard]] std::pair<double, double> range(Type type);
/// Int8 has none of its own and becomes Int16.
[[nodiscard]] SampleType sample_type(Type type);
/// "uchar", "float", ..
[[nodiscard]] std::string_view name_of(SampleType type);
/// The number in size_of(type) bytes, the highest of them first with `big`.
[[nodiscard]] double load(Type type, const std::uint8_t* bytes, bool big);

/// What becomes of the numbers of a property.
enum class Use : std::uint8_t { Skipped, Number, Index };

struct Property {
    std::string name;
    Type type = Type::Float32;
    std::optional<Type> count_type = {};  ///< of a list
    Use use = Use::Skipped;
    std::pair<double, double> limits = {};  ///< the smallest and largest Index
    std::vector<double> values = {};        ///< of all rows, unless skipped
    std::vector<std::int64_t> sizes = {};   ///< of the lists of all rows, unless skipped
};

struct Element {
    std::string name;
    std::int64_t count = 0;
    std::vector<Property> properties = {};

    [[nodiscard]] Property* find(std::string_view property);  ///< null: there is none
};

/// Labels of faces: numbers of names, which stand in comments that begin with the property.
struct LabelNames {
    const char* keyword;
    const char* property;
};
inline constexpr std::array<LabelNames, 4> kLabels = {
    {{"o", "label_o"}, {"g", "label_g"}, {"usemtl", "label_usemtl"}, {"s", "label_s"}}};

inline constexpr std::size_t kMostKinds = 100;  ///< of elements

enum class Encoding : std::uint8_t { Ascii, BinaryLittleEndian, BinaryBigEndian };

struct Head {
    Encoding encoding = Encoding::Ascii;
    std::vector<Element> elements = {};
    std::array<std::vector<std::string>, kLabels.size()> labels = {};  ///< names, of comments
    std::vector<std::string> libraries = {};                           ///< of comments

    [[nodiscard]] Element* find(std::string_view element);  ///< null: there is none
};

/// Reads up to end_header. Errors: BadInput with the line.
[[nodiscard]] Result<Head> read_head(Lines& lines);

/// Properties of vertices that are an attribute. Of several rows for one attribute the first is
/// written, and the first that is there is read.
struct VertexNames {
    const char* attribute;
    std::array<const char*, 4> properties;
    std::size_t least;
};
inline constexpr std::array<VertexNames, 5> kVertexAttributes = {
    {{"uv", {"s", "t", "p", nullptr}, 2},
     {"uv", {"u", "v", "w", nullptr}, 2},
     {"uv", {"texture_u", "texture_v", nullptr, nullptr}, 2},
     {"colour", {"red", "green", "blue", "alpha"}, 3},
     {"normal", {"nx", "ny", "nz", nullptr}, 3}}};

/// Lists of faces that are a face-varying attribute: its components corner by corner, or nothing.
struct CornerNames {
    const char* attribute;
    const char* list;
    std::size_t least;  ///< components
    std::size_t most;
};
inline constexpr std::array<CornerNames, 3> kCornerAttributes = {
    {{"uv", "texcoord", 2, 3},
     {"colour", "corner_colour", 3, 4},
     {"normal", "corner_normal", 3, 3}}};

inline constexpr std::array<const char*, 3> kPlaces = {"x", "y", "z"};
inline constexpr const char* kLibrary = "mtllib";
inline constexpr const char* kCrease = "crease_edge";
inline constexpr const char* kSharpVertex = "sharp_vertex";
inline constexpr std::array<const char*, 2> kCreaseEnds = {"vertex1", "vertex2"};
inline constexpr const char* kSharpness = "sharpness";

}  // namespace relief::io::detail::ply
