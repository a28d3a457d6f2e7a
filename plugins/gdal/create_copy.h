#pragma once

#include <gdal_priv.h>

/// Making .relief files of GDAL's datasets.
namespace relief::gdal {

/// The list of creation options that GDAL shows and checks.
extern const char* const kCreationOptions;

/// GDAL's pfnCreateCopy.
GDALDataset* create_copy(const char* path, GDALDataset* source, int strict, char** options,
                         GDALProgressFunc progress, void* progress_data);

}  // namespace relief::gdal
