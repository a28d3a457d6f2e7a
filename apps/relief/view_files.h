#pragma once

#include <string>

#include "document.h"
#include "relief/core/result.h"

/// Files of all kinds into and out of the editor.
namespace relief::cli {

/// A .relief file as it is; anything else as the verbs `encode` and `fit` would make one without
/// options, in memory (rasters: profile fast, which is as exact).
[[nodiscard]] Result<editor::Document> open_document(const std::string& path,
                                                     const Progress& progress);

/// The same for a file of which nothing is known: rasters that may refer to other files are
/// refused.
[[nodiscard]] Result<editor::Document> open_dropped(const std::string& path,
                                                    const Progress& progress);

/// A level of a .relief file as a raster or mesh, by the extension of `out`. A raster becomes a
/// mesh in the coordinates of its georeference, or, where its heights have another unit than these,
/// in units of the heights from its corner.
Status export_level(const std::string& relief, int level, const std::string& out);

}  // namespace relief::cli
