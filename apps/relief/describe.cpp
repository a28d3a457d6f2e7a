#include "describe.h"

#include <string>

namespace relief::cli {

namespace {

using Json = nlohmann::ordered_json;

Json names_of(const CLI::Option& option) {
    if (option.get_positional()) return Json::array({option.get_name(true)});
    Json names = Json::array();
    for (const std::string& name : option.get_snames()) names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
    return names;
}

/// "TEXT:{fast,dense}" and "INT:INT in [0 - 2]" are a type and what its values may be.
void add_type(Json& json, const std::string& name) {
    const auto colon = name.find(':');
    json["type"] = name.substr(0, colon);
    if (colon == std::string::npos) return;
    const std::string values = name.substr(colon + 1);
    if (values.front() == '{')
        json["choices"] = CLI::detail::split(values.substr(1, values.size() - 2), ',');
    else
        json["range"] = values.substr(values.find('['));
}

Json described(const CLI::Option& option) {
    Json json{{"names", names_of(option)}};
    if (option.get_items_expected_max() > 0) add_type(json, option.get_type_name());
    json["least"] = option.get_items_expected_min();
    const bool any_number =
        option.get_items_expected_max() >= CLI::detail::expected_max_vector_size;
    json["most"] = any_number ? Json(nullptr) : Json(option.get_items_expected_max());
    json["required"] = option.get_required();
    json["text"] = option.get_description();
    return json;
}

/// A group of options, which has no name, inherits the help of its verb: it is not listed twice.
Json options_of(const CLI::App& app) {
    Json options = Json::array();
    for (const CLI::Option* option : app.get_options()) {
        const bool inherited = app.get_name().empty() && option == app.get_help_ptr();
        if (!option->get_group().empty() && !inherited) options.push_back(described(*option));
    }
    return options;
}

}  // namespace

Json described(const CLI::App& app) {
    Json json{{"name", app.get_name()},     {"description", app.get_description()},
              {"footer", app.get_footer()}, {"options", options_of(app)},
              {"groups", Json::array()},    {"verbs", Json::array()}};
    for (const CLI::App* child : app.get_subcommands([](const CLI::App*) { return true; })) {
        if (child->get_name().empty())
            json["groups"].push_back(
                Json{{"description", child->get_description()}, {"options", options_of(*child)}});
        else
            json["verbs"].push_back(described(*child));
    }
    return json;
}

}  // namespace relief::cli
