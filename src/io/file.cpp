#include "relief/io/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <filesystem>
#include <system_error>

namespace relief::io {

namespace fs = std::filesystem;

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
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor() {
        if (fd_ >= 0) ::close(fd_);
    }
    [[nodiscard]] int get() const { return fd_; }

  private:
    int fd_;
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
    const auto fail = [&](int error) {
        return Error{ErrorCode::NotFound, fmt::format("can not read: {}", reason(error)), path};
    };
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (file.get() < 0) return fail(errno);
    struct stat status {};
    if (::fstat(file.get(), &status) != 0) return fail(errno);
    if (S_ISDIR(status.st_mode)) return fail(EISDIR);

    // The size is only a hint, a file may grow; one byte more finds the end without another round.
    const auto hint = static_cast<std::uint64_t>(std::max<off_t>(status.st_size, 0)) + 1;
    constexpr std::uint64_t step = std::uint64_t{1} << 16;
    std::vector<std::uint8_t> bytes;
    while (bytes.size() < max_bytes) {
        const std::uint64_t have = bytes.size();
        const std::uint64_t ahead = hint > have ? hint - have : step;
        const std::uint64_t room = std::min(max_bytes - have, ahead);
        bytes.resize(have + room);
        const ssize_t got = ::read(file.get(), bytes.data() + have, room);
        const int error = errno;
        bytes.resize(have + static_cast<std::uint64_t>(std::max<ssize_t>(got, 0)));
        if (got == 0) break;
        if (got < 0 && error != EINTR) return fail(error);
    }
    return bytes;
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

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      staged_(std::move(other.staged_)) {}

OutputFile::~OutputFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

Result<OutputFile> OutputFile::create(const std::string& path) {
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
    while (!bytes.empty()) {
        const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
        if (written < 0 && errno != EINTR) return cannot_write(path_, errno);
        bytes = bytes.subspan(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
    }
    return {};
}

Status OutputFile::commit() {
    RELIEF_CHECK(sync(descriptor_, path_));
    if (::close(std::exchange(descriptor_, -1)) != 0) return cannot_write(path_, errno);
    return staged_ ? staged_->commit() : Status();
}

Status write_file_atomically(const std::string& path, std::span<const std::uint8_t> bytes) {
    RELIEF_TRY(OutputFile file, OutputFile::create(path));
    RELIEF_CHECK(file.write(bytes));
    return file.commit();
}

}  // namespace relief::io
