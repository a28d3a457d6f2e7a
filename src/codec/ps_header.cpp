#include "codec/ps_header.h"

#include <algorithm>
#include <array>
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
using multires::ps::GradientOptions;
using multires::ps::GradientRule;
using multires::ps::Update;

constexpr int kMostLevels = 12;
constexpr int kMostComponents = 3;
constexpr int kLargestExponent = 1100;
constexpr std::uint64_t kMostElements = (std::uint64_t{1} << 31) - 1;

template <class Value, std::size_t kCount>
using Names = std::array<std::pair<Value, const char*>, kCount>;

constexpr Names<GradientRule, 4> kRules = {{{GradientRule::Adaptive, "adaptive"},
                                            {GradientRule::Quadratic, "quadratic"},
                                            {GradientRule::Plane, "plane"},
                                            {GradientRule::Zero, "zero"}}};
constexpr Names<Update, 2> kUpdates = {{{Update::None, "none"}, {Update::Semi2Moments, "semi2m"}}};
constexpr Names<StepLaw, 3> kLaws = {
    {{StepLaw::Norm, "norm"}, {StepLaw::RootNorm, "root-norm"}, {StepLaw::Flat, "flat"}}};

template <class Value, std::size_t kCount>
const char* name_of(const Names<Value, kCount>& names, Value value) {
    return std::find_if(names.begin(), names.end(),
                        [value](const auto& entry) { return entry.first == value; })
        ->second;
}

template <class Value, std::size_t kCount>
Status read_name(const Names<Value, kCount>& names, const std::string& name, const char* what,
                 Value& value) {
    for (const auto& [known, text] : names)
        if (name == text) {
            value = known;
            return {};
        }
    return Error{ErrorCode::Unsupported,
                 std::string("the ") + what + " '" + name + "' is of a newer version of relief",
                 "header"};
}

Json base_json(const PsBaseHeader& base) {
    Json json{{"vertices", base.vertices}, {"triangles", base.triangles}};
    const PlaceGrid& grid = base.grid;
    if (grid.digits) json["digits"] = *grid.digits;
    if (grid.exponent) json["exponent"] = *grid.exponent;
    if (grid.origin) json["origin"] = json_numbers(std::array{grid.origin->x, grid.origin->y});
    if (base.peel) json["peel"] = json_number(*base.peel);
    return json;
}

Status read_base(const Json& json, PsBaseHeader& base) {
    JsonReader reader(json);
    base.vertices = reader.get<std::uint64_t>("vertices", 0, true);
    base.triangles = reader.get<std::uint64_t>("triangles", 0, true);
    const int digits = reader.get("digits", -1);
    const int exponent = reader.get("exponent", 0);
    const double peel = reader.get("peel", 0.0);
    const Json& origin = reader.array("origin");
    RELIEF_CHECK(reader.status());
    if (base.vertices > kMostElements || base.triangles > kMostElements)
        return bad_header("the mesh has too many elements");
    if (json.contains("digits")) {
        if (!are_digits(digits)) return bad_header("member 'digits' is not 0 to 15");
        base.grid.digits = digits;
    }
    if (json.contains("exponent")) {
        if (std::abs(exponent) > kLargestExponent)
            return bad_header("member 'exponent' is out of range");
        base.grid.exponent = exponent;
    }
    if (json.contains("origin")) {
        if (origin.size() != 2 || !origin[0].is_number() || !origin[1].is_number())
            return bad_header("member 'origin' is not two numbers");
        base.grid.origin = Vec2{origin[0].get<double>(), origin[1].get<double>()};
    }
    if (!base.grid.digits && !(base.grid.exponent && base.grid.origin))
        return bad_header("it does not say what its places mean");
    if (json.contains("peel")) {
        if (!(peel >= 0 && peel <= 1)) return bad_header("member 'peel' is out of range");
        base.peel = peel;
    }
    return {};
}

Json gradients_json(const GradientOptions& options) {
    const GradientOptions usual;
    Json json = Json::object();
    if (options.rule != usual.rule) json["rule"] = name_of(kRules, options.rule);
    if (options.tilt != usual.tilt) json["tilt"] = json_number(options.tilt);
    if (options.limit != usual.limit) json["limit"] = json_number(options.limit);
    return json;
}

Status read_gradients(const Json& json, GradientOptions& options) {
    JsonReader reader(json);
    const auto rule = reader.get<std::string>("rule", name_of(kRules, options.rule));
    options.tilt = reader.get("tilt", options.tilt);
    options.limit = reader.get("limit", options.limit);
    RELIEF_CHECK(reader.status());
    if (!(options.tilt >= 0 && std::isfinite(options.tilt)) || !(options.limit >= 0))
        return bad_header("the options of its gradients are out of range");
    return read_name(kRules, rule, "gradient rule", options.rule);
}

Json details_json(const PsQuantisation& quantisation) {
    Json json{{"step", json_number(quantisation.step)}};
    if (quantisation.law != StepLaw::Norm) json["law"] = name_of(kLaws, quantisation.law);
    return json;
}

Status read_details(const Json& json, PsQuantisation& quantisation) {
    JsonReader reader(json);
    quantisation.step = reader.get("step", 0.0, true);
    const auto law = reader.get<std::string>("law", name_of(kLaws, quantisation.law));
    RELIEF_CHECK(reader.status());
    if (!(quantisation.step > 0 && quantisation.step <= kLargestPsStep))
        return bad_header("the step of its details is out of range");
    return read_name(kLaws, law, "law of steps", quantisation.law);
}

Status read_lattices(const Json& list, std::size_t count, std::vector<ValueLattice>& lattices) {
    if (!list.empty() && list.size() != count)
        return bad_header("member 'values' has the wrong size");
    for (const Json& json : list) {
        if (!json.is_object()) return bad_header("member 'values' is not a list of objects");
        RELIEF_CHECK(read_lattice(json, lattices.emplace_back()));
    }
    return {};
}

Status read_scheme(const Json& json, PsHeader& header) {
    JsonReader reader(json);
    const auto name = reader.get<std::string>("name", "", true);
    header.levels = reader.get("levels", 0);
    const auto update =
        reader.get<std::string>("update", name_of(kUpdates, header.quantisation.update));
    RELIEF_CHECK(reader.status());
    if (name != kPsContent)
        return Error{ErrorCode::Unsupported,
                     "the scheme '" + name + "' is of a newer version of relief", "header"};
    if (header.levels < 0 || header.levels > kMostLevels)
        return bad_header("the number of levels is out of range");
    return read_name(kUpdates, update, "update", header.quantisation.update);
}

}  // namespace

std::string write_ps_header(const PsHeader& header) {
    Json scheme{{"name", kPsContent}};
    if (header.levels != 0) scheme["levels"] = header.levels;
    if (header.levels != 0 && header.quantisation.update != PsQuantisation().update)
        scheme["update"] = name_of(kUpdates, header.quantisation.update);
    Json json{{"content", kPsContent},
              {"base", base_json(header.base)},
              {"scheme", std::move(scheme)},
              {"goal", goal_json(header.goal)}};
    if (header.components != 1) json["components"] = header.components;
    Json error = error_json(header.max_error, header.rms_error, header.goal);
    if (header.surface_error != 0)
        error["surface"] = json_number(rounded_up(header.surface_error, 4));
    if (!error.empty()) json["error"] = std::move(error);
    if (header.gradients)
        json["gradients"] = gradients_json(*header.gradients);
    else
        json["details"] = details_json(header.quantisation);
    for (const ValueLattice& lattice : header.lattices)
        json["values"].push_back(lattice_json(lattice));
    if (!header.reference.crs.empty()) json["georeference"] = {{"crs", header.reference.crs}};
    if (!header.reference.unit.empty()) json["unit"] = header.reference.unit;
    // Bytes that are not UTF-8 are replaced, not thrown at.
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<PsHeader> read_ps_header(const std::string& text) {
    const Json json = parse_json<Json>(text);
    if (!json.is_object()) return bad_header("the header is not a JSON object");
    JsonReader reader(json);
    PsHeader header;
    const auto content = reader.get<std::string>("content", "", true);
    RELIEF_CHECK(reader.status());
    if (content != kPsContent)
        return Error{ErrorCode::Unsupported, "holds '" + content + "', not a Powell-Sabin spline",
                     "header"};
    header.components = reader.get("components", 1);
    header.reference.unit = reader.get<std::string>("unit", "");
    JsonReader georeference(reader.object("georeference"));
    header.reference.crs = georeference.get<std::string>("crs", "");
    RELIEF_CHECK(georeference.status());
    const Json& base = reader.object("base");
    const Json& scheme = reader.object("scheme");
    const Json& goal = reader.object("goal");
    const Json& error = reader.object("error");
    const Json& lattices = reader.array("values");
    const Json& gradients = reader.object("gradients");
    const Json& details = reader.object("details");
    RELIEF_CHECK(reader.status());
    if (header.components < 1 || header.components > kMostComponents)
        return bad_header("the number of components is not 1 to 3");
    RELIEF_CHECK(read_base(base, header.base));
    RELIEF_CHECK(read_scheme(scheme, header));
    RELIEF_CHECK(read_goal(goal, header.goal));
    JsonReader errors(error);
    header.max_error = errors.get("max", 0.0);
    header.rms_error = errors.get("rms", 0.0);
    header.surface_error = errors.get("surface", 0.0);
    RELIEF_CHECK(errors.status());
    RELIEF_CHECK(
        read_lattices(lattices, static_cast<std::size_t>(header.components), header.lattices));
    if (!json.contains("gradients")) {
        RELIEF_CHECK(read_details(details, header.quantisation));
        return header;
    }
    RELIEF_CHECK(read_gradients(gradients, header.gradients.emplace()));
    if (header.levels != 0 || header.lattices.empty())
        return bad_header("files of values have one level and lattices");
    return header;
}

}  // namespace relief::codec
