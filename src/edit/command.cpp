#include "relief/edit/command.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

namespace relief::edit {

namespace {

using Json = nlohmann::json;

constexpr std::array<std::pair<std::string_view, Falloff::Profile>, 4> kProfiles = {{
    {"smooth", Falloff::Profile::Smooth},
    {"linear", Falloff::Profile::Linear},
    {"sharp", Falloff::Profile::Sharp},
    {"flat", Falloff::Profile::Flat},
}};

Error wrong(const char* member, const char* what) {
    return {ErrorCode::InvalidArgument, std::string("\"") + member + "\" " + what, ""};
}

Result<double> number(const Json& item, const char* member) {
    if (!item.is_number()) return wrong(member, "is not a number");
    return item.get<double>();
}

/// "delta": a number, or x, y, z.
Result<Vec3<double>> read_delta(const Json& item) {
    if (item.is_number()) return Vec3<double>{0, 0, item.get<double>()};
    if (!item.is_array() || item.size() != 3)
        return wrong("delta", "is neither a number nor a list of three");
    Vec3<double> delta;
    RELIEF_TRY(delta.x, number(item[0], "delta"));
    RELIEF_TRY(delta.y, number(item[1], "delta"));
    RELIEF_TRY(delta.z, number(item[2], "delta"));
    return delta;
}

Result<Vec2> read_slope(const Json& item) {
    if (!item.is_array() || item.size() != 2) return wrong("slope", "is not a list of two numbers");
    Vec2 slope;
    RELIEF_TRY(slope.x, number(item[0], "slope"));
    RELIEF_TRY(slope.y, number(item[1], "slope"));
    return slope;
}

Result<Falloff> read_falloff(const Json& item) {
    Falloff falloff;
    if (!item.is_object() || !item.contains("radius"))
        return wrong("falloff", "is not an object with \"radius\"");
    RELIEF_TRY(falloff.radius, number(item["radius"], "radius"));
    if (!(falloff.radius >= 0) || std::isinf(falloff.radius))
        return wrong("radius", "is negative or not finite");
    if (!item.contains("profile")) return falloff;
    const Json& name = item["profile"];
    for (const auto& [known, profile] : kProfiles)
        if (name.is_string() && name.get_ref<const std::string&>() == known) {
            falloff.profile = profile;
            return falloff;
        }
    return wrong("profile", "is not one of smooth, linear, sharp, flat");
}

Result<std::vector<std::uint64_t>> read_points(const Json& item) {
    if (!item.is_array() || item.empty()) return wrong("points", "is not a list of indices");
    std::vector<std::uint64_t> points;
    points.reserve(item.size());
    for (const Json& point : item) {
        if (!point.is_number_unsigned()) return wrong("points", "has a member that is no index");
        points.push_back(point.get<std::uint64_t>());
    }
    return points;
}

bool is_zero(const Vec2& a) {
    return a.x == 0 && a.y == 0;
}

}  // namespace

double Falloff::weight(double d) const {
    if (d <= 0) return 1;
    if (!(d < radius)) return 0;
    const double t = d / radius;
    switch (profile) {
        case Profile::Smooth:
            return (1 - t * t) * (1 - t * t);
        case Profile::Linear:
            return 1 - t;
        case Profile::Sharp:
            return (1 - t) * (1 - t);
        case Profile::Flat:
            return 1;
    }
    return 0;
}

Result<Move> read_move(const Json& command) {
    const Json* kind = command.is_object() && command.contains("do") ? &command["do"] : nullptr;
    const bool tilts = kind && *kind == "tilt";
    if (!kind || (*kind != "move" && !tilts))
        return Error{ErrorCode::InvalidArgument, R"(is not a command "move" or "tilt")", ""};
    Move move;
    if (!command.contains("level") || !command["level"].is_number_unsigned() ||
        command["level"].get<std::uint64_t>() > 64)
        return wrong("level", "is not a level");
    move.level = command["level"].get<int>();
    RELIEF_TRY(move.points, read_points(command.value("points", Json())));
    if (tilts) {
        RELIEF_TRY(move.slope, read_slope(command.value("slope", Json())));
    } else {
        RELIEF_TRY(move.delta, read_delta(command.value("delta", Json())));
    }
    if (command.contains("falloff")) {
        RELIEF_TRY(move.falloff, read_falloff(command["falloff"]));
    }
    return move;
}

Json write_move(const Move& move) {
    Json json = {{"level", move.level}, {"points", move.points}};
    if (is_zero(move.slope)) {
        json["do"] = "move";
        json["delta"] = {move.delta.x, move.delta.y, move.delta.z};
    } else {
        json["do"] = "tilt";
        json["slope"] = {move.slope.x, move.slope.y};
    }
    if (move.falloff.radius > 0) {
        const auto profile = static_cast<std::size_t>(move.falloff.profile);
        json["falloff"] = {{"radius", move.falloff.radius}, {"profile", kProfiles[profile].first}};
    }
    return json;
}

std::string text_of(const Move& move) {
    std::string text = is_zero(move.slope) ? "move " : "tilt ";
    text += std::to_string(move.points.size());
    text += move.points.size() == 1 ? " point of level " : " points of level ";
    return text + std::to_string(move.level);
}

}  // namespace relief::edit
