#include "codec/quad_header.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "codec/decimal.h"
#include "codec/json_reader.h"
#include "codec/raster_header.h"

namespace relief::codec {

namespace {

using Json = nlohmann::json;
using Kind = ValueLattice::Kind;

constexpr int kMostLevels = 30;
constexpr std::uint64_t kMostElements = (std::uint64_t{1} << 31) - 1;
constexpr std::int64_t kLargestMultiple = std::int64_t{1} << 50;

constexpr std::array<std::pair<Kind, const char*>, 4> kKinds = {{{Kind::Decimal, "decimal"},
                                                                 {Kind::Step, "step"},
                                                                 {Kind::Float32, "float32"},
                                                                 {Kind::Float64, "float64"}}};

Json lattice_json(const ValueLattice& lattice) {
    Json json{{"kind", lattice_name(lattice.kind)}};
    if (lattice.digits != 0) json["digits"] = lattice.digits;
    if (lattice.multiple != 1) json["multiple"] = lattice.multiple;
    if (lattice.kind == Kind::Step) json["step"] = json_number(lattice.step);
    return json;
}

bool are_digits(int digits) {
    return digits >= 0 && digits <= kMostDigits10;
}

Status read_lattice(const Json& json, ValueLattice& lattice) {
    JsonReader reader(json);
    const auto name = reader.get<std::string>("kind", "", true);
    lattice.digits = reader.get("digits", 0);
    lattice.multiple = reader.get<std::int64_t>("multiple", 1);
    lattice.step = reader.get("step", 1.0);
    RELIEF_CHECK(reader.status());
    bool known = false;
    for (const auto& [kind, kind_name] : kKinds) {
        if (name != kind_name) continue;
        lattice.kind = kind;
        known = true;
    }
    if (!known)
        return Error{ErrorCode::Unsupported,
                     "values of kind '" + name + "' are of a newer version of relief", "header"};
    if (!are_digits(lattice.digits) || lattice.multiple < 1 || lattice.multiple % 2 == 0 ||
        lattice.multiple > kLargestMultiple || !(lattice.step > 0) || !std::isfinite(lattice.step))
        return bad_header("the lattice of its values is out of range");
    return {};
}

Result<std::optional<int>> read_digits(const Json& json, const char* name) {
    JsonReader reader(json);
    if (!json.contains(name)) return std::optional<int>();
    const int digits = reader.get(name, 0);
    RELIEF_CHECK(reader.status());
    if (!are_digits(digits)) return bad_header(std::string("member '") + name + "' is not 0 to 15");
    return std::optional(digits);
}

Status read_goal(const Json& json, Goal& goal) {
    JsonReader reader(json);
    const auto name = reader.get<std::string>("kind", "lossless");
    goal.value = reader.get("value", 0.0);
    for (const auto kind : {Goal::Kind::Keep, Goal::Kind::RmsError, Goal::Kind::MaxError,
                            Goal::Kind::Bytes, Goal::Kind::Lossless})
        if (goal_name(kind) == name) goal.kind = kind;
    return reader.status();
}

}  // namespace

const char* lattice_name(Kind kind) {
    const auto* found = std::find_if(kKinds.begin(), kKinds.end(),
                                     [kind](const auto& entry) { return entry.first == kind; });
    return found->second;
}

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
    const Json json = Json::parse(text, nullptr, false);
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
