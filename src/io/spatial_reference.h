#pragma once

#include <string>

#include "relief/io/gdal.h"

namespace relief::io::detail {

/// Authority and code of a reference system if they stand for the same WKT, else the WKT.
[[nodiscard]] std::string crs_of(OGRSpatialReferenceH reference);

}  // namespace relief::io::detail
