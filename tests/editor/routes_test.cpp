#include "routes.h"

#include "token.h"

namespace relief::editor {
namespace {

const Access kAccess{8000, "0123456789abcdef0123456789abcdef"};
const std::string kRoot = "/" + kAccess.token + "/";

Route asked(std::string_view method, const std::string& target,
            std::string_view host = "127.0.0.1:8000", std::string_view origin = "") {
    return route({method, target, host, origin}, kAccess);
}

void expect_refused(unsigned status, const Route& route) {
    EXPECT_EQ(route.to, Route::To::Refused);
    EXPECT_EQ(route.status, status);
}

TEST(Routes, PageAndItsAssets) {
    EXPECT_EQ(kAccess.url(), "http://127.0.0.1:8000" + kRoot);
    EXPECT_EQ(asked("GET", kRoot).argument, "index.html");
    EXPECT_EQ(asked("GET", kRoot).to, Route::To::Asset);
    EXPECT_EQ(asked("GET", kRoot + "assets/editor.js").argument, "assets/editor.js");
    EXPECT_EQ(asked("GET", kRoot + "assets/editor.js?v=1").argument, "assets/editor.js");
    expect_refused(405, asked("POST", kRoot));
    expect_refused(405, asked("HEAD", kRoot));
}

TEST(Routes, NamedOnes) {
    EXPECT_EQ(asked("GET", kRoot + "socket").to, Route::To::Socket);
    EXPECT_EQ(asked("GET", kRoot + "drape.png").to, Route::To::DrapePicture);
    const Route open = asked("POST", kRoot + "open?name=a%20b%C3%A9.tif");
    EXPECT_EQ(open.to, Route::To::Open);
    EXPECT_EQ(open.argument, "a b\xC3\xA9.tif");
    EXPECT_EQ(asked("POST", kRoot + "drape?x=1&name=p.png").argument, "p.png");
    EXPECT_EQ(asked("GET", kRoot + "export?format=tif").argument, "tif");
    expect_refused(405, asked("GET", kRoot + "open?name=a"));
    expect_refused(405, asked("POST", kRoot + "export?format=tif"));
}

TEST(Routes, NamesStayInTheirFolder) {
    for (const char* name : {"", "..", ".", "../a", "..%2Fa", "a%2Fb", "%2Fetc%2Fpasswd", "a%5Cb",
                             ".hidden", "a%00b", "a%0Ab", "a%", "a%2", "a%zz"})
        expect_refused(400, asked("POST", kRoot + "open?name=" + name));
    expect_refused(400, asked("POST", kRoot + "open"));
    expect_refused(400, asked("POST", kRoot + "open?name=" + std::string(201, 'a')));
    expect_refused(400, asked("GET", kRoot + "export?format=..%2Ftif"));
}

TEST(Routes, TokenIsNeeded) {
    for (const std::string& target :
         {std::string("/"), std::string(""), std::string("/socket"), std::string("//"),
          "/" + kAccess.token, "/" + std::string(32, '0') + "/", std::string("/0123456789abcdef/"),
          std::string("/favicon.ico"), "x" + kRoot, "http://127.0.0.1:8000" + kRoot})
        expect_refused(404, asked("GET", target));
}

TEST(Routes, HostAndOriginMustBeOurs) {
    EXPECT_EQ(asked("GET", kRoot, "localhost:8000").to, Route::To::Asset);
    EXPECT_EQ(asked("GET", kRoot, "localhost:8000", "http://localhost:8000").to, Route::To::Asset);
    for (const char* host : {"", "127.0.0.1", "127.0.0.1:8001", "localhost", "example.org:8000",
                             "127.0.0.1:8000.example.org", "[::1]:8000"})
        expect_refused(403, asked("GET", kRoot, host));
    for (const char* origin : {"null", "http://example.org", "https://127.0.0.1:8000",
                               "http://localhost:8000", "http://127.0.0.1:80000", "127.0.0.1:8000"})
        expect_refused(403, asked("GET", kRoot + "socket", "127.0.0.1:8000", origin));
    // Before the token is looked at.
    expect_refused(403, asked("GET", "/", "example.org:8000"));
}

TEST(Token, IsRandomAndCompared) {
    const std::string a = *random_token();
    const std::string b = *random_token();
    EXPECT_EQ(a.size(), 32U);
    EXPECT_EQ(a.find_first_not_of("0123456789abcdef"), std::string::npos);
    EXPECT_NE(a, b);
    EXPECT_TRUE(is_same_token(a, a));
    EXPECT_FALSE(is_same_token(b, a));
    EXPECT_FALSE(is_same_token(a.substr(1), a));
    EXPECT_FALSE(is_same_token("", a));
}

}  // namespace
}  // namespace relief::editor
