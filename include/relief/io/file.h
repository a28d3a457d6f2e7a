#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "relief/core/result.h"
#include "relief/core/stream.h"

/// Files in, whole or at any place, and outputs that appear only when they are complete. Paths may
/// be of GDAL's virtual file systems: /vsicurl/, /vsizip/, /vsimem/ and the like.
namespace relief::io {

namespace detail {
class VirtualOutput;
}

/// The first `max_bytes` bytes of a file, or all of it. Pipes are read to their end.
/// Errors: NotFound (missing, unreadable or a directory).
[[nodiscard]] Result<std::vector<std::uint8_t>> read_file(
    const std::string& path, std::uint64_t max_bytes = std::numeric_limits<std::uint64_t>::max());

/// A file to be read at any place, by several threads at once. Nothing of it is kept in memory,
/// except of pipes and other inputs that can not be read twice: they are read to their end.
/// Errors: NotFound (missing, unreadable or a directory); reading: BadFile (the file shrank, the
/// disk failed).
[[nodiscard]] Result<std::shared_ptr<const ByteSource>> open_source(const std::string& path);

/// A place beside the target for writers that open files by name. Whatever they leave in the
/// directory of temporary_path() (the file itself and side files such as .prj or .aux.xml) moves to
/// the target's directory on commit(), the target last; without a commit it disappears with this
/// object.
class StagedOutput {
  public:
    /// Makes the staging directory. A symbolic link is followed: its target is what gets replaced.
    /// Errors: CannotWrite (no such directory, no permission, target is a directory, device or
    /// read-only file).
    [[nodiscard]] static Result<StagedOutput> beside(const std::string& path);

    StagedOutput(StagedOutput&& other) noexcept;
    StagedOutput& operator=(StagedOutput&&) = delete;
    ~StagedOutput();

    /// Where to write: the target's own file name, in the staging directory.
    [[nodiscard]] const std::string& temporary_path() const { return temporary_; }

    /// Syncs and moves the files. An existing target keeps its permissions. Errors: CannotWrite.
    [[nodiscard]] Status commit();

  private:
    StagedOutput(std::string target, std::string directory);

    std::string target_;
    std::string directory_;  ///< empty once moved from or committed
    std::string temporary_;
};

/// A file that is written piece by piece and appears under its name on commit(); without a commit
/// nothing stays. Devices and pipes (/dev/stdout) and files of virtual file systems can not be
/// replaced and are written directly.
class OutputFile final : public ByteSink {
  public:
    /// Errors: as StagedOutput::beside.
    [[nodiscard]] static Result<OutputFile> create(const std::string& path);

    OutputFile(OutputFile&& other) noexcept;
    OutputFile& operator=(OutputFile&&) = delete;
    ~OutputFile() override;

    /// Errors: CannotWrite (disk full, quota, broken pipe).
    [[nodiscard]] Status write(std::span<const std::uint8_t> bytes) override;
    /// Syncs, closes and renames. Errors: CannotWrite.
    [[nodiscard]] Status commit();

  private:
    OutputFile(std::string path, int descriptor, std::optional<StagedOutput> staged);
    explicit OutputFile(std::unique_ptr<detail::VirtualOutput> file);

    std::string path_;
    int descriptor_ = -1;
    std::optional<StagedOutput> staged_;  ///< none for a device or pipe
    std::unique_ptr<detail::VirtualOutput> virtual_;
};

/// A spool that stays in memory up to kMemory bytes and moves to a temporary file with the append
/// that exceeds them. The file has no name: it vanishes with this object, or with the process. Read
/// by any thread, but not while append() runs.
class FileSpool final : public Spool {
  public:
    static constexpr std::uint64_t kMemory = std::uint64_t{1} << 24;

    /// The temporary file will lie in the directory of `path`; in $TMPDIR or else /tmp if that can
    /// not be written or `path` is a device or pipe.
    explicit FileSpool(std::string path) : path_(std::move(path)) {}
    ~FileSpool() override;

    [[nodiscard]] std::uint64_t size() const override { return size_; }
    Status read(std::uint64_t offset, std::span<std::uint8_t> into) const override;
    /// Errors: CannotWrite, naming the directory.
    [[nodiscard]] Result<std::uint64_t> append(std::span<const std::uint8_t> bytes) override;

  private:
    Status move_to_file();

    std::string path_;
    std::string directory_;  ///< of the temporary file
    int descriptor_ = -1;    ///< open once all bytes are in the file
    Bytes bytes_;
    std::uint64_t size_ = 0;
};

/// Creates or replaces a file as a whole. Errors: as OutputFile.
[[nodiscard]] Status write_file_atomically(const std::string& path,
                                           std::span<const std::uint8_t> bytes);

}  // namespace relief::io
