#include "relief/io/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "io/gdal_scope.h"
#include "io/virtual_file.h"

namespace relief::io {

namespace fs = std::filesystem;
using namespace std::string_literals;

namespace {

std::string reason(int error) {
    return std::generic_category().message(error);
}

Error cannot_write(const std::string& path, int error) {
    const char* advice = "";
    if (error == ENOSPC || error == EDQUOT) advice = "; free some space or write elsewhere";
    if (error == EACCES || error == EPERM || error == EROFS)
        advice = "; choose a place you may write to";
    if (error == ENOENT) advice = "; create the directory first";
    return {ErrorCode::CannotWrite, fmt::format("can not write: {}{}", reason(error), advice),
            path};
}

/// Closes an open file on scope exit.
class Descriptor {
  public:
    explicit Descriptor(int fd) : fd_(fd) {}
    Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    Descriptor& operator=(Descriptor&&) = delete;
    ~Descriptor() {
        if (fd_ >= 0) ::close(fd_);
    }
    [[nodiscard]] int get() const { return fd_; }
    [[nodiscard]] int release() { return std::exchange(fd_, -1); }

  private:
    int fd_;
};

Error cannot_read(const std::string& path, int error) {
    return {ErrorCode::NotFound, fmt::format("can not read: {}", reason(error)), path};
}

struct Input {
    Descriptor file;
    struct stat status;
};

Result<Input> open_input(const std::string& path) {
    Input input{Descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC)), {}};
    if (input.file.get() < 0) return cannot_read(path, errno);
    if (::fstat(input.file.get(), &input.status) != 0) return cannot_read(path, errno);
    if (S_ISDIR(input.status.st_mode)) return cannot_read(path, EISDIR);
    return input;
}

Result<Bytes> read_to_end(const Input& input, const std::string& path, std::uint64_t max_bytes) {
    // The size is only a hint, a file may grow; one byte more finds the end without another round.
    const auto hint = static_cast<std::uint64_t>(std::max<off_t>(input.status.st_size, 0)) + 1;
    constexpr std::uint64_t step = std::uint64_t{1} << 16;
    Bytes bytes;
    while (bytes.size() < max_bytes) {
        const std::uint64_t have = bytes.size();
        const std::uint64_t ahead = hint > have ? hint - have : step;
        const std::uint64_t room = std::min(max_bytes - have, ahead);
        bytes.resize(have + room);
        const ssize_t got = ::read(input.file.get(), bytes.data() + have, room);
        const int error = errno;
        bytes.resize(have + static_cast<std::uint64_t>(std::max<ssize_t>(got, 0)));
        if (got == 0) break;
        if (got < 0 && error != EINTR) return cannot_read(path, error);
    }
    return bytes;
}

/// Fills `into` from `offset` on.
Status read_at(int descriptor, std::uint64_t offset, std::span<std::uint8_t> into,
               const std::string& path) {
    while (!into.empty()) {
        const ssize_t got =
            ::pread(descriptor, into.data(), into.size(), static_cast<off_t>(offset));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0)
            return Error{ErrorCode::BadFile, fmt::format("can not read: {}", reason(errno)), path};
        if (got == 0)
            return Error{ErrorCode::BadFile,
                         fmt::format("ends at byte {} where more bytes were expected", offset),
                         path};
        offset += static_cast<std::uint64_t>(got);
        into = into.subspan(static_cast<std::size_t>(got));
    }
    return {};
}

Status write_at(int descriptor, std::uint64_t offset, std::span<const std::uint8_t> bytes,
                const std::string& path) {
    while (!bytes.empty()) {
        const ssize_t written =
            ::pwrite(descriptor, bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return cannot_write(path, errno);
        offset += static_cast<std::uint64_t>(written);
        bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
    return {};
}

class FileSource final : public ByteSource {
  public:
    FileSource(std::string path, Descriptor file, std::uint64_t size)
        : path_(std::move(path)), file_(std::move(file)), size_(size) {}
    [[nodiscard]] std::uint64_t size() const override { return size_; }
    Status read(std::uint64_t offset, std::span<std::uint8_t> into) const override {
        return read_at(file_.get(), offset, into, path_);
    }

  private:
    std::string path_;
    Descriptor file_;
    std::uint64_t size_;
};

/// What can not sync (pipes, devices, some network directories) is content with close.
Status sync(int descriptor, const std::string& path) {
    if (::fsync(descriptor) != 0 && errno != EINVAL && errno != ENOTSUP && errno != EROFS)
        return cannot_write(path, errno);
    return {};
}

Status sync_path(const std::string& path) {
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (file.get() < 0) return cannot_write(path, errno);
    return sync(file.get(), path);
}

/// The file that a chain of symbolic links ends at.
std::string follow_links(const std::string& path) {
    std::error_code error;
    if (!fs::is_symlink(path, error)) return path;
    const fs::path real = fs::weakly_canonical(path, error);
    return error ? path : real.string();
}

std::string directory_of(const std::string& path) {
    const std::string parent = fs::path(path).parent_path().string();
    return parent.empty() ? "." : parent;
}

/// A device, pipe or socket: written in place, because a file must not take its name.
bool is_stream(const std::string& path) {
    std::error_code error;
    return fs::is_other(fs::status(path, error));
}

Status check_target(const std::string& target, const std::string& path) {
    std::error_code error;
    const auto refuse = [&](std::string message) {
        return Error{ErrorCode::CannotWrite, std::move(message), path};
    };
    if (path.empty()) return refuse("the output needs a file name");
    if (fs::is_directory(target, error)) return refuse("is a directory; give a file name");
    if (is_stream(target)) return refuse("is a device or pipe; this format needs a regular file");
    const std::string home = directory_of(target);
    if (!fs::is_directory(home, error))
        return refuse(fmt::format("there is no directory '{}'; create it first", home));
    if (fs::exists(target, error) && ::access(target.c_str(), W_OK) != 0)
        return cannot_write(path, errno);
    return {};
}

}  // namespace

Result<std::vector<std::uint8_t>> read_file(const std::string& path, std::uint64_t max_bytes) {
    if (detail::is_virtual_path(path)) {
        RELIEF_TRY(const auto source, detail::open_virtual_source(path));
        Bytes bytes(std::min(max_bytes, source->size()));
        RELIEF_CHECK(source->read(0, bytes));
        return bytes;
    }
    RELIEF_TRY(const Input input, open_input(path));
    return read_to_end(input, path, max_bytes);
}

Result<std::shared_ptr<const ByteSource>> open_source(const std::string& path) {
    if (detail::is_virtual_path(path)) return detail::open_virtual_source(path);
    RELIEF_TRY(Input input, open_input(path));
    // Files that only pretend to be empty, as those of /proc do, are read like pipes.
    if (S_ISREG(input.status.st_mode) && input.status.st_size > 0)
        return std::shared_ptr<const ByteSource>(std::make_shared<FileSource>(
            path, std::move(input.file), static_cast<std::uint64_t>(input.status.st_size)));
    RELIEF_TRY(Bytes bytes, read_to_end(input, path, std::numeric_limits<std::uint64_t>::max()));
    return std::shared_ptr<const ByteSource>(std::make_shared<MemorySource>(std::move(bytes)));
}

StagedOutput::StagedOutput(std::string target, std::string directory)
    : target_(std::move(target)),
      directory_(std::move(directory)),
      temporary_((fs::path(directory_) / fs::path(target_).filename()).string()) {}

StagedOutput::StagedOutput(StagedOutput&& other) noexcept
    : target_(std::move(other.target_)),
      directory_(std::exchange(other.directory_, {})),
      temporary_(std::move(other.temporary_)) {}

StagedOutput::~StagedOutput() {
    std::error_code error;
    if (!directory_.empty()) fs::remove_all(directory_, error);
}

Result<StagedOutput> StagedOutput::beside(const std::string& path) {
    static std::atomic<unsigned> counter{0};
    const std::string target = follow_links(path);
    RELIEF_CHECK(check_target(target, path));
    for (;;) {
        const std::string home = directory_of(target);
        const std::string name = fmt::format("{}/.relief-{}-{}", home, ::getpid(), counter++);
        if (::mkdir(name.c_str(), 0777) == 0) return StagedOutput(target, name);
        if (errno != EEXIST) return cannot_write(path, errno);
    }
}

Status StagedOutput::commit() {
    const fs::path home = directory_of(target_);
    std::error_code error;
    std::vector<fs::path> files;
    for (fs::directory_iterator it(directory_, error), end; !error && it != end;
         it.increment(error))
        files.push_back(it->path());
    if (error) return cannot_write(target_, error.value());
    // The target comes last: who sees it sees its side files too.
    std::sort(files.begin(), files.end(), [&](const fs::path& a, const fs::path& b) {
        return std::pair(a == temporary_, a) < std::pair(b == temporary_, b);
    });
    for (const fs::path& file : files) RELIEF_CHECK(sync_path(file.string()));

    struct stat existing {};
    if (::stat(target_.c_str(), &existing) == 0 &&
        ::chmod(temporary_.c_str(), existing.st_mode & 07777) != 0)
        return cannot_write(target_, errno);
    for (const fs::path& file : files) {
        fs::rename(file, home / file.filename(), error);
        if (error) return cannot_write(target_, error.value());
    }
    fs::remove(directory_, error);
    directory_.clear();
    return sync_path(home.string());
}

OutputFile::OutputFile(std::string path, int descriptor, std::optional<StagedOutput> staged)
    : path_(std::move(path)), descriptor_(descriptor), staged_(std::move(staged)) {}

OutputFile::OutputFile(std::unique_ptr<detail::VirtualOutput> file) : virtual_(std::move(file)) {}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : ByteSink(),
      path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      staged_(std::move(other.staged_)),
      virtual_(std::move(other.virtual_)) {}

OutputFile::~OutputFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

Result<OutputFile> OutputFile::create(const std::string& path) {
    if (detail::is_virtual_path(path)) {
        RELIEF_TRY(auto file, detail::VirtualOutput::create(path));
        return OutputFile(std::move(file));
    }
    std::optional<StagedOutput> staged;
    if (!is_stream(path)) {
        RELIEF_TRY(StagedOutput stage, StagedOutput::beside(path));
        staged.emplace(std::move(stage));
    }
    const std::string& name = staged ? staged->temporary_path() : path;
    const int create = staged ? O_CREAT | O_EXCL : 0;
    const int descriptor = ::open(name.c_str(), O_WRONLY | O_CLOEXEC | create, 0666);
    if (descriptor < 0) return cannot_write(path, errno);
    return OutputFile(path, descriptor, std::move(staged));
}

Status OutputFile::write(std::span<const std::uint8_t> bytes) {
    if (virtual_) return virtual_->write(bytes);
    while (!bytes.empty()) {
        const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
        if (written < 0 && errno != EINTR) return cannot_write(path_, errno);
        bytes = bytes.subspan(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
    }
    return {};
}

Status OutputFile::commit() {
    if (virtual_) return virtual_->commit();
    RELIEF_CHECK(sync(descriptor_, path_));
    if (::close(std::exchange(descriptor_, -1)) != 0) return cannot_write(path_, errno);
    return staged_ ? staged_->commit() : Status();
}

FileSpool::~FileSpool() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

Status FileSpool::read(std::uint64_t offset, std::span<std::uint8_t> into) const {
    if (offset > size_ || into.size() > size_ - offset)
        return Error{ErrorCode::BadFile, fmt::format("the spool ends at byte {}", size_), ""};
    if (descriptor_ >= 0) return read_at(descriptor_, offset, into, directory_);
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), into.size(), into.begin());
    return {};
}

Result<std::uint64_t> FileSpool::append(std::span<const std::uint8_t> bytes) {
    const std::uint64_t offset = size_;
    if (descriptor_ < 0 && bytes.size() > kMemory - size_) RELIEF_CHECK(move_to_file());
    if (descriptor_ < 0) {
        bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    } else {
        RELIEF_CHECK(write_at(descriptor_, offset, bytes, directory_));
    }
    size_ += bytes.size();
    return offset;
}

Status FileSpool::move_to_file() {
    const char* chosen = std::getenv("TMPDIR");
    const std::string beside = is_stream(path_) ? "" : directory_of(follow_links(path_));
    Status moved;
    for (const std::string& directory : {beside, std::string(chosen ? chosen : ""), "/tmp"s}) {
        if (directory.empty()) continue;
        std::string name = directory + "/.relief-spool-XXXXXX";
        Descriptor file(::mkostemp(name.data(), O_CLOEXEC));
        if (file.get() < 0) {
            moved = cannot_write(directory, errno);
            continue;
        }
        ::unlink(name.c_str());
        moved = write_at(file.get(), 0, bytes_, directory);
        if (!moved) continue;
        directory_ = directory;
        descriptor_ = file.release();
        bytes_ = {};
        break;
    }
    return moved;
}

Status write_file_atomically(const std::string& path, std::span<const std::uint8_t> bytes) {
    RELIEF_TRY(OutputFile file, OutputFile::create(path));
    RELIEF_CHECK(file.write(bytes));
    return file.commit();
}

}  // namespace relief::io
