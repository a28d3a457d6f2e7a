#include "relief/core/raster.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace relief {

namespace {

constexpr std::array<std::string_view, 7> kNames = {"uint8", "uint16",  "int16",  "uint32",
                                                    "int32", "float32", "float64"};

template <class T>
std::pair<double, double> range() {
    return {static_cast<double>(std::numeric_limits<T>::lowest()),
            static_cast<double>(std::numeric_limits<T>::max())};
}

/// GDAL's nodata mask takes floating-point values, of both widths, for nodata within twice this
/// part of the sum.
constexpr float kTolerance = std::numeric_limits<float>::epsilon();

template <class T>
bool reads_as(double value, double nodata) {
    const T a = static_cast<T>(value);
    const T b = static_cast<T>(nodata);
    return a == b || std::abs(a - b) < kTolerance * std::abs(a + b) * 2;
}

/// The nearest value on the side of `value`, where the type reaches that far, that surely is not
/// nodata.
template <class T>
double beside_nodata(double value, double nodata) {
    if (nodata == 0)
        return std::copysign(static_cast<double>(std::numeric_limits<T>::min()), value);
    const double step = 8.0 * static_cast<double>(kTolerance) * std::abs(nodata);
    const auto [low, high] = range<T>();
    const bool upwards = nodata + step <= high && (value >= nodata || nodata - step < low);
    return static_cast<double>(static_cast<T>(upwards ? nodata + step : nodata - step));
}

template <class T>
double stored_float(double value, std::optional<double> nodata) {
    const auto [low, high] = range<T>();
    const auto rounded = static_cast<double>(static_cast<T>(std::clamp(value, low, high)));
    if (!nodata || !reads_as<T>(rounded, *nodata)) return rounded;
    return beside_nodata<T>(value, *nodata);
}

double stored_integer(double value, double low, double high, std::optional<double> nodata) {
    // Integers have no negative zero.
    const double rounded = std::nearbyint(std::clamp(value, low, high)) + 0.0;
    if (!nodata || rounded != *nodata) return rounded;
    const bool upwards = rounded < high && (value >= rounded || rounded == low);
    return upwards ? rounded + 1 : rounded - 1;
}

}  // namespace

std::string_view sample_type_name(SampleType type) {
    return kNames[static_cast<std::size_t>(type)];
}

Result<SampleType> sample_type_from_name(std::string_view name) {
    const auto found = std::find(kNames.begin(), kNames.end(), name);
    if (found != kNames.end()) return static_cast<SampleType>(found - kNames.begin());
    std::string known;
    for (const std::string_view type : kNames)
        known += (known.empty() ? "" : ", ") + std::string(type);
    return Error{ErrorCode::InvalidArgument,
                 "no sample type '" + std::string(name) + "'; choose one of " + known, ""};
}

bool is_integer(SampleType type) {
    return type < SampleType::Float32;
}

std::pair<double, double> sample_range(SampleType type) {
    switch (type) {
        case SampleType::UInt8:
            return range<std::uint8_t>();
        case SampleType::UInt16:
            return range<std::uint16_t>();
        case SampleType::Int16:
            return range<std::int16_t>();
        case SampleType::UInt32:
            return range<std::uint32_t>();
        case SampleType::Int32:
            return range<std::int32_t>();
        case SampleType::Float32:
            return range<float>();
        case SampleType::Float64:
            break;
    }
    return range<double>();
}

double stored_value(double value, SampleType type, std::optional<double> nodata) {
    if (type == SampleType::Float32) return stored_float<float>(value, nodata);
    if (type == SampleType::Float64) return stored_float<double>(value, nodata);
    const auto [low, high] = sample_range(type);
    return stored_integer(value, low, high, nodata);
}

std::int64_t Raster::valid_count() const {
    if (mask.empty()) return rows * cols;
    std::int64_t count = 0;
    for (std::int64_t r = 0; r < rows; ++r)
        count += std::count_if(mask.row(r), mask.row(r) + cols, [](auto m) { return m != 0; });
    return count;
}

}  // namespace relief
