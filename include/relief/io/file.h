#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "relief/core/result.h"

/// Whole files in, and outputs that appear only when they are complete.
namespace relief::io {

/// The first `max_bytes` bytes of a file, or all of it. Pipes are read to their end.
/// Errors: NotFound (missing, unreadable or a directory).
[[nodiscard]] Result<std::vector<std::uint8_t>> read_file(
    const std::string& path, std::uint64_t max_bytes = std::numeric_limits<std::uint64_t>::max());

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
/// nothing stays. Devices and pipes (/dev/stdout) can not be replaced and are written directly.
class OutputFile {
  public:
    /// Errors: as StagedOutput::beside.
    [[nodiscard]] static Result<OutputFile> create(const std::string& path);

    OutputFile(OutputFile&& other) noexcept;
    OutputFile& operator=(OutputFile&&) = delete;
    ~OutputFile();

    /// Errors: CannotWrite (disk full, quota, broken pipe).
    [[nodiscard]] Status write(std::span<const std::uint8_t> bytes);
    /// Syncs, closes and renames. Errors: CannotWrite.
    [[nodiscard]] Status commit();

  private:
    OutputFile(std::string path, int descriptor, std::optional<StagedOutput> staged);

    std::string path_;
    int descriptor_ = -1;
    std::optional<StagedOutput> staged_;  ///< none for a device or pipe
};

/// Creates or replaces a file as a whole. Errors: as OutputFile.
[[nodiscard]] Status write_file_atomically(const std::string& path,
                                           std::span<const std::uint8_t> bytes);

}  // namespace relief::io
