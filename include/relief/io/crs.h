#pragma once

#include <string>

#include "relief/core/result.h"

namespace relief::io {

/// A coordinate reference system that a user names, as GeoReference::crs has it: "EPSG:26911" where
/// a code says everything, else WKT2:2019. `text` is all that GDAL understands: a code, WKT, a PROJ
/// string, the name of a file of them. Errors: InvalidArgument.
[[nodiscard]] Result<std::string> crs_from_user(const std::string& text);

}  // namespace relief::io
