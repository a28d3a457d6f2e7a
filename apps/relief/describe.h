#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

namespace relief::cli {

/// The verbs and options of a program as `--help` has them: what man pages, completions and the
/// documentation are made of. {name, description, footer, options, groups, verbs}; a group is
/// {description, options}, an option {names, type, choices, range, least, most, required, text}:
/// least and most say how many values it takes (most is null where any number will do, 0 for
/// flags), and positionals have one name, without dashes.
[[nodiscard]] nlohmann::ordered_json described(const CLI::App& app);

}  // namespace relief::cli
