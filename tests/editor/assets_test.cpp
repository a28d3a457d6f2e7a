#include "assets.h"

namespace relief::editor {
namespace {

TEST(Assets, PageIsBuiltIn) {
    const Asset* page = find_asset("index.html");
    ASSERT_NE(page, nullptr);
    const std::string text = inflated(*page);
    EXPECT_NE(text.find("assets/editor.js"), std::string::npos);
    ASSERT_NE(find_asset("assets/editor.js"), nullptr);
    EXPECT_FALSE(inflated(*find_asset("assets/editor.js")).empty());
    EXPECT_EQ(find_asset("assets/../index.html"), nullptr);
    EXPECT_EQ(find_asset(""), nullptr);
}

TEST(Assets, NeedNothingFromElsewhere) {
    const std::string text = inflated(*find_asset("index.html"));
    EXPECT_EQ(text.find("http://"), std::string::npos);
    EXPECT_EQ(text.find("https://"), std::string::npos);
}

TEST(Assets, Types) {
    EXPECT_EQ(content_type("index.html"), "text/html; charset=utf-8");
    EXPECT_EQ(content_type("assets/editor.js"), "text/javascript; charset=utf-8");
    EXPECT_EQ(content_type("dem-edited.relief"), "application/octet-stream");
}

}  // namespace
}  // namespace relief::editor
