#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "relief/core/raster.h"
#include "relief/core/stream.h"
#include "relief/edit/session.h"

namespace relief::editor {

/// A file that is opened, and what is known of it besides.
struct Document {
    std::string name;                        ///< as the page shows it: without directories
    std::shared_ptr<const ByteSource> file;  ///< a .relief file
    std::string save = {};                   ///< the only path that is written; empty: none
    std::vector<std::string> notices = {};   ///< what its reader should know
    edit::OpenOptions options = {};
    std::optional<Raster> terrain = {};  ///< of a raster: its description, without samples
};

/// What the editor leaves to the program that it is part of.
struct FileAccess {
    /// A file of any kind that the program reads, without a place to save.
    std::function<Result<Document>(const std::string& path, const Progress& progress)> open;
    /// Writes a level of a .relief file in the format of the extension of `out`.
    std::function<Status(const std::string& relief, int level, const std::string& out)> decode;
};

}  // namespace relief::editor
