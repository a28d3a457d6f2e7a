#pragma once

#include <string>

#include "relief/core/result.h"

namespace relief::editor {

/// A folder of our own that disappears with this object, with all that is in it.
class TemporaryFolder {
  public:
    /// In $TMPDIR, or else /tmp. Errors: CannotWrite.
    [[nodiscard]] static Result<TemporaryFolder> create();

    TemporaryFolder(TemporaryFolder&& other) noexcept;
    TemporaryFolder& operator=(TemporaryFolder&&) = delete;
    ~TemporaryFolder();

    [[nodiscard]] const std::string& path() const { return path_; }

  private:
    explicit TemporaryFolder(std::string path) : path_(std::move(path)) {}

    std::string path_;  ///< empty once moved from
};

}  // namespace relief::editor
