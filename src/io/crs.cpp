#include "relief/io/crs.h"

#include <ogr_spatialref.h>

#include "io/gdal_scope.h"
#include "io/spatial_reference.h"

namespace relief::io {

SpatialReference reference_of(const std::string& crs) {
    SpatialReference reference(OSRNewSpatialReference(nullptr));
    OSRSetAxisMappingStrategy(reference.get(), OAMS_TRADITIONAL_GIS_ORDER);
    const OGRErr error =
        OGRSpatialReference::FromHandle(reference.get())
            ->SetFromUserInput(crs.c_str(),
                               OGRSpatialReference::SET_FROM_USER_INPUT_LIMITATIONS_get());
    if (crs.empty() || error != OGRERR_NONE) return {};
    return reference;
}

namespace detail {

namespace {

std::string wkt_of(OGRSpatialReferenceH reference) {
    char* text = nullptr;
    const char* const format[] = {"FORMAT=WKT2_2019", nullptr};
    std::string wkt;
    if (OSRExportToWktEx(reference, &text, format) == OGRERR_NONE) wkt = text;
    CPLFree(text);
    return wkt;
}

}  // namespace

std::string crs_of(OGRSpatialReferenceH reference) {
    std::string wkt = wkt_of(reference);
    const char* authority = OSRGetAuthorityName(reference, nullptr);
    const char* code = OSRGetAuthorityCode(reference, nullptr);
    if (!authority || !code) return wkt;
    std::string name = std::string(authority) + ":" + code;
    const SpatialReference known = reference_of(name);
    return known && wkt_of(known.get()) == wkt ? name : wkt;
}

}  // namespace detail

Result<std::string> crs_from_user(const std::string& text) {
    const detail::GdalScope gdal;
    const SpatialReference reference(OSRNewSpatialReference(nullptr));
    if (OSRSetFromUserInput(reference.get(), text.c_str()) != OGRERR_NONE)
        return Error{ErrorCode::InvalidArgument,
                     "no coordinate reference system is known as '" + text + "'" + gdal.because() +
                         "; name one as EPSG:26911, or give WKT, a PROJ string or a .prj file",
                     ""};
    return detail::crs_of(reference.get());
}

}  // namespace relief::io
