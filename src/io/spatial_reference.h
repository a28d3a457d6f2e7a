#pragma once

#include <ogr_srs_api.h>

#include <memory>
#include <string>
#include <type_traits>

/// What readers and writers share of coordinate reference systems.
namespace relief::io::detail {

struct DestroyReference {
    void operator()(OGRSpatialReferenceH reference) const { OSRDestroySpatialReference(reference); }
};
using SpatialReference =
    std::unique_ptr<std::remove_pointer_t<OGRSpatialReferenceH>, DestroyReference>;

/// The system that GeoReference::crs names, x being east or longitude; null if GDAL does not know
/// it. The text may come from a file that nobody trusts: no other file is read for it, and nothing
/// is fetched.
[[nodiscard]] SpatialReference reference_of(const std::string& crs);

/// Authority and code of a reference system if they stand for the same WKT, else the WKT.
[[nodiscard]] std::string crs_of(OGRSpatialReferenceH reference);

}  // namespace relief::io::detail
