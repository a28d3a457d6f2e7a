#pragma once

#include <nlohmann/json.hpp>

#include "codec/value_lattice.h"
#include "relief/codec/raster_codec.h"

/// Parts of headers that several kinds of files have. docs/format.md.
namespace relief::codec {

[[nodiscard]] const char* lattice_name(ValueLattice::Kind kind);
[[nodiscard]] nlohmann::json lattice_json(const ValueLattice& lattice);
/// Errors: BadFile; Unsupported for kinds that are not known.
[[nodiscard]] Status read_lattice(const nlohmann::json& json, ValueLattice& lattice);

/// Errors: BadFile.
[[nodiscard]] Status read_goal(const nlohmann::json& json, Goal& goal);

/// Of digits after the point.
[[nodiscard]] inline bool are_digits(int digits) {
    return digits >= 0 && digits <= kMostDigits10;
}

}  // namespace relief::codec
