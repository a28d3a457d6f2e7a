#include "codec/raster_header.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "codec/decimal.h"
#include "codec/json_reader.h"
#include "relief/core/json.h"

namespace relief::codec {

namespace {

using Json = nlohmann::json;

constexpr std::array<std::string_view, 5> kGoals = {"keep", "rms-error", "max-error", "bytes",
                                                    "lossless"};

using Reader = JsonReader;
constexpr auto bad = bad_header;

Json georeference_json(const GeoReference& geo) {
    Json json = Json::object();
    if (geo.transform) json["transform"] = json_numbers(*geo.transform);
    if (!geo.crs.empty()) json["crs"] = geo.crs;
    if (geo.pixel_is_point) json["point"] = true;
    return json;
}

Status read_georeference(const Json& json, GeoReference& geo) {
    Reader reader(json);
    geo.crs = reader.get<std::string>("crs", "");
    geo.pixel_is_point = reader.get("point", false);
    const Json& transform = reader.array("transform");
    if (!transform.empty()) {
        std::array<double, 6> values{};
        if (transform.size() != 6) return bad("the geotransform has not 6 numbers");
        for (std::size_t k = 0; k < 6; ++k) {
            if (!transform[k].is_number()) return bad("the geotransform has not 6 numbers");
            values[k] = transform[k].get<double>();
        }
        geo.transform = values;
    }
    return reader.status();
}

Json scheme_json(const multires::SchemeSpec& spec) {
    Json json{{"name", multires::scheme_name(spec.id)}, {"levels", spec.levels}};
    if (spec.order != 2) json["order"] = spec.order;
    if (spec.id == multires::SchemeId::Barycentric) {
        if (spec.family != multires::SchemeSpec().family)
            json["family"] = multires::family_name(spec.family);
        if (spec.dual_order != 0) json["dual"] = spec.dual_order;
    }
    if (spec.id == multires::SchemeId::Cubic) {
        if (spec.exact) json["exact"] = true;
    } else if (spec.order > 1 && spec.data_map != multires::DataMap::Interpolate) {
        json["map"] = multires::data_map_name(spec.data_map);
    }
    return json;
}

Status read_scheme(const Json& json, multires::SchemeSpec& spec) {
    Reader reader(json);
    const auto name = reader.get<std::string>("name", "", true);
    spec.order = reader.get("order", 2);
    spec.levels = reader.get("levels", 0, true);
    spec.dual_order = reader.get("dual", 0);
    spec.exact = reader.get("exact", false);
    const auto family = reader.get<std::string>("family", "compact");
    const auto map = reader.get<std::string>("map", "interpolate");
    RELIEF_CHECK(reader.status());
    const auto newer = [](const Error& error) {
        return Error{ErrorCode::Unsupported,
                     error.message + "; a newer version of relief may read it", "header"};
    };
    const auto scheme = multires::scheme_from_name(name);
    if (!scheme.ok()) return newer(scheme.error());
    const auto family_id = multires::family_from_name(family);
    if (!family_id.ok()) return newer(family_id.error());
    const auto map_id = multires::data_map_from_name(map);
    if (!map_id.ok()) return newer(map_id.error());
    if (spec.levels < 0) return bad("the number of levels is negative");
    spec.id = *scheme;
    spec.family = *family_id;
    spec.data_map = *map_id;
    return {};
}

Json lattice_json(const LatticeCoding& coding) {
    Json json{{"profile", profile_name(coding.profile)}};
    if (coding.tightening != 1) json["tightening"] = json_number(coding.tightening);
    const LatticeMargin& margin = coding.margin;
    if (margin != LatticeMargin()) json["margin"] = Json::array({margin.rows, margin.cols});
    for (const IntegerDomain& domain : coding.domains) {
        Json item{{"unit", json_number(domain.unit)}, {"highest", domain.highest}};
        if (domain.origin != 0) item["origin"] = json_number(domain.origin);
        if (domain.step != 1) item["step"] = domain.step;
        if (domain.lattice) item["lattice"] = true;
        if (domain.floats) item["floats"] = true;
        if (domain.raw_bits != 0) item["raw_bits"] = domain.raw_bits;
        json["domains"].push_back(std::move(item));
    }
    return json;
}

Status read_domain(const Json& json, IntegerDomain& domain) {
    constexpr std::int32_t largest = 1 << 29;
    Reader reader(json);
    domain.unit = reader.get("unit", 0.0, true);
    domain.highest = reader.get<std::int32_t>("highest", 0, true);
    domain.origin = reader.get("origin", 0.0);
    domain.step = reader.get<std::int32_t>("step", 1);
    domain.lattice = reader.get("lattice", false);
    domain.floats = reader.get("floats", false);
    domain.raw_bits = reader.get("raw_bits", 0);
    RELIEF_CHECK(reader.status());
    if (!(domain.unit > 0) || !std::isfinite(domain.unit) || !(std::abs(domain.origin) < 0x1p53) ||
        domain.origin != std::floor(domain.origin))
        return bad("the unit or origin of its integers is out of range");
    if (domain.highest < 0 || domain.highest >= largest || domain.step < 1 ||
        domain.step > largest || domain.step % 2 == 0)
        return bad("the range or step of its integers is out of range");
    if (domain.raw_bits < 0 || domain.raw_bits > kMostRawBits)
        return bad("the number of its raw bits is out of range");
    return {};
}

Status read_margin(const Json& json, const Raster& raster, LatticeMargin& margin) {
    if (json.empty()) return {};
    const auto is_bit = [](const Json& item) { return item == 0 || item == 1; };
    if (json.size() != 2 || !is_bit(json[0]) || !is_bit(json[1]))
        return bad("the margin of its lattice is not two times 0 or 1");
    margin = {json[0].get<std::int64_t>(), json[1].get<std::int64_t>()};
    if (raster.rows + margin.rows > INT32_MAX || raster.cols + margin.cols > INT32_MAX)
        return bad("the size of its lattice is out of range");
    return {};
}

Status read_lattice(const Json& json, RasterHeader& header) {
    Reader reader(json);
    LatticeCoding coding;
    const auto profile = reader.get<std::string>("profile", "", true);
    coding.tightening = reader.get("tightening", 1.0);
    const Json& domains = reader.array("domains");
    const Json& margin = reader.array("margin");
    RELIEF_CHECK(reader.status());
    RELIEF_CHECK(read_margin(margin, header.description, coding.margin));
    coding.profile = profile == profile_name(Profile::Fast) ? Profile::Fast : Profile::Dense;
    if (profile != profile_name(coding.profile))
        return Error{ErrorCode::Unsupported,
                     "the profile '" + profile + "' is of a newer version of relief", "header"};
    if (!(coding.tightening >= 1 && coding.tightening <= 4))
        return bad("the tightening of its steps is out of range");
    if (domains.size() != static_cast<std::size_t>(header.components))
        return bad("the number of its integer domains is not that of its components");
    for (const Json& item : domains) {
        if (!item.is_object()) return bad("an integer domain is not an object");
        RELIEF_CHECK(read_domain(item, coding.domains.emplace_back()));
    }
    coding.type = header.description.type;
    coding.nodata = header.description.nodata;
    header.lattice = std::move(coding);
    return {};
}

Json pyramid_json(const PyramidCoding& coding) {
    Json json{{"planes", coding.layers}};
    if (coding.exponents.empty())
        json["step"] = json_number(coding.step);
    else
        json["exponents"] = coding.exponents;
    json["means"] = json_numbers(coding.means);
    std::vector<double> bounds = coding.bounds;
    while (bounds.size() > 1 && bounds.back() == bounds[bounds.size() - 2]) bounds.pop_back();
    if (!bounds.empty()) json["bounds"] = json_numbers(bounds);
    return json;
}

/// A list of numbers, each within +-largest.
template <class T>
Status read_list(const Json& json, T largest, const char* what, std::vector<T>& list) {
    list.clear();
    for (const Json& item : json) {
        const bool right = std::is_integral_v<T> ? item.is_number_integer() : item.is_number();
        if (!right || !(std::abs(item.get<double>()) <= static_cast<double>(largest)))
            return bad(std::string("a number of its ") + what + " is out of range");
        list.push_back(item.get<T>());
    }
    return {};
}

Status read_pyramid(const Json& json, RasterHeader& header) {
    constexpr double largest = 1e100;
    constexpr int most_planes = 31;
    Reader reader(json);
    PyramidCoding coding;
    coding.step = reader.get("step", 1.0);
    RELIEF_CHECK(read_list(reader.array("exponents"), 300, "exponents", coding.exponents));
    RELIEF_CHECK(read_list(reader.array("planes"), most_planes, "planes", coding.layers));
    RELIEF_CHECK(read_list(reader.array("means"), largest, "means", coding.means));
    for (const Json& bound : reader.array("bounds"))
        coding.bounds.push_back(bound.is_number() ? std::abs(bound.get<double>()) : INFINITY);
    RELIEF_CHECK(reader.status());
    if (!(coding.step > 1e-300 && coding.step <= largest))
        return bad("the step of its quantiser is out of range");
    const auto falls = [](int a, int b) { return a <= b; };
    if (coding.layers.empty() || coding.layers.back() != 0 ||
        std::adjacent_find(coding.layers.begin(), coding.layers.end(), falls) !=
            coding.layers.end())
        return bad("the planes of its layers do not descend to 0");
    if (coding.means.size() != static_cast<std::size_t>(header.components))
        return bad("the number of its means is not that of its components");
    header.pyramid = std::move(coding);
    return {};
}

Status read_names(const Json& json, Raster& description) {
    Reader reader(json);
    for (const Json& name : reader.array("bands")) {
        if (!name.is_string()) return bad("a band name is not a text");
        description.band_names.push_back(name.get<std::string>());
    }
    for (const Json& item : reader.array("metadata")) {
        if (!item.is_array() || item.size() != 2 || !item[0].is_string() || !item[1].is_string())
            return bad("a metadata item is not a pair of texts");
        description.metadata.emplace_back(item[0].get<std::string>(), item[1].get<std::string>());
    }
    return reader.status();
}

Status read_description(const Json& json, RasterHeader& header) {
    Reader reader(json);
    Raster& raster = header.description;
    raster.rows = reader.get<std::int64_t>("rows", 0, true);
    raster.cols = reader.get<std::int64_t>("cols", 0, true);
    header.components = reader.get("components", 1);
    header.has_mask = reader.get("mask", false);
    const auto type = sample_type_from_name(reader.get<std::string>("type", "", true));
    raster.unit = reader.get<std::string>("unit", "");
    raster.scale = reader.get("scale", 1.0);
    raster.offset = reader.get("offset", 0.0);
    if (json.contains("nodata")) raster.nodata = reader.get("nodata", 0.0);
    RELIEF_CHECK(reader.status());
    if (!type.ok()) return bad(type.error().message);
    if (raster.rows < 1 || raster.cols < 1 || raster.rows > INT32_MAX || raster.cols > INT32_MAX)
        return bad("the raster size is out of range");
    if (header.components < 1 || header.components > 4)
        return bad("the number of components is not 1 to 4");
    raster.type = *type;
    RELIEF_CHECK(read_georeference(reader.object("georeference"), raster.geo));
    return read_names(json, raster);
}

}  // namespace

std::string_view profile_name(Profile profile) {
    return profile == Profile::Fast ? "fast" : "dense";
}

std::string_view goal_name(Goal::Kind kind) {
    return kGoals[static_cast<std::size_t>(kind)];
}

Json goal_json(const Goal& goal) {
    Json json{{"kind", goal_name(goal.kind)}};
    if (goal.value != 0) json["value"] = json_number(goal.value);
    return json;
}

Json error_json(double max, double rms, const Goal& goal) {
    constexpr int digits = 4;
    double shown = rounded_up(max, digits);
    if (goal.kind == Goal::Kind::MaxError && max <= goal.value) shown = std::min(shown, goal.value);
    Json json = Json::object();
    if (shown != 0) json["max"] = json_number(shown);
    if (rms != 0) json["rms"] = json_number(rounded(rms, digits));
    return json;
}

std::string write_header(const RasterHeader& header) {
    const Raster& raster = header.description;
    Json json{{"content", "raster"},
              {"rows", raster.rows},
              {"cols", raster.cols},
              {"type", sample_type_name(raster.type)},
              {"goal", goal_json(header.goal)}};
    if (Json error = error_json(header.max_error, header.rms_error, header.goal); !error.empty())
        json["error"] = std::move(error);
    if (header.lattice) {
        json["lattice"] = lattice_json(*header.lattice);
    } else {
        json["scheme"] = scheme_json(header.spec);
        json["pyramid"] = pyramid_json(header.pyramid);
    }
    if (header.components != 1) json["components"] = header.components;
    if (header.has_mask) json["mask"] = true;
    if (raster.nodata) json["nodata"] = json_number(*raster.nodata);
    if (Json geo = georeference_json(raster.geo); !geo.empty())
        json["georeference"] = std::move(geo);
    if (!raster.unit.empty()) json["unit"] = raster.unit;
    if (raster.scale != 1) json["scale"] = json_number(raster.scale);
    if (raster.offset != 0) json["offset"] = json_number(raster.offset);
    if (!raster.band_names.empty()) json["bands"] = raster.band_names;
    if (!raster.metadata.empty()) json["metadata"] = raster.metadata;
    // Names may come from files in any encoding: bytes that are not UTF-8 are replaced, not thrown
    // at.
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<RasterHeader> read_header(const std::string& text) {
    return read_header(parse_json<Json>(text));
}

Result<RasterHeader> read_header(const Json& json) {
    if (!json.is_object()) return bad("the header is not a JSON object");
    RasterHeader header;
    Reader reader(json);
    const auto content = reader.get<std::string>("content", "", true);
    const Json& scheme = reader.object("scheme");
    const Json& goal_json = reader.object("goal");
    const Json& error_json = reader.object("error");
    RELIEF_CHECK(reader.status());
    if (content != "raster")
        return Error{ErrorCode::Unsupported,
                     "holds '" + content + "', this version reads rasters only", "header"};
    RELIEF_CHECK(read_description(json, header));
    if (json.contains("lattice")) {
        RELIEF_CHECK(read_lattice(reader.object("lattice"), header));
        header.spec = {.id = multires::SchemeId::Fvs,
                       .levels = TileTree(header.lattice_rows(), header.lattice_cols()).levels()};
    } else {
        RELIEF_CHECK(read_scheme(scheme, header.spec));
        RELIEF_CHECK(read_pyramid(reader.object("pyramid"), header));
    }
    RELIEF_CHECK(reader.status());
    Reader goal(goal_json);
    const auto kind = goal.get<std::string>("kind", "rms-error");
    header.goal.value = goal.get("value", 0.0);
    for (std::size_t k = 0; k < kGoals.size(); ++k)
        if (kGoals[k] == kind) header.goal.kind = static_cast<Goal::Kind>(k);
    Reader error(error_json);
    header.max_error = error.get("max", 0.0);
    header.rms_error = error.get("rms", 0.0);
    RELIEF_CHECK(goal.status());
    RELIEF_CHECK(error.status());
    return header;
}

}  // namespace relief::codec
