#pragma once

#include <iterator>
#include <nlohmann/json.hpp>

namespace relief {

/// More than all that relief reads. Values are copied by recursion, which must not take the stack.
inline constexpr int kDeepestJson = 32;

/// The value of a text that may be anything: `discarded` (which is no object, no array, ..) if it
/// is not JSON, or if lists and objects are nested more than `deepest` times. Complexity: O(n).
template <class Json, class Text>
[[nodiscard]] Json parse_json(const Text& text, int deepest = kDeepestJson) {
    bool too_deep = false;
    const auto shallow = [&](int depth, typename Json::parse_event_t event, const Json&) {
        using Event = typename Json::parse_event_t;
        const bool opens = event == Event::array_start || event == Event::object_start;
        too_deep = too_deep || (opens && depth >= deepest);
        return !too_deep;
    };
    Json json = Json::parse(std::begin(text), std::end(text), shallow, false);
    return too_deep ? Json(Json::value_t::discarded) : json;
}

}  // namespace relief
