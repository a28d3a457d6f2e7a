#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "command.h"

/// What the scripts of `edit` have in common for all kinds of files.
namespace relief::cli {

/// The moves: a list, or the list of {"moves": list}. Errors: those of reading; BadInput.
[[nodiscard]] Result<Json> read_moves(const std::string& path);
/// Says which move of a script an error is about, counted from 0.
[[nodiscard]] std::string place_of_move(const std::string& path, std::size_t move);
/// An integer member; beyond 64 bits the largest. None: there is no such member, or it is no
/// integer.
[[nodiscard]] std::optional<std::int64_t> integer(const Json& item, const char* key);
/// The number or numbers of "delta". Errors: BadInput unless there are 1 to `most`.
[[nodiscard]] Result<std::vector<double>> delta_of(const Json& item, std::size_t most,
                                                   const std::string& where);

}  // namespace relief::cli
