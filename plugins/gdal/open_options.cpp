#include "open_options.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "relief/core/parallel.h"

namespace relief::gdal {

const char* const kOpenOptions =
    "<OpenOptionList>"
    "<Option name='BAND' type='string-select' default='value' description='What is shown of the "
    "surface'><Value>value</Value><Value>slope</Value><Value>aspect</Value>"
    "<Value>hillshade</Value><Value>dx</Value><Value>dy</Value></Option>"
    "<Option name='LEVEL' type='int' description='Level of detail: 0 is the finest, each further "
    "one has half the samples a side'/>"
    "<Option name='RES' type='string' description='Size of pixels, or X,Y, in units of the "
    "coordinates: the surface at any resolution'/>"
    "</OpenOptionList>";

namespace {

constexpr const char* kPrefix = "RELIEF:";

Error wrong(std::string message) {
    return {ErrorCode::InvalidArgument, std::move(message), ""};
}

std::optional<double> positive_number(const char* text) {
    char* end = nullptr;
    const double value = CPLStrtod(text, &end);
    if (end == text || *end != '\0' || !std::isfinite(value) || value <= 0) return {};
    return value;
}

Result<OpenOptions::Resolution> parse_resolution(const char* text) {
    const CPLStringList parts(CSLTokenizeString2(text, ",", 0));
    if (parts.Count() == 1 || parts.Count() == 2) {
        const auto x = positive_number(parts[0]);
        const auto y = positive_number(parts[parts.Count() - 1]);
        if (x && y) return OpenOptions::Resolution{*x, *y};
    }
    return wrong(
        fmt::format("RES takes one or two positive numbers, as 10 or 10,20, not '{}'", text));
}

Result<int> parse_level(const char* text) {
    char* end = nullptr;
    const long level = std::strtol(text, &end, 10);
    if (end != text && *end == '\0' && level >= 0 && level < 64) return static_cast<int>(level);
    return wrong(fmt::format("LEVEL takes a number from 0 on, not '{}'", text));
}

/// RELIEF:"path":quantity or RELIEF:path:quantity.
Result<OpenOptions> parse_derived(const std::string& name) {
    const std::size_t begin = std::string(kPrefix).size();
    const std::size_t colon = name.rfind(':');
    if (colon <= begin) return wrong("give RELIEF:\"file\":quantity");
    OpenOptions options;
    options.path = name.substr(begin, colon - begin);
    if (options.path.size() > 2 && options.path.front() == '"' && options.path.back() == '"')
        options.path = options.path.substr(1, options.path.size() - 2);
    RELIEF_TRY(options.quantity, codec::quantity_from_name(name.substr(colon + 1)));
    return options;
}

/// Pixels of `size`, given in samples, that cover n samples.
Result<SampleAxis> axis_of(std::int64_t n, double size) {
    const double count = std::ceil(static_cast<double>(n) / size - 1e-9);
    if (!std::isfinite(size)) return wrong("RES needs a raster whose cells have a size");
    if (!(count <= std::numeric_limits<int>::max()))
        return wrong("RES makes the raster too large; choose larger pixels");
    const auto cells = std::max<std::int64_t>(1, static_cast<std::int64_t>(count));
    return SampleAxis{0, 1, n}.cut(0, size * static_cast<double>(cells), cells);
}

}  // namespace

bool names_derived(const std::string& name) {
    return STARTS_WITH_CI(name.c_str(), kPrefix);
}

std::string OpenOptions::view_name() const {
    std::string name;
    const auto add = [&](const std::string& part) { name += (name.empty() ? "" : " ") + part; };
    if (quantity != codec::Quantity::Value) add(std::string(codec::quantity_name(quantity)));
    if (level) add(fmt::format("level {}", *level));
    if (resolution) add(fmt::format("resolution {},{}", resolution->x, resolution->y));
    return name;
}

Result<OpenOptions> parse_open_options(const std::string& name, CSLConstList list) {
    OpenOptions options{.path = name};
    if (names_derived(name)) {
        RELIEF_TRY(options, parse_derived(name));
    }
    if (const char* band = CSLFetchNameValue(list, "BAND")) {
        RELIEF_TRY(options.quantity, codec::quantity_from_name(CPLString(band).tolower()));
    }
    if (const char* level = CSLFetchNameValue(list, "LEVEL")) {
        RELIEF_TRY(options.level, parse_level(level));
    }
    if (const char* resolution = CSLFetchNameValue(list, "RES")) {
        RELIEF_TRY(options.resolution, parse_resolution(resolution));
    }
    if (options.level && options.resolution) return wrong("LEVEL and RES exclude each other");
    return options;
}

Result<Sampling> pixels_of(const codec::RasterFile& file, const OpenOptions& options) {
    if (options.resolution) {
        const Raster& about = file.description();
        const std::array<double, 6> t =
            about.geo.transform.value_or(std::array<double, 6>{0, 1, 0, 0, 0, 1});
        Sampling pixels;
        RELIEF_TRY(pixels.rows,
                   axis_of(about.rows, options.resolution->y / std::hypot(t[2], t[5])));
        RELIEF_TRY(pixels.cols,
                   axis_of(about.cols, options.resolution->x / std::hypot(t[1], t[4])));
        return pixels;
    }
    const int level = options.level.value_or(0);
    RELIEF_CHECK(file.check_window(level, {0, 0, 1, 1}));
    return file.samples_of_level(level, file.box(level));
}

void set_threads() {
    const char* wanted = CPLGetConfigOption("GDAL_NUM_THREADS", "ALL_CPUS");
    set_thread_count(EQUAL(wanted, "ALL_CPUS") ? 0 : std::max(1, std::atoi(wanted)));
}

}  // namespace relief::gdal
