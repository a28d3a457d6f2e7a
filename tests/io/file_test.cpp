#include "relief/io/file.h"

#include <sys/stat.h>

#include <cstdlib>
#include <fstream>
#include <optional>
#include <thread>

#include "io/scratch.h"

namespace relief::io {
namespace {

namespace fs = std::filesystem;

using FileTest = Scratch;

/// Byte k of a long sequence that has no period of a power of two.
std::uint8_t byte_at(std::uint64_t k) {
    return static_cast<std::uint8_t>(k * 7 + k / 251);
}

Bytes sequence(std::uint64_t first, std::uint64_t count) {
    Bytes bytes(count);
    for (std::uint64_t k = 0; k < count; ++k) bytes[k] = byte_at(first + k);
    return bytes;
}

Bytes read_from(const ByteSource& source, std::uint64_t offset, std::uint64_t count) {
    Bytes bytes(count);
    EXPECT_TRUE(source.read(offset, bytes).ok());
    return bytes;
}

/// An environment variable for the life time of this object.
class Environment {
  public:
    Environment(const char* name, const std::string& value) : name_(name) {
        if (const char* before = std::getenv(name)) before_ = before;
        ::setenv(name, value.c_str(), 1);
    }
    Environment(const Environment&) = delete;
    Environment& operator=(const Environment&) = delete;
    ~Environment() {
        if (before_)
            ::setenv(name_, before_->c_str(), 1);
        else
            ::unsetenv(name_);
    }

  private:
    const char* name_;
    std::optional<std::string> before_;
};

TEST_F(FileTest, ReadsBackWhatWasWrittenOrAPrefixOfIt) {
    EXPECT_TRUE(rc::check([this](const Bytes& bytes) {
        RC_ASSERT(write_file_atomically(path("a"), bytes).ok());
        RC_ASSERT(*read_file(path("a")) == bytes);
        const std::size_t part = bytes.size() / 2;
        RC_ASSERT(*read_file(path("a"), part) ==
                  Bytes(bytes.begin(), bytes.begin() + static_cast<long>(part)));
    }));
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

TEST_F(FileTest, ASourceReadsAnyPartFromAnyThread) {
    constexpr std::uint64_t size = 300000;
    ASSERT_TRUE(write_file_atomically(path("a"), sequence(0, size)).ok());
    const auto source = open_source(path("a"));
    ASSERT_TRUE(source.ok());
    EXPECT_EQ((*source)->size(), size);
    EXPECT_EQ(read_from(**source, size, 0), Bytes{});
    std::vector<std::thread> threads;
    for (std::uint64_t t = 0; t < 4; ++t)
        threads.emplace_back([&, t] {
            for (std::uint64_t k = 0; k < 50; ++k) {
                const std::uint64_t offset = (k * 7919 + t * 31337) % size;
                const std::uint64_t count = std::min<std::uint64_t>(size - offset, 5000);
                EXPECT_EQ(read_from(**source, offset, count), sequence(offset, count));
            }
        });
    for (std::thread& thread : threads) thread.join();
}

TEST_F(FileTest, ASourceOfAPipeIsReadToItsEnd) {
    ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
    std::thread writer([&] {
        const Bytes bytes = sequence(0, 100000);
        std::ofstream(path("pipe"), std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()),
                   static_cast<std::streamsize>(bytes.size()));
    });
    const auto source = open_source(path("pipe"));
    writer.join();
    ASSERT_TRUE(source.ok());
    ASSERT_EQ((*source)->size(), 100000U);
    EXPECT_EQ(read_from(**source, 99000, 1000), sequence(99000, 1000));
    EXPECT_EQ(read_from(**source, 10, 50), sequence(10, 50));
}

TEST_F(FileTest, SourcesOfEmptyAndOfPretendedlyEmptyFiles) {
    ASSERT_TRUE(write_file_atomically(path("a"), Bytes{}).ok());
    const auto empty = open_source(path("a"));
    ASSERT_TRUE(empty.ok());
    EXPECT_EQ((*empty)->size(), 0U);
    if (!fs::exists("/proc/self/stat")) GTEST_SKIP() << "no /proc";
    const auto stat = open_source("/proc/self/stat");
    ASSERT_TRUE(stat.ok());
    const std::string process = std::to_string(::getpid()) + " ";
    EXPECT_EQ(read_from(**stat, 0, process.size()), Bytes(process.begin(), process.end()));
}

TEST_F(FileTest, SourceErrorsNameFileAndReason) {
    EXPECT_EQ(open_source(path("none")).error().text(),
              path("none") + ": can not read: No such file or directory");
    EXPECT_EQ(open_source(path("none")).error().code, ErrorCode::NotFound);
    EXPECT_EQ(open_source(path("")).error().text(), path("") + ": can not read: Is a directory");

    ASSERT_TRUE(write_file_atomically(path("a"), sequence(0, 1000)).ok());
    const auto source = open_source(path("a"));
    ASSERT_TRUE(source.ok());
    fs::resize_file(path("a"), 600);
    Bytes into(300);
    EXPECT_TRUE((*source)->read(300, into).ok());
    const Status cut = (*source)->read(500, into);
    ASSERT_FALSE(cut.ok());
    EXPECT_EQ(cut.error().code, ErrorCode::BadFile);
    EXPECT_EQ(cut.error().text(), path("a") + ": ends at byte 600 where more bytes were expected");
}

TEST_F(FileTest, AnOutputFileIsASink) {
    auto file = OutputFile::create(path("out"));
    ASSERT_TRUE(file.ok());
    ByteSink& sink = *file;
    ASSERT_TRUE(sink.write(sequence(0, 1000)).ok());
    ASSERT_TRUE(sink.write(sequence(1000, 500)).ok());
    ASSERT_TRUE(file->commit().ok());
    EXPECT_EQ(*read_file(path("out")), sequence(0, 1500));
}

TEST_F(FileTest, ASpoolReadsBackOnBothSidesOfItsMemory) {
    // The third piece exceeds the memory: all moves to the file.
    FileSpool spool(path("out.relief"));
    constexpr std::uint64_t half = FileSpool::kMemory / 2;
    EXPECT_EQ(spool.size(), 0U);
    EXPECT_EQ(*spool.append(sequence(0, half)), 0U);
    EXPECT_EQ(*spool.append(sequence(half, half)), half);
    EXPECT_EQ(read_from(spool, half - 100, 200), sequence(half - 100, 200));
    EXPECT_EQ(*spool.append(sequence(2 * half, 1000)), 2 * half);
    EXPECT_EQ(*spool.append({}), 2 * half + 1000);
    EXPECT_EQ(*spool.append(sequence(2 * half + 1000, 3000)), 2 * half + 1000);
    EXPECT_EQ(spool.size(), 2 * half + 4000);
    EXPECT_EQ(files(), Names{}) << "the temporary file has a name";

    std::vector<std::thread> threads;
    for (std::uint64_t t = 0; t < 4; ++t)
        threads.emplace_back([&, t] {
            for (std::uint64_t k = 0; k < 20; ++k) {
                const std::uint64_t offset = (k * 1048583 + t * 524309) % (2 * half - 1000);
                EXPECT_EQ(read_from(spool, offset, 5000), sequence(offset, 5000));
            }
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(read_from(spool, 0, spool.size()), sequence(0, 2 * half + 4000));

    Bytes into(2);
    const Status beyond = spool.read(spool.size() - 1, into);
    ASSERT_FALSE(beyond.ok());
    EXPECT_EQ(beyond.error().code, ErrorCode::BadFile);
}

TEST_F(FileTest, ASpoolThatCanNotLieBesideTheOutputTakesTheTemporaryDirectory) {
    const Environment elsewhere("TMPDIR", path(""));
    const Bytes bytes = sequence(0, FileSpool::kMemory + 1);
    for (const std::string& name : {path("no/out"), std::string("/dev/null")}) {
        FileSpool spool(name);
        ASSERT_TRUE(spool.append(bytes).ok()) << name;
        EXPECT_EQ(read_from(spool, FileSpool::kMemory - 5, 6), sequence(FileSpool::kMemory - 5, 6));
    }
    EXPECT_EQ(files(), Names{});
}

TEST_F(FileTest, ASpoolOnAFullDiskSaysWhereAndKeepsWhatItHas) {
    const Environment same("TMPDIR", path(""));
    FileSpool spool(path("out"));
    ASSERT_TRUE(spool.append(sequence(0, 1000)).ok());
    // The file can not take the bytes from memory, or takes them and not the new ones.
    const std::string directory = fs::path(path("out")).parent_path().string();
    for (const auto& [most, place] : {std::pair{500, std::string("/tmp")}, {5000, directory}}) {
        const FileSizeLimit limit(static_cast<rlim_t>(most));
        const auto failed = spool.append(Bytes(FileSpool::kMemory));
        ASSERT_FALSE(failed.ok());
        EXPECT_EQ(failed.error().code, ErrorCode::CannotWrite);
        EXPECT_EQ(failed.error().where, place);
        EXPECT_EQ(spool.size(), 1000U);
        EXPECT_EQ(read_from(spool, 0, 1000), sequence(0, 1000));
    }
    EXPECT_EQ(*spool.append(sequence(1000, 10)), 1000U);
    EXPECT_EQ(read_from(spool, 990, 20), sequence(990, 20));
    EXPECT_EQ(files(), Names{});
}

}  // namespace
}  // namespace relief::io
