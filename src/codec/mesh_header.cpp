#include "codec/mesh_header.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "codec/decimal.h"
#include "codec/header_parts.h"
#include "codec/json_reader.h"
#include "codec/raster_header.h"
#include "relief/core/json.h"

namespace relief::codec {

namespace {

using Json = nlohmann::json;
using multires::LiftKind;
using multires::MeshScheme;

constexpr int kMostLevels = 30;
constexpr std::uint64_t kMostElements = (std::uint64_t{1} << 31) - 1;
constexpr double kLargest = 1e300;
constexpr double kMostGain = 16;

constexpr std::array<const char*, 2> kDistances = {"vertices", "surface"};

Json scheme_json(const MeshHeader& header) {
    Json json{{"name", multires::mesh_scheme_name(header.spec.scheme)}, {"levels", header.levels}};
    if (header.spec.first_even) json["first_even"] = true;
    if (header.spec.alpha) json["alpha"] = json_number(*header.spec.alpha);
    if (header.lift != LiftKind::Chebyshev) json["lift"] = multires::lift_name(header.lift);
    if (header.boundary_corners) json["boundary_corners"] = true;
    return json;
}

Status read_scheme(const Json& json, MeshHeader& header) {
    JsonReader reader(json);
    const auto name = reader.get<std::string>("name", "", true);
    header.levels = reader.get("levels", 0, true);
    header.spec.first_even = reader.get("first_even", false);
    if (json.contains("alpha")) header.spec.alpha = reader.get("alpha", 0.0);
    const auto lift = reader.get<std::string>("lift", "chebyshev");
    header.boundary_corners = reader.get("boundary_corners", false);
    RELIEF_CHECK(reader.status());
    bool known = false;
    for (const MeshScheme scheme :
         {MeshScheme::Sqrt3, MeshScheme::Loop, MeshScheme::CatmullClark}) {
        if (name != multires::mesh_scheme_name(scheme)) continue;
        header.spec.scheme = scheme;
        known = true;
    }
    const auto found =
        std::find_if(multires::kLiftKinds.begin(), multires::kLiftKinds.end(),
                     [&](LiftKind kind) { return lift == multires::lift_name(kind); });
    if (!known || found == multires::kLiftKinds.end())
        return Error{
            ErrorCode::Unsupported,
            "the scheme '" + name + "' with lift '" + lift + "' is of a newer version of relief",
            "header"};
    header.lift = *found;
    if (header.levels < 1 || header.levels > kMostLevels)
        return bad_header("the number of levels is out of range");
    if (header.spec.alpha && !(*header.spec.alpha >= 0 && *header.spec.alpha < 2.0 / 3))
        return bad_header("alpha is out of range");
    return {};
}

Json quantisation_json(const MeshQuantisation& q) {
    const MeshQuantisation plain;
    Json json{{"step", json_number(q.step)}};
    if (q.gain != plain.gain) json["gain"] = json_number(q.gain);
    if (q.tangential != plain.tangential) json["tangential"] = json_number(q.tangential);
    return json;
}

Status read_quantisation(const Json& json, MeshQuantisation& q) {
    JsonReader reader(json);
    q.step = reader.get("step", 0.0, true);
    q.gain = reader.get("gain", q.gain);
    q.tangential = reader.get("tangential", q.tangential);
    RELIEF_CHECK(reader.status());
    const auto is_size = [](double x) { return x >= 1e-300 && x <= kLargest; };
    if (is_size(q.step) && q.gain >= 1 && q.gain <= kMostGain && is_size(q.tangential)) return {};
    return bad_header("the quantisation is out of range");
}

/// Corners of the faces of most bases.
int usual_sides(const MeshHeader& header) {
    return header.spec.scheme == MeshScheme::CatmullClark ? 4 : 3;
}

Json attribute_json(const AttributeHeader& attribute) {
    Json json{{"name", attribute.name},
              {"components", attribute.components},
              {"type", sample_type_name(attribute.type)},
              {"values", lattice_json(attribute.lattice)}};
    if (attribute.elements) json["elements"] = *attribute.elements;
    return json;
}

Status read_attribute(const Json& json, AttributeHeader& attribute) {
    JsonReader reader(json);
    attribute.name = reader.get<std::string>("name", "", true);
    attribute.components = reader.get("components", 0, true);
    const auto type = reader.get<std::string>("type", "", true);
    if (json.contains("elements")) attribute.elements = reader.get<std::uint64_t>("elements", 0);
    const Json& values = reader.object("values");
    RELIEF_CHECK(reader.status());
    if (attribute.components < 1 || attribute.components > 16 ||
        attribute.elements.value_or(0) > kMostElements)
        return bad_header("an attribute is out of range");
    RELIEF_TRY(attribute.type, sample_type_from_name(type));
    return read_lattice(values, attribute.lattice);
}

Status read_labels(const Json& json, FaceLabels& labels) {
    JsonReader reader(json);
    labels.keyword = reader.get<std::string>("keyword", "", true);
    const Json& names = reader.array("names");
    RELIEF_CHECK(reader.status());
    for (const Json& name : names) {
        if (!name.is_string()) return bad_header("a label is not a text");
        labels.names.push_back(name.get<std::string>());
    }
    return {};
}

Status read_extras(JsonReader& reader, MeshHeader& header) {
    for (const Json& json : reader.array("attributes")) {
        if (!json.is_object()) return bad_header("an attribute is not an object");
        RELIEF_CHECK(read_attribute(json, header.attributes.emplace_back()));
    }
    for (const Json& json : reader.array("labels")) {
        if (!json.is_object()) return bad_header("labels are not an object");
        RELIEF_CHECK(read_labels(json, header.labels.emplace_back()));
    }
    for (const Json& json : reader.array("libraries")) {
        if (!json.is_string()) return bad_header("a library is not a text");
        header.libraries.push_back(json.get<std::string>());
    }
    return reader.status();
}

Status read_distance(JsonReader& reader, MeshDistance& distance) {
    const auto name = reader.get<std::string>("distance", kDistances[0]);
    RELIEF_CHECK(reader.status());
    const auto found = std::find(kDistances.begin(), kDistances.end(), name);
    if (found == kDistances.end())
        return Error{ErrorCode::Unsupported,
                     "errors by '" + name + "' are of a newer version of relief", "header"};
    distance = static_cast<MeshDistance>(found - kDistances.begin());
    return {};
}

}  // namespace

const char* mesh_distance_name(MeshDistance distance) {
    return kDistances[static_cast<std::size_t>(distance)];
}

std::string write_mesh_header(const MeshHeader& header) {
    Json json{{"content", kMeshContent},
              {"vertices", header.base_vertices},
              {"faces", header.base_faces},
              {"scheme", scheme_json(header)},
              {"details", quantisation_json(header.quantisation)},
              {"goal", goal_json(header.goal)}};
    if (header.sides != usual_sides(header)) json["sides"] = header.sides;
    if (Json error = error_json(header.max_error, header.rms_error, header.goal); !error.empty())
        json["error"] = std::move(error);
    if (header.distance != MeshDistance::Vertices)
        json["distance"] = mesh_distance_name(header.distance);
    if (header.lattice) json["values"] = lattice_json(*header.lattice);
    for (const AttributeHeader& attribute : header.attributes)
        json["attributes"].push_back(attribute_json(attribute));
    for (const FaceLabels& labels : header.labels)
        json["labels"].push_back(Json{{"keyword", labels.keyword}, {"names", labels.names}});
    if (!header.libraries.empty()) json["libraries"] = header.libraries;
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<MeshHeader> read_mesh_header(const std::string& text) {
    const Json json = parse_json<Json>(text);
    if (!json.is_object()) return bad_header("the header is not a JSON object");
    JsonReader reader(json);
    MeshHeader header;
    const auto content = reader.get<std::string>("content", "", true);
    RELIEF_CHECK(reader.status());
    if (content != kMeshContent)
        return Error{ErrorCode::Unsupported, "holds '" + content + "', not a mesh", "header"};
    header.base_vertices = reader.get<std::uint64_t>("vertices", 0, true);
    header.base_faces = reader.get<std::uint64_t>("faces", 0, true);
    RELIEF_CHECK(read_scheme(reader.object("scheme"), header));
    header.sides = reader.get("sides", usual_sides(header));
    RELIEF_CHECK(read_quantisation(reader.object("details"), header.quantisation));
    JsonReader error(reader.object("error"));
    header.max_error = error.get("max", 0.0);
    header.rms_error = error.get("rms", 0.0);
    RELIEF_CHECK(error.status());
    RELIEF_CHECK(read_goal(reader.object("goal"), header.goal));
    RELIEF_CHECK(read_distance(reader, header.distance));
    RELIEF_CHECK(reader.status());
    if (header.base_vertices > kMostElements || header.base_faces > kMostElements ||
        (header.sides != 0 && header.sides != 3 && header.sides != 4))
        return bad_header("the base has too many elements");
    if (json.contains("values")) {
        ValueLattice lattice;
        const Json& values = reader.object("values");
        RELIEF_CHECK(reader.status());
        RELIEF_CHECK(read_lattice(values, lattice));
        header.lattice = lattice;
    }
    RELIEF_CHECK(read_extras(reader, header));
    return header;
}

}  // namespace relief::codec
