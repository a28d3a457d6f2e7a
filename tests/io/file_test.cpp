#include "relief/io/file.h"

#include <sys/stat.h>

#include <fstream>

#include "io/scratch.h"

namespace relief::io {
namespace {

namespace fs = std::filesystem;

using FileTest = Scratch;
using Bytes = std::vector<std::uint8_t>;

TEST_F(FileTest, ReadsBackWhatWasWrittenOrAPrefixOfIt) {
    rc::check([this](const Bytes& bytes) {
        RC_ASSERT(write_file_atomically(path("a"), bytes).ok());
        RC_ASSERT(*read_file(path("a")) == bytes);
        const std::size_t part = bytes.size() / 2;
        RC_ASSERT(*read_file(path("a"), part) ==
                  Bytes(bytes.begin(), bytes.begin() + static_cast<long>(part)));
    });
    EXPECT_EQ(files(), Names{"a"});
}

TEST_F(FileTest, ReadsStreamsWhoseSizeIsNotKnown) {
    const auto zeros = read_file("/dev/zero", 200000);
    ASSERT_TRUE(zeros.ok());
    EXPECT_EQ(*zeros, Bytes(200000, 0));
}

TEST_F(FileTest, ReadErrorsNameFileAndReason) {
    EXPECT_EQ(read_file(path("none")).error().text(),
              path("none") + ": can not read: No such file or directory");
    EXPECT_EQ(read_file(path("none")).error().code, ErrorCode::NotFound);
    EXPECT_EQ(read_file(path("")).error().text(), path("") + ": can not read: Is a directory");
}

TEST_F(FileTest, NothingAppearsBeforeCommit) {
    {
        auto file = OutputFile::create(path("out"));
        ASSERT_TRUE(file.ok());
        ASSERT_TRUE(file->write(Bytes(100, 1)).ok());
        EXPECT_FALSE(fs::exists(path("out")));
    }
    EXPECT_EQ(files(), Names{});
}

TEST_F(FileTest, CommitReplacesAndKeepsPermissions) {
    ASSERT_TRUE(write_file_atomically(path("out"), Bytes{1, 2, 3}).ok());
    ASSERT_EQ(::chmod(path("out").c_str(), 0640), 0);
    auto file = OutputFile::create(path("out"));
    ASSERT_TRUE(file.ok());
    ASSERT_TRUE(file->write(Bytes{4}).ok());
    EXPECT_EQ(*read_file(path("out")), (Bytes{1, 2, 3}));
    ASSERT_TRUE(file->write(Bytes{5}).ok());
    ASSERT_TRUE(file->commit().ok());
    EXPECT_EQ(*read_file(path("out")), (Bytes{4, 5}));
    EXPECT_EQ(fs::status(path("out")).permissions(), fs::perms(0640));
    EXPECT_EQ(files(), Names{"out"});
}

TEST_F(FileTest, ASymbolicLinkStaysALink) {
    fs::create_directory(path("real"));
    fs::create_symlink("real/data", path("link"));
    ASSERT_TRUE(write_file_atomically(path("real/data"), Bytes{1}).ok());
    ASSERT_TRUE(write_file_atomically(path("link"), Bytes{2}).ok());
    EXPECT_TRUE(fs::is_symlink(path("link")));
    EXPECT_EQ(*read_file(path("real/data")), Bytes{2});
}

TEST_F(FileTest, WriteErrorsSayWhatToDo) {
    const auto error = [](const std::string& name) {
        return write_file_atomically(name, Bytes{1}).error();
    };
    EXPECT_EQ(error(path("no/file")).text(),
              path("no/file") + ": there is no directory '" + path("no") + "'; create it first");
    EXPECT_EQ(error(path("")).text(), path("") + ": is a directory; give a file name");
    EXPECT_EQ(error("").message, "the output needs a file name");
    EXPECT_EQ(error(path("no/file")).code, ErrorCode::CannotWrite);
    EXPECT_EQ(files(), Names{});
}

TEST_F(FileTest, AFullDeviceIsReported) {
    const Status status = write_file_atomically("/dev/full", Bytes(10, 1));
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(
        status.error().text(),
        "/dev/full: can not write: No space left on device; free some space or write elsewhere");
}

TEST_F(FileTest, AFailedWriteLeavesTheOldFileAndNothingElse) {
    ASSERT_TRUE(write_file_atomically(path("out"), Bytes{1, 2, 3}).ok());
    {
        const FileSizeLimit limit(1000);
        const Status status = write_file_atomically(path("out"), Bytes(5000, 9));
        ASSERT_FALSE(status.ok());
        EXPECT_EQ(status.error().code, ErrorCode::CannotWrite);
    }
    EXPECT_EQ(*read_file(path("out")), (Bytes{1, 2, 3}));
    EXPECT_EQ(files(), Names{"out"});
}

TEST_F(FileTest, StagedSideFilesMoveWithTheTarget) {
    {
        auto staged = StagedOutput::beside(path("dem.bil"));
        ASSERT_TRUE(staged.ok());
        EXPECT_EQ(fs::path(staged->temporary_path()).filename(), "dem.bil");
        std::ofstream(staged->temporary_path()) << "samples";
        std::ofstream(fs::path(staged->temporary_path()).replace_extension(".hdr")) << "header";
        EXPECT_FALSE(fs::exists(path("dem.bil")));
        ASSERT_TRUE(staged->commit().ok());
    }
    EXPECT_EQ(files(), (Names{"dem.bil", "dem.hdr"}));
    EXPECT_EQ(*read_file(path("dem.hdr")), (Bytes{'h', 'e', 'a', 'd', 'e', 'r'}));
}

TEST_F(FileTest, StagedFilesVanishWithoutCommit) {
    {
        auto staged = StagedOutput::beside(path("dem.bil"));
        ASSERT_TRUE(staged.ok());
        std::ofstream(staged->temporary_path()) << "samples";
    }
    EXPECT_EQ(files(), Names{});
    EXPECT_EQ(StagedOutput::beside("/dev/null").error().text(),
              "/dev/null: is a device or pipe; this format needs a regular file");
}

}  // namespace
}  // namespace relief::io
