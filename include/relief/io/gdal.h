#pragma once

#include <gdal.h>
#include <ogr_srs_api.h>

#include <memory>
#include <string>
#include <type_traits>

#include "relief/io/raster.h"

/// For code that uses GDAL itself, such as drivers. The only public header that includes GDAL's.
namespace relief::io {

/// GDAL belongs to the program that calls us, as it does in a driver: this library leaves its
/// drivers and its block cache alone from now on, for the whole process. Call before anything else.
void leave_gdal_to_its_program();

[[nodiscard]] GDALDataType gdal_type(SampleType type);

struct DestroyReference {
    void operator()(OGRSpatialReferenceH reference) const { OSRDestroySpatialReference(reference); }
};
using SpatialReference =
    std::unique_ptr<std::remove_pointer_t<OGRSpatialReferenceH>, DestroyReference>;

/// The system that GeoReference::crs names, x being east or longitude; null if GDAL does not know
/// it. The text may come from a file that nobody trusts: no other file is read for it, and nothing
/// is fetched.
[[nodiscard]] SpatialReference reference_of(const std::string& crs);

/// An open raster, as RasterReader::open has it; the dataset must outlive the reader. Errors:
/// BadInput as RasterReader::open.
[[nodiscard]] Result<RasterReader> reader_of(GDALDatasetH dataset);

}  // namespace relief::io
