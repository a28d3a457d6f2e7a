#include "codec/quad_header.h"

#include <utility>

#include "codec/decimal.h"
#include "codec/header_parts.h"
#include "codec/json_reader.h"
#include "codec/raster_header.h"
#include "relief/core/json.h"

namespace relief::codec {

namespace {

using Json = nlohmann::json;

constexpr int kMostLevels = 30;
constexpr std::uint64_t kMostElements = (std::uint64_t{1} << 31) - 1;

Result<std::optional<int>> read_digits(const Json& json, const char* name) {
    JsonReader reader(json);
    if (!json.contains(name)) return std::optional<int>();
    const int digits = reader.get(name, 0);
    RELIEF_CHECK(reader.status());
    if (!are_digits(digits)) return bad_header(std::string("member '") + name + "' is not 0 to 15");
    return std::optional(digits);
}

}  // namespace

std::string write_quad_header(const QuadHeader& header) {
    Json json{{"content", kQuadContent},
              {"vertices", header.vertices},
              {"quads", header.quads},
              {"scheme", Json{{"name", "fvs"}, {"order", 3}, {"levels", header.levels}}},
              {"goal", goal_json(header.goal)}};
    Json error = error_json(header.max_error, header.rms_error, header.goal);
    if (header.surface_error != 0)
        error["surface"] = json_number(rounded_up(header.surface_error, 4));
    if (!error.empty()) json["error"] = std::move(error);
    if (header.x_digits) json["x_digits"] = *header.x_digits;
    if (header.y_digits) json["y_digits"] = *header.y_digits;
    if (header.lattice) json["values"] = lattice_json(*header.lattice);
    return json.dump();
}

Result<QuadHeader> read_quad_header(const std::string& text) {
    const Json json = parse_json<Json>(text);
    if (!json.is_object()) return bad_header("the header is not a JSON object");
    JsonReader reader(json);
    QuadHeader header;
    const auto content = reader.get<std::string>("content", "", true);
    RELIEF_CHECK(reader.status());
    if (content != kQuadContent)
        return Error{ErrorCode::Unsupported, "holds '" + content + "', not a quadrangulation",
                     "header"};
    header.vertices = reader.get<std::uint64_t>("vertices", 0, true);
    header.quads = reader.get<std::uint64_t>("quads", 0, true);
    JsonReader scheme(reader.object("scheme"));
    const auto name = scheme.get<std::string>("name", "", true);
    header.levels = scheme.get("levels", 0, true);
    JsonReader error(reader.object("error"));
    header.max_error = error.get("max", 0.0);
    header.rms_error = error.get("rms", 0.0);
    header.surface_error = error.get("surface", 0.0);
    RELIEF_CHECK(read_goal(reader.object("goal"), header.goal));
    RELIEF_CHECK(reader.status());
    RELIEF_CHECK(scheme.status());
    RELIEF_CHECK(error.status());
    if (name != "fvs")
        return Error{ErrorCode::Unsupported,
                     "the scheme '" + name + "' is of a newer version of relief", "header"};
    if (header.vertices > kMostElements || header.quads > kMostElements)
        return bad_header("the mesh has too many elements");
    if (header.levels < 0 || header.levels > kMostLevels)
        return bad_header("the number of levels is out of range");
    RELIEF_TRY(header.x_digits, read_digits(json, "x_digits"));
    RELIEF_TRY(header.y_digits, read_digits(json, "y_digits"));
    if (json.contains("values")) {
        ValueLattice lattice;
        const Json& values = reader.object("values");
        RELIEF_CHECK(reader.status());
        RELIEF_CHECK(read_lattice(values, lattice));
        header.lattice = lattice;
    }
    return header;
}

}  // namespace relief::codec
