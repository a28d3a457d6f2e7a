#pragma once

#include <cpl_port.h>

#include <optional>
#include <string>

#include "relief/codec/raster_sampler.h"

/// What of a file a dataset shows.
namespace relief::gdal {

/// The list of open options that GDAL shows and checks.
extern const char* const kOpenOptions;

struct OpenOptions {
    std::string path;
    codec::Quantity quantity = codec::Quantity::Value;
    std::optional<int> level = {};
    /// Sizes of pixels along x and y, in the units of the coordinates.
    struct Resolution {
        double x = 1;
        double y = 1;
    };
    std::optional<Resolution> resolution = {};

    /// Not what the file is by itself.
    [[nodiscard]] bool special() const {
        return quantity != codec::Quantity::Value || level || resolution;
    }
    /// A name for what is shown: "", "slope", "slope level 2".
    [[nodiscard]] std::string view_name() const;
};

/// Whether this names a derived raster: RELIEF:"file":slope.
[[nodiscard]] bool names_derived(const std::string& name);

/// From what GDAL was asked to open: a path, or RELIEF:"path":quantity. Errors: InvalidArgument.
[[nodiscard]] Result<OpenOptions> parse_open_options(const std::string& name, CSLConstList options);

/// Where the pixels lie among the file's samples. Errors: InvalidArgument for a level that the file
/// does not have or a resolution that gives no raster.
[[nodiscard]] Result<Sampling> pixels_of(const codec::RasterFile& file, const OpenOptions& options);

/// As many threads as GDAL_NUM_THREADS says; all without it.
void set_threads();

}  // namespace relief::gdal
