#include "io/ply.h"

#include <algorithm>
#include <limits>

#include "io/mesh_formats.h"

namespace relief::io::detail::ply {

namespace {

struct TypeRow {
    std::string_view name;
    std::string_view sized_name;
    std::size_t size;
    SampleType sample;
    double lowest;
    double highest;
};

/// In the order of Type.
constexpr std::array<TypeRow, 8> kTypes = {
    {{"char", "int8", 1, SampleType::Int16, -128, 127},
     {"uchar", "uint8", 1, SampleType::UInt8, 0, 255},
     {"short", "int16", 2, SampleType::Int16, -32768, 32767},
     {"ushort", "uint16", 2, SampleType::UInt16, 0, 65535},
     {"int", "int32", 4, SampleType::Int32, -2147483648.0, 2147483647.0},
     {"uint", "uint32", 4, SampleType::UInt32, 0, 4294967295.0},
     {"float", "float32", 4, SampleType::Float32, std::numeric_limits<float>::lowest(),
      std::numeric_limits<float>::max()},
     {"double", "float64", 8, SampleType::Float64, std::numeric_limits<double>::lowest(),
      std::numeric_limits<double>::max()}}};

const TypeRow& row_of(Type type) {
    return kTypes[static_cast<std::size_t>(type)];
}

Result<Type> type_named(std::string_view word, const Lines& lines) {
    for (std::size_t k = 0; k < kTypes.size(); ++k)
        if (word == kTypes[k].name || word == kTypes[k].sized_name) return static_cast<Type>(k);
    return lines.error(quoted(word) + " is not a type of PLY, such as uchar, int or float");
}

Result<Encoding> read_encoding(Words words, const Lines& lines) {
    const std::string_view word = words.next();
    if (words.next() != "1.0") return lines.error("only version 1.0 of PLY is known");
    if (word == "ascii") return Encoding::Ascii;
    if (word == "binary_little_endian") return Encoding::BinaryLittleEndian;
    if (word == "binary_big_endian") return Encoding::BinaryBigEndian;
    return lines.error(quoted(word) + " is not a format of PLY");
}

Status read_element(Words words, const Lines& lines, Head& head) {
    Element element;
    element.name = words.next();
    if (!parse_number(words.next(), element.count) || element.count < 0)
        return lines.error("an element has a name and a number of rows");
    if (head.find(element.name))
        return lines.error("element " + quoted(element.name) + " is listed twice");
    if (head.elements.size() == kMostKinds) return lines.error("there are too many elements");
    head.elements.push_back(std::move(element));
    return {};
}

Status read_property(Words words, const Lines& lines, Head& head) {
    if (head.elements.empty()) return lines.error("a property stands before all elements");
    Property property;
    std::string_view word = words.next();
    if (word == "list") {
        RELIEF_TRY(property.count_type, type_named(words.next(), lines));
        if (!is_integer(*property.count_type))
            return lines.error("the length of a list is of an integer type");
        word = words.next();
    }
    RELIEF_TRY(property.type, type_named(word, lines));
    property.name = words.next();
    if (property.name.empty()) return lines.error("a property has a type and a name");
    head.elements.back().properties.push_back(std::move(property));
    return {};
}

/// What other programs take for remarks: names of labels and libraries.
Status read_comment(Words words, const Lines& lines, Head& head) {
    const std::string_view word = words.next();
    const std::string_view name = words.rest();
    if (word == kLibrary && is_label_name(name)) head.libraries.emplace_back(name);
    for (std::size_t k = 0; k < kLabels.size(); ++k) {
        if (word != kLabels[k].property) continue;
        if (!is_label_name(name)) return lines.error(quoted(word) + " is not followed by a name");
        head.labels[k].emplace_back(name);
    }
    return {};
}

}  // namespace

bool is_integer(Type type) {
    return type < Type::Float32;
}

std::size_t size_of(Type type) {
    return row_of(type).size;
}

std::pair<double, double> range(Type type) {
    return {row_of(type).lowest, row_of(type).highest};
}

SampleType sample_type(Type type) {
    return row_of(type).sample;
}

std::string_view name_of(SampleType type) {
    const auto is_type = [&](const TypeRow& row) { return row.sample == type && row.size > 1; };
    if (type == SampleType::UInt8) return row_of(Type::UInt8).name;
    return std::find_if(kTypes.begin(), kTypes.end(), is_type)->name;
}

double load(Type type, const std::uint8_t* bytes, bool big) {
    switch (type) {
        case Type::Int8:
            return load_number<std::int8_t>(bytes, big);
        case Type::UInt8:
            return *bytes;
        case Type::Int16:
            return load_number<std::int16_t>(bytes, big);
        case Type::UInt16:
            return load_number<std::uint16_t>(bytes, big);
        case Type::Int32:
            return load_number<std::int32_t>(bytes, big);
        case Type::UInt32:
            return load_number<std::uint32_t>(bytes, big);
        case Type::Float32:
            return load_number<float>(bytes, big);
        case Type::Float64:
            return load_number<double>(bytes, big);
    }
    return 0;
}

Property* Element::find(std::string_view property) {
    for (Property& candidate : properties)
        if (candidate.name == property) return &candidate;
    return nullptr;
}

Element* Head::find(std::string_view element) {
    for (Element& candidate : elements)
        if (candidate.name == element) return &candidate;
    return nullptr;
}

Result<Head> read_head(Lines& lines) {
    Head head;
    Words words("");
    if (!lines.next(words) || words.next() != "ply")
        return lines.error("a PLY file begins with the word ply");
    bool has_format = false;
    while (lines.next(words)) {
        const std::string_view keyword = words.next();
        if (keyword == "end_header") {
            if (!has_format) return lines.error("the head does not name a format");
            return head;
        }
        if (keyword == "format") {
            RELIEF_TRY(head.encoding, read_encoding(words, lines));
            has_format = true;
        } else if (keyword == "comment") {
            RELIEF_CHECK(read_comment(words, lines, head));
        } else if (keyword == "element") {
            RELIEF_CHECK(read_element(words, lines, head));
        } else if (keyword == "property") {
            RELIEF_CHECK(read_property(words, lines, head));
        } else if (keyword != "obj_info") {
            return lines.error(quoted(keyword) + " is not a word of the head of a PLY file");
        }
    }
    return lines.error("the head of the file has no end_header; it is cut off");
}

}  // namespace relief::io::detail::ply
