#include <gdal_priv.h>

#include <memory>

#include "create_copy.h"
#include "dataset.h"
#include "open_options.h"
#include "relief/io/gdal.h"

/// Called by GDAL when it has loaded the plugin: the name follows from the file's.
extern "C" CPL_DLL void GDALRegister_RELIEF() {
    if (!GDAL_CHECK_VERSION("RELIEF driver") || GDALGetDriverByName("RELIEF")) return;
    relief::io::leave_gdal_to_its_program();
    auto driver = std::make_unique<GDALDriver>();
    driver->SetDescription("RELIEF");
    driver->SetMetadataItem(GDAL_DCAP_RASTER, "YES");
    driver->SetMetadataItem(GDAL_DMD_LONGNAME, "relief multiresolution spline surface");
    driver->SetMetadataItem(GDAL_DMD_EXTENSION, "relief");
    driver->SetMetadataItem(GDAL_DMD_EXTENSIONS, "relief");
    driver->SetMetadataItem(GDAL_DMD_CREATIONDATATYPES,
                            "Byte UInt16 Int16 UInt32 Int32 Float32 Float64");
    driver->SetMetadataItem(GDAL_DMD_CREATIONOPTIONLIST, relief::gdal::kCreationOptions);
    driver->SetMetadataItem(GDAL_DMD_OPENOPTIONLIST, relief::gdal::kOpenOptions);
    driver->SetMetadataItem(GDAL_DCAP_VIRTUALIO, "YES");
    driver->pfnIdentify = relief::gdal::Dataset::identify;
    driver->pfnOpen = relief::gdal::Dataset::open;
    driver->pfnCreateCopy = relief::gdal::create_copy;
    GetGDALDriverManager()->RegisterDriver(driver.release());
}
