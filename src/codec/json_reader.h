#pragma once

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <utility>

#include "relief/core/result.h"

namespace relief::codec {

/// JSON has no NaN or infinity. Integers are written without a fraction.
inline nlohmann::json json_number(double value) {
    if (std::isnan(value)) return "nan";
    if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
    const bool integer = std::abs(value) < 0x1p53 && value == std::floor(value);
    if (integer && !(value == 0 && std::signbit(value))) return static_cast<std::int64_t>(value);
    return value;
}

template <class Numbers>
nlohmann::json json_numbers(const Numbers& values) {
    nlohmann::json list = nlohmann::json::array();
    for (const double value : values) list.push_back(json_number(value));
    return list;
}

inline Error bad_header(const std::string& what) {
    return Error{ErrorCode::BadFile, what + "; the file is damaged", "header"};
}

/// Reads members of one JSON object; the first that is wrong is remembered.
class JsonReader {
  public:
    using Json = nlohmann::json;

    explicit JsonReader(const Json& object) : object_(object) {}

    template <class T>
    T get(const char* name, T fallback, bool required = false) {
        const auto found = object_.find(name);
        if (found == object_.end()) {
            if (required) fail(std::string("member '") + name + "' is missing");
            return fallback;
        }
        if constexpr (std::is_same_v<T, std::string>) {
            if (found->is_string()) return found->template get<std::string>();
        } else if constexpr (std::is_same_v<T, bool>) {
            if (found->is_boolean()) return found->template get<bool>();
        } else if constexpr (std::is_integral_v<T>) {
            if (found->is_number_integer() && std::in_range<T>(found->template get<std::int64_t>()))
                return found->template get<T>();
        } else {
            if (found->is_number()) return found->template get<T>();
            if (*found == "nan") return NAN;
            if (*found == "inf") return INFINITY;
            if (*found == "-inf") return -INFINITY;
        }
        fail(std::string("member '") + name + "' has the wrong type or range");
        return fallback;
    }

    // No copies: they would recurse, and hostile texts nest deeply.
    [[nodiscard]] const Json& object(const char* name) {
        static const Json none = Json::object();
        return member(name, none, "an object");
    }

    [[nodiscard]] const Json& array(const char* name) {
        static const Json none = Json::array();
        return member(name, none, "a list");
    }

    void fail(std::string what) {
        if (problem_.empty()) problem_ = std::move(what);
    }
    [[nodiscard]] Status status() const {
        if (problem_.empty()) return {};
        return bad_header(problem_);
    }

  private:
    /// The member if it is of the kind of `none`, which stands for one that is missing.
    const Json& member(const char* name, const Json& none, const std::string& kind) {
        const auto found = object_.find(name);
        if (found == object_.end()) return none;
        if (found->type() == none.type()) return *found;
        fail(std::string("member '") + name + "' is not " + kind);
        return none;
    }

    const Json& object_;
    std::string problem_;
};

}  // namespace relief::codec
