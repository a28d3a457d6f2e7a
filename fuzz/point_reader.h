#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "relief/io/points.h"

/// What the fuzzer of the point reader runs, and a test on mutations: any bytes give points that
/// are finite and complete, or an error with a place.
namespace relief::io::fuzz {

inline void points(std::span<const std::uint8_t> bytes) {
    const auto require = [](bool condition) {
        if (!condition) std::abort();
    };
    for (const PointColumns& columns :
         {PointColumns{}, PointColumns{.weight = "4"}, PointColumns{.x = "lon", .values = {"1"}},
          PointColumns{.values = {"z", "3", "5"}}, PointColumns{.values_needed = false}}) {
        const auto read = parse_points(bytes, "points", columns);
        if (!read.ok()) {
            require(!read.error().message.empty());
            require(read.error().where.starts_with("points"));
            continue;
        }
        const std::size_t count = read->places.size();
        require(count > 0);
        const std::size_t components = std::max<std::size_t>(columns.values.size(), 1);
        require(read->values.size() == (columns.values_needed ? components : 0));
        require(read->weights.empty() || read->weights.size() == count);
        for (const Vec2 p : read->places) require(std::isfinite(p.x) && std::isfinite(p.y));
        for (const auto& component : read->values) {
            require(component.size() == count);
            for (const double value : component) require(std::isfinite(value));
        }
        for (const double weight : read->weights) require(std::isfinite(weight) && weight >= 0);
    }
}

}  // namespace relief::io::fuzz
