#include "temporary_folder.h"

#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

namespace relief::editor {

namespace fs = std::filesystem;

Result<TemporaryFolder> TemporaryFolder::create() {
    std::error_code failed;
    std::string path = (fs::temp_directory_path(failed) / "relief-XXXXXX").string();
    if (failed || !::mkdtemp(path.data()))
        return Error{ErrorCode::CannotWrite,
                     "no temporary folder can be made; set TMPDIR to a place you may write to",
                     path};
    return TemporaryFolder(std::move(path));
}

TemporaryFolder::TemporaryFolder(TemporaryFolder&& other) noexcept
    : path_(std::exchange(other.path_, {})) {}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
}

}  // namespace relief::editor
