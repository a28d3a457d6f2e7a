#include "relief/core/json.h"

#include <gtest/gtest.h>

#include <string>

namespace relief {

namespace {

using Json = nlohmann::json;

std::string nested(std::size_t depth) {
    return std::string(depth, '[') + std::string(depth, ']');
}

TEST(ParseJson, IsWhatTheTextSays) {
    EXPECT_EQ(parse_json<Json>(std::string(R"({"a": [1, {"b": null}]})")),
              (Json{{"a", {1, {{"b", nullptr}}}}}));
    EXPECT_TRUE(parse_json<Json>(std::string("[1,")).is_discarded());
    EXPECT_TRUE(parse_json<Json>(std::string()).is_discarded());
}

TEST(ParseJson, RefusesWhatIsTooDeep) {
    EXPECT_TRUE(parse_json<Json>(nested(kDeepestJson)).is_array());
    EXPECT_TRUE(parse_json<Json>(nested(kDeepestJson + 1)).is_discarded());
    EXPECT_TRUE(parse_json<Json>(nested(3), 2).is_discarded());
    EXPECT_TRUE(parse_json<Json>(nested(1U << 22)).is_discarded());
    EXPECT_TRUE(parse_json<Json>(std::string(1U << 22, '[')).is_discarded());
    EXPECT_TRUE(parse_json<Json>("[1, " + nested(1U << 20) + "]").is_discarded())
        << "also behind something else";
}

}  // namespace

}  // namespace relief
