#include "request.h"

namespace relief::editor {
namespace {

TEST(Requests, CommandsAndQuestions) {
    const auto move = read_request(R"({"id": 3, "do": "move", "level": 2})");
    ASSERT_TRUE(move.ok());
    EXPECT_EQ(move->id, 3U);
    EXPECT_TRUE(move->command);
    EXPECT_EQ(move->name, "move");
    EXPECT_EQ(move->body["level"], 2);
    EXPECT_TRUE(move->overtakes());
    EXPECT_FALSE(read_request(R"({"id": 4, "ask": "tiles"})")->overtakes());
    EXPECT_TRUE(read_request(R"({"id": 5, "ask": "compress"})")->overtakes());
}

TEST(Requests, AnythingElseIsRefused) {
    for (const std::string& text : std::vector<std::string>{
             "", "x", "3", "[]", "{}", R"({"id": 1})", R"({"ask": "view"})",
             R"({"id": -1, "ask": "view"})", R"({"id": 1.5, "ask": "view"})",
             R"({"id": "1", "ask": "view"})", R"({"id": 1, "ask": 2})",
             R"({"id": 1, "ask": "view", "do": "undo"})", R"({"id": 1, "ask": "view")",
             R"({"id": 1, "ask": "view"} x)", "{\"id\": 1, \"ask\": \"\xff\"}"}) {
        const auto request = read_request(text);
        ASSERT_FALSE(request.ok()) << text;
        EXPECT_EQ(request.error().code, ErrorCode::BadInput) << text;
    }
}

TEST(Requests, DepthIsLimited) {
    const auto nested = [](int depth) {
        return R"({"id": 1, "ask": "view", "x": )" +
               std::string(static_cast<std::size_t>(depth), '[') +
               std::string(static_cast<std::size_t>(depth), ']') + "}";
    };
    EXPECT_TRUE(read_request(nested(5)).ok());
    EXPECT_FALSE(read_request(nested(100)).ok());
    EXPECT_FALSE(read_request(nested(1000000)).ok());
}

TEST(Requests, ErrorsAsJson) {
    EXPECT_EQ(error_json(Error{ErrorCode::CannotWrite, "disk full", "a.relief"}),
              (Json{{"code", "cannot_write"}, {"message", "disk full"}, {"where", "a.relief"}}));
    EXPECT_EQ(error_json("read_only", "no"),
              (Json{{"code", "read_only"}, {"message", "no"}, {"where", ""}}));
    EXPECT_EQ(text_of(Json{{"name", "\xff"}}), "{\"name\":\"\xEF\xBF\xBD\"}");
}

}  // namespace
}  // namespace relief::editor
