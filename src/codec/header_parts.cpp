#include "codec/header_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "codec/json_reader.h"
#include "codec/raster_header.h"
#include "relief/codec/container.h"
#include "relief/core/json.h"

namespace relief::codec {

namespace {

using Json = nlohmann::json;
using Kind = ValueLattice::Kind;

constexpr std::int64_t kLargestMultiple = std::int64_t{1} << 50;

constexpr std::array<std::pair<Kind, const char*>, 4> kKinds = {{{Kind::Decimal, "decimal"},
                                                                 {Kind::Step, "step"},
                                                                 {Kind::Float32, "float32"},
                                                                 {Kind::Float64, "float64"}}};

}  // namespace

const char* lattice_name(Kind kind) {
    const auto* found = std::find_if(kKinds.begin(), kKinds.end(),
                                     [kind](const auto& entry) { return entry.first == kind; });
    return found->second;
}

Json lattice_json(const ValueLattice& lattice) {
    Json json{{"kind", lattice_name(lattice.kind)}};
    if (lattice.digits != 0) json["digits"] = lattice.digits;
    if (lattice.multiple != 1) json["multiple"] = lattice.multiple;
    if (lattice.kind == Kind::Step) json["step"] = json_number(lattice.step);
    return json;
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

Status read_goal(const Json& json, Goal& goal) {
    JsonReader reader(json);
    const auto name = reader.get<std::string>("kind", "lossless");
    goal.value = reader.get("value", 0.0);
    for (const auto kind : {Goal::Kind::Keep, Goal::Kind::RmsError, Goal::Kind::MaxError,
                            Goal::Kind::Bytes, Goal::Kind::Lossless})
        if (goal_name(kind) == name) goal.kind = kind;
    return reader.status();
}

Result<std::string> content_of(std::shared_ptr<const ByteSource> source) {
    RELIEF_TRY(const ContainerReader container, ContainerReader::open(std::move(source)));
    const auto json = parse_json<Json>(container.header());
    if (!json.is_object()) return bad_header("the header is not a JSON object");
    JsonReader reader(json);
    auto content = reader.get<std::string>("content", "", true);
    RELIEF_CHECK(reader.status());
    return content;
}

}  // namespace relief::codec
