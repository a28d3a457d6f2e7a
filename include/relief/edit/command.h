#pragma once

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "relief/core/result.h"
#include "relief/core/vec2.h"
#include "relief/core/vec3.h"

/// What changes a surface, as JSON and as values. Source: docs/protocol.md, "Commands".
namespace relief::edit {

/// How a control point near the moved ones follows: with the weight of its distance d < radius from
/// the nearest of them along the control net.
struct Falloff {
    enum class Profile : std::uint8_t { Smooth, Linear, Sharp, Flat };
    double radius = 0;  ///< 0: none follows
    Profile profile = Profile::Smooth;

    /// 1 at d = 0, 0 from d = radius on.
    [[nodiscard]] double weight(double d) const;
    friend bool operator==(const Falloff&, const Falloff&) = default;
};

/// Moves control points of a level by `delta`, and tilts control triangles by `slope`.
struct Move {
    int level = 0;
    std::vector<std::uint64_t> points = {};
    Vec3<double> delta = {};
    Vec2 slope = {};
    Falloff falloff = {};

    friend bool operator==(const Move&, const Move&) = default;
};

/// "move" and "tilt". Errors: InvalidArgument naming the member.
[[nodiscard]] Result<Move> read_move(const nlohmann::json& command);
[[nodiscard]] nlohmann::json write_move(const Move& move);
/// "move 12 points of level 3".
[[nodiscard]] std::string text_of(const Move& move);

}  // namespace relief::edit
