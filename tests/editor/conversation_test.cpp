#include "conversation.h"

#include <cmath>
#include <cstring>
#include <deque>
#include <filesystem>

#include "io/scratch.h"
#include "relief/codec/raster_codec.h"
#include "relief/io/file.h"
#include "relief/io/png.h"

namespace relief::editor {
namespace {

/// Keeps what was sent.
class Mailbox final : public Outbox {
  public:
    void send(PageId page, Message message) override { sent_[page].push_back(std::move(message)); }

    [[nodiscard]] std::size_t waiting(PageId page) { return sent_[page].size(); }
    void clear() { sent_.clear(); }

    /// The next message to a page, which must be text.
    Json text(PageId page) {
        if (waiting(page) == 0 || !std::holds_alternative<std::string>(sent_[page].front())) {
            ADD_FAILURE() << "no text for page " << page;
            return {};
        }
        const std::string message = std::get<std::string>(sent_[page].front());
        sent_[page].pop_front();
        return Json::parse(message);
    }

    /// The head of the next message to a page, which must be binary.
    Json head(PageId page) {
        if (waiting(page) == 0 || !std::holds_alternative<Bytes>(sent_[page].front())) {
            ADD_FAILURE() << "no geometry for page " << page;
            return {};
        }
        const Bytes message = std::get<Bytes>(sent_[page].front());
        sent_[page].pop_front();
        std::uint32_t length = 0;
        std::memcpy(&length, message.data() + 4, sizeof length);
        return Json::parse(message.begin() + 8, message.begin() + 8 + length);
    }

  private:
    std::map<PageId, std::deque<Message>> sent_;
};

/// 150 x 200 samples with a CRS, in steps of 0.01.
Raster hills() {
    Raster raster;
    raster.rows = 150;
    raster.cols = 200;
    raster.unit = "m";
    raster.geo.crs = "EPSG:32611";
    raster.geo.transform = {400000, 30, 0, 5200000, 0, -30};
    Grid<double> plane(raster.rows, raster.cols);
    for (std::int64_t r = 0; r < raster.rows; ++r)
        for (std::int64_t c = 0; c < raster.cols; ++c)
            plane(r, c) = static_cast<float>(
                std::round(100 * (50 + 20 * std::sin(0.05 * static_cast<double>(r)) *
                                           std::cos(0.04 * static_cast<double>(c)))) /
                100);
    raster.planes.push_back(std::move(plane));
    return raster;
}

Document document(const std::string& save = "") {
    static const Raster raster = hills();
    static const Bytes bytes =
        codec::encode_raster(raster, {.goal = {codec::Goal::Kind::Lossless, 0}})->bytes;
    Document opened{.name = "hills.tif", .file = std::make_shared<MemorySource>(bytes)};
    opened.save = save;
    opened.terrain = description_of(raster);
    return opened;
}

bool still_wanted() {
    return true;
}

class ConversationTest : public io::Scratch {
  protected:
    static constexpr PageId kWriter = 1;
    static constexpr PageId kWatcher = 2;

    void SetUp() override {
        Scratch::SetUp();
        auto created = Conversation::create(document(path("hills-edited.relief")), mail);
        ASSERT_TRUE(created.ok()) << created.error().text();
        talk.emplace(*std::move(created));
        talk->join(kWriter);
        hello = mail.text(kWriter);
    }

    void say(PageId page, const std::string& text) {
        talk->receive(page, read_request(text), still_wanted);
    }
    /// Slow machines tell how far they are before they answer.
    Json answer_to(PageId page) {
        Json answer = mail.text(page);
        while (answer.value("event", "") == "progress") answer = mail.text(page);
        return answer;
    }
    /// The answer to a question or command that must succeed.
    Json ok(PageId page, const std::string& text) {
        say(page, text);
        Json answer = answer_to(page);
        EXPECT_EQ(answer["ok"], true) << text << ": " << answer;
        return answer;
    }
    /// The code of the error that a page gets.
    std::string refused(PageId page, const std::string& text) {
        say(page, text);
        const Json answer = answer_to(page);
        EXPECT_EQ(answer["ok"], false) << text;
        EXPECT_EQ(mail.waiting(page), 0U) << text;
        return answer["error"]["code"];
    }
    /// Level 0 with one tile, and a control point of level 3 in the middle.
    void look(PageId page) {
        ok(page, R"({"id": 1, "ask": "view", "level": 0})");
        ok(page, R"({"id": 2, "ask": "tiles", "tiles": [[0, 0, 0]]})");
        EXPECT_EQ(mail.head(page)["what"], "tile");
    }
    [[nodiscard]] std::string move() const {
        const Json& level = hello["levels"][3];
        const int index =
            level["rows"].get<int>() / 2 * level["cols"].get<int>() + level["cols"].get<int>() / 3;
        return R"({"id": 9, "do": "move", "level": 3, "delta": 5, "points": [)" +
               std::to_string(index) + "]}";
    }

    Mailbox mail;
    std::optional<Conversation> talk;
    Json hello;
};

TEST_F(ConversationTest, HelloDescribesTheFile) {
    EXPECT_EQ(hello["event"], "hello");
    EXPECT_EQ(hello["protocol"], 1);
    EXPECT_EQ(hello["name"], "hills.tif");
    EXPECT_EQ(hello["kind"], "raster");
    EXPECT_EQ(hello["writer"], true);
    EXPECT_EQ(hello["save"], "hills-edited.relief");
    EXPECT_EQ(hello["unit"], "m");
    EXPECT_EQ(hello["crs"], "EPSG:32611");
    EXPECT_EQ(hello["bound"], 0.0);
    EXPECT_EQ(hello["levels"][0]["rows"], 150);
    EXPECT_EQ(hello["levels"][0]["control_points"], 150 * 200);
    EXPECT_EQ(hello["raster"]["cols"], 200);
    EXPECT_EQ(hello["history"], (Json{{"done", 0}, {"entries", Json::array()}}));
}

TEST_F(ConversationTest, TilesAndPatches) {
    look(kWriter);
    ok(kWriter, move());
    const Json changed = mail.text(kWriter);
    EXPECT_EQ(changed["event"], "changed");
    EXPECT_EQ(changed["cause"], 9);
    EXPECT_EQ(changed["history"]["done"], 1);
    EXPECT_EQ(changed["history"]["entries"][0]["text"], "move 1 point of level 3");
    EXPECT_GT(changed["touched"], 0);
    const Json patch = mail.head(kWriter);
    EXPECT_EQ(patch["what"], "patch");
    EXPECT_EQ(patch["id"], 9);
    EXPECT_EQ(patch["tile"], Json::array({0, 0, 0}));
    EXPECT_EQ(patch["revision"], changed["revision"]);
    EXPECT_EQ(mail.waiting(kWriter), 0U);  // other tiles are not held

    ok(kWriter, R"({"id": 10, "do": "undo"})");
    EXPECT_EQ(mail.text(kWriter)["history"]["done"], 0);
    mail.clear();
    ok(kWriter, R"({"id": 11, "ask": "forget", "tiles": [[0, 0, 0]]})");
    ok(kWriter, R"({"id": 12, "do": "redo"})");
    EXPECT_EQ(mail.text(kWriter)["history"]["done"], 1);
    EXPECT_EQ(mail.waiting(kWriter), 0U);
}

TEST_F(ConversationTest, UndoGivesBackEveryByteOfATile) {
    look(kWriter);
    const auto tile = [&] {
        mail.clear();
        ok(kWriter, R"({"id": 5, "ask": "view", "level": 1})");
        ok(kWriter, R"({"id": 5, "ask": "view", "level": 0})");
        ok(kWriter, R"({"id": 5, "ask": "at", "x": 3000.5, "y": -2000.25})");
        return ok(kWriter, R"({"id": 5, "ask": "at", "x": 3000.5, "y": -2000.25})")["value"];
    };
    const Json before = tile();
    ok(kWriter, move());
    const Json moved = tile();
    ok(kWriter, R"({"id": 10, "do": "undo"})");
    EXPECT_EQ(tile(), before);
    EXPECT_NE(moved, before);
}

TEST_F(ConversationTest, NetFollowsMoves) {
    ok(kWriter, R"({"id": 1, "ask": "view", "level": 0})");
    ok(kWriter, R"({"id": 2, "ask": "net", "level": 3, "window": [2, 3, 10, 12]})");
    const Json net = mail.head(kWriter);
    EXPECT_EQ(net["what"], "net");
    EXPECT_EQ(net["arrays"][0]["count"], 10 * 12);
    ok(kWriter, move());
    EXPECT_EQ(mail.text(kWriter)["event"], "changed");
    const Json patch = mail.head(kWriter);
    EXPECT_EQ(patch["what"], "net");
    EXPECT_EQ(patch["patch"], true);
    EXPECT_EQ(patch["arrays"][0]["name"], "at");
    EXPECT_EQ(patch["arrays"][0]["count"], 1);
    // Until the page says that it does not show it any more.
    ok(kWriter, R"({"id": 3, "ask": "net", "level": null})");
    EXPECT_EQ(mail.waiting(kWriter), 0U);
    ok(kWriter, move());
    EXPECT_EQ(mail.text(kWriter)["event"], "changed");
    EXPECT_EQ(mail.waiting(kWriter), 0U);
}

TEST_F(ConversationTest, DragIsShownAndGoes) {
    look(kWriter);
    std::string drag = move();
    drag.replace(drag.find("\"do\": \"move\""), 12, R"("do": "drag", "of": "move")");
    ok(kWriter, drag);
    EXPECT_EQ(mail.text(kWriter)["history"]["done"], 0);
    EXPECT_EQ(mail.head(kWriter)["what"], "patch");
    ok(kWriter, R"({"id": 10, "do": "release"})");
    EXPECT_EQ(mail.text(kWriter)["history"]["done"], 0);
    EXPECT_EQ(mail.head(kWriter)["what"], "patch");
}

TEST_F(ConversationTest, OthersWatch) {
    talk->join(kWatcher);
    EXPECT_EQ(mail.text(kWatcher)["writer"], false);
    look(kWriter);
    look(kWatcher);
    EXPECT_EQ(refused(kWatcher, move()), "read_only");
    EXPECT_EQ(refused(kWatcher, R"({"id": 4, "ask": "save"})"), "read_only");
    ok(kWriter, move());
    const Json told = mail.text(kWatcher);
    EXPECT_EQ(told["event"], "changed");
    EXPECT_EQ(told["cause"], nullptr);
    EXPECT_EQ(mail.waiting(kWatcher), 0U);
    talk->refresh();
    const Json tile = mail.head(kWatcher);
    EXPECT_EQ(tile["what"], "tile");
    EXPECT_EQ(tile["id"], 0);
    EXPECT_EQ(tile["revision"], told["revision"]);
    talk->refresh();
    EXPECT_EQ(mail.waiting(kWatcher), 0U);

    talk->leave(kWriter);
    EXPECT_EQ(refused(kWatcher, move()), "read_only");
    talk->join(3);
    EXPECT_EQ(mail.text(3)["writer"], true);
}

TEST_F(ConversationTest, WatchersKeepTheirOwnView) {
    talk->join(kWatcher);
    mail.clear();
    look(kWriter);
    ok(kWatcher, R"({"id": 1, "ask": "view", "level": 4})");
    const Json coarse = ok(kWatcher, R"({"id": 2, "ask": "at", "x": 1234, "y": -777})")["value"];
    const Json fine = ok(kWriter, R"({"id": 3, "ask": "at", "x": 1234, "y": -777})")["value"];
    EXPECT_NE(coarse, fine);
    EXPECT_EQ(ok(kWatcher, R"({"id": 4, "ask": "at", "x": 1234, "y": -777})")["value"], coarse);
    // The writer's tiles are still held after the watcher's question.
    ok(kWriter, move());
    EXPECT_EQ(mail.text(kWriter)["event"], "changed");
    EXPECT_EQ(mail.head(kWriter)["what"], "patch");
}

TEST_F(ConversationTest, SavesWhatTheSessionHas) {
    ok(kWriter, move());
    mail.clear();
    const Json saved = ok(kWriter, R"({"id": 4, "ask": "save"})");
    EXPECT_EQ(saved["path"], path("hills-edited.relief"));
    const auto bytes = io::read_file(path("hills-edited.relief"));
    ASSERT_TRUE(bytes.ok());
    EXPECT_EQ(saved["bytes"], bytes->size());
    EXPECT_EQ(codec::RasterFile::open(*bytes)->moves().size(), 1U);
    EXPECT_EQ(files(), io::Names{"hills-edited.relief"});
}

TEST_F(ConversationTest, CompressesUnlessItIsNoLongerWanted) {
    ok(kWriter, R"({"id": 1, "ask": "view", "level": 0})");
    const Json result = ok(kWriter, R"({"id": 2, "ask": "compress", "max_error": 0.5})");
    EXPECT_LE(result["max_error"], 0.5);
    EXPECT_GT(result["bytes"], 0);
    ok(kWriter, R"({"id": 3, "ask": "view", "level": 0, "show": "compressed"})");
    EXPECT_LE(ok(kWriter, R"({"id": 4, "ask": "errors"})")["max_error"], 0.5);
    const auto file = talk->export_as("relief", path("."), {});
    ASSERT_TRUE(file.ok()) << file.error().text();
    EXPECT_EQ(*file, path("./hills-compressed.relief"));
    EXPECT_EQ(result["bytes"], io::read_file(*file)->size());
    talk->receive(kWriter, read_request(R"({"id": 5, "ask": "compress", "max_error": 0.1})"),
                  [] { return false; });
    EXPECT_EQ(mail.text(kWriter)["error"]["code"], "cancelled");
}

TEST_F(ConversationTest, NonsenseIsRefusedInWords) {
    ok(kWriter, R"({"id": 1, "ask": "view", "level": 0})");
    for (const char* text :
         {R"({"id": 1, "ask": "nothing"})",
          R"({"id": 1, "do": "nothing"})",
          R"({"id": 1, "ask": "view"})",
          R"({"id": 1, "ask": "view", "level": 99})",
          R"({"id": 1, "ask": "view", "level": -1})",
          R"({"id": 1, "ask": "view", "level": 0, "show": "x"})",
          R"({"id": 1, "ask": "view", "level": 0, "with": ["x"]})",
          R"({"id": 1, "ask": "view", "level": 0, "with": 3})",
          R"({"id": 1, "ask": "tiles"})",
          R"({"id": 1, "ask": "tiles", "tiles": [[0, 0]]})",
          R"({"id": 1, "ask": "tiles", "tiles": [[0, 2, 0]]})",
          R"({"id": 1, "ask": "tiles", "tiles": [[99, 0, 0]]})",
          R"({"id": 1, "ask": "tiles", "tiles": [[0, 4611686018427387903, 0]]})",
          R"({"id": 1, "ask": "tiles", "tiles": [[0, -1, 0]]})",
          R"({"id": 1, "ask": "tiles", "tiles": [[0, 0.5, 0]]})",
          R"({"id": 1, "ask": "net", "level": 0, "window": [0, 0, 1]})",
          R"({"id": 1, "ask": "net", "level": 0, "window": [0, 0, 4000, 4000]})",
          R"({"id": 1, "ask": "at", "x": "1", "y": 2})",
          R"({"id": 1, "ask": "compress"})",
          R"({"id": 1, "ask": "compress", "max_error": -1})",
          R"({"id": 1, "do": "move", "level": 3, "points": [99999999], "delta": 1})",
          R"({"id": 1, "do": "move", "level": 3, "points": [], "delta": 1})",
          R"({"id": 1, "do": "goto", "done": 7})"})
        EXPECT_EQ(refused(kWriter, text), "invalid_argument") << text;
    say(kWriter, "no json");
    const Json answer = mail.text(kWriter);
    EXPECT_EQ(answer["id"], nullptr);
    EXPECT_EQ(answer["error"]["code"], "bad_input");
    say(77, R"({"id": 1, "ask": "save"})");
    EXPECT_EQ(mail.waiting(77), 0U);
}

TEST_F(ConversationTest, OutsideThereIsNothing) {
    ok(kWriter, R"({"id": 1, "ask": "view", "level": 0})");
    const Json answer = ok(kWriter, R"({"id": 2, "ask": "at", "x": 1e9, "y": 0})");
    EXPECT_EQ(answer["value"], nullptr);
    EXPECT_EQ(answer["x"], nullptr);
}

TEST_F(ConversationTest, AnotherFileTakesItsPlace) {
    ok(kWriter, move());
    mail.clear();
    Document other = document();
    other.name = "other.relief";
    other.notices = {"look out"};
    ASSERT_TRUE(talk->replace(std::move(other)).ok());
    const Json again = mail.text(kWriter);
    EXPECT_EQ(again["event"], "hello");
    EXPECT_EQ(again["name"], "other.relief");
    EXPECT_EQ(again["history"]["done"], 0);
    EXPECT_EQ(again["save"], "");
    EXPECT_EQ(mail.text(kWriter), (Json{{"event", "notice"}, {"message", "look out"}}));
    EXPECT_EQ(refused(kWriter, R"({"id": 4, "ask": "save"})"), "invalid_argument");

    Document broken = document();
    broken.file = std::make_shared<MemorySource>(Bytes(100));
    EXPECT_EQ(talk->replace(std::move(broken)).error().code, ErrorCode::BadFile);
    EXPECT_EQ(mail.waiting(kWriter), 0U);
    ok(kWriter, move());
}

TEST_F(ConversationTest, Exports) {
    ok(kWriter, move());
    const FileAccess files{{}, [&](const std::string& relief, int level, const std::string& out) {
                               EXPECT_EQ(relief, path("hills-edited.relief"));
                               EXPECT_EQ(level, 0);
                               return io::write_file_atomically(out, Bytes{1, 2, 3});
                           }};
    EXPECT_EQ(*talk->export_as("relief", path("."), files), path("./hills-edited.relief"));
    const FileAccess there{{}, [](const std::string&, int, const std::string& out) {
                               return io::write_file_atomically(out, Bytes{1, 2, 3});
                           }};
    EXPECT_EQ(*talk->export_as("tif", path("."), there), path("./hills-edited.tif"));
    EXPECT_EQ(*io::read_file(path("hills-edited.tif")), (Bytes{1, 2, 3}));
    const auto script = io::read_file(*talk->export_as("script", path("."), there));
    const Json list = Json::parse(script->begin(), script->end());
    ASSERT_EQ(list.size(), 1U);
    EXPECT_EQ(list[0]["do"], "move");
    EXPECT_EQ(list[0]["level"], 3);
    EXPECT_EQ(talk->export_as("exe", path("."), there).error().code, ErrorCode::InvalidArgument);
}

TEST_F(ConversationTest, DrapeCoversAllCells) {
    io::Image image(8, 4, 3);
    image.pixel(0, 0)[0] = 200;
    ASSERT_TRUE(io::write_png(path("a.png"), image).ok());
    const auto answer = talk->drape(path("a.png"));
    ASSERT_TRUE(answer.ok()) << answer.error().text();
    const Json& rect = (*answer)["rect"];
    // 200 x 150 cells of 30 m.
    EXPECT_DOUBLE_EQ(rect[2].get<double>() - rect[0].get<double>(), 6000);
    EXPECT_DOUBLE_EQ(rect[3].get<double>() - rect[1].get<double>(), 4500);
    ASSERT_TRUE(io::write_file_atomically(path("b.png"), talk->drape_picture()).ok());
    const auto back = io::read_png(path("b.png"));
    ASSERT_TRUE(back.ok());
    EXPECT_EQ(back->width, 8);
    EXPECT_EQ(back->pixel(0, 0)[0], 200);
    EXPECT_FALSE(talk->drape(path("missing.png")).ok());
}

}  // namespace
}  // namespace relief::editor
