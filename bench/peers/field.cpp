#include "field.h"

#include <algorithm>
#include <cmath>

#include "relief/codec/fill.h"
#include "relief/codec/mask_coder.h"
#include "relief/io/raster.h"

namespace relief::peers {

namespace {

/// The plane in the type of its file.
template <class T>
std::vector<T> row_by_row(const Grid<double>& plane) {
    std::vector<T> values;
    values.reserve(static_cast<std::size_t>(plane.count()));
    for (std::int64_t r = 0; r < plane.rows(); ++r)
        for (std::int64_t c = 0; c < plane.cols(); ++c)
            values.push_back(
                static_cast<T>(std::is_integral_v<T> ? std::nearbyint(plane(r, c)) : plane(r, c)));
    return values;
}

void take_mask(Field& field) {
    const Grid<std::uint8_t>& mask = field.raster.mask;
    field.valid_count = field.raster.valid_count();
    if (mask.empty()) return;
    for (std::int64_t r = 0; r < mask.rows(); ++r)
        field.valid.insert(field.valid.end(), mask.row(r), mask.row(r) + mask.cols());
    field.mask_bytes = codec::encode_mask(mask.view()).size();
}

/// decoded_at(k): sample k, row by row.
template <class At>
Deviation deviation_of(const Field& field, double bound, At decoded_at) {
    Deviation result;
    double square = 0;
    for (std::size_t k = 0; k < field.count(); ++k) {
        if (!field.valid.empty() && field.valid[k] == 0) continue;
        const double value =
            std::visit([k](const auto& all) { return static_cast<double>(all[k]); }, field.values);
        const double error = std::abs(decoded_at(k) - value);
        result.max_error = std::max(result.max_error, error);
        square += error * error;
        result.over += !(error <= bound);
    }
    result.rms_error = std::sqrt(square / static_cast<double>(field.valid_count));
    return result;
}

}  // namespace

Result<Field> read_field(const std::string& path) {
    Field field;
    RELIEF_TRY(field.raster, io::read_raster(path));
    const SampleType type = field.raster.type;
    if (field.raster.planes.size() != 1 ||
        (type != SampleType::Int16 && type != SampleType::UInt8 && type != SampleType::Float32))
        return Error{ErrorCode::Unsupported, "compared are single planes of int16 or float32",
                     path};
    take_mask(field);
    if (field.valid_count == 0) return Error{ErrorCode::BadInput, "no sample is valid", path};
    const Grid<double> plane = codec::filled(field.raster.planes[0].view(), field.raster.mask);
    if (type == SampleType::Float32)
        field.values = row_by_row<float>(plane);
    else
        field.values = row_by_row<std::int16_t>(plane);
    std::visit(
        [&field](const auto& all) {
            const auto [lowest, highest] = std::minmax_element(all.begin(), all.end());
            field.lowest = *lowest;
            field.highest = *highest;
        },
        field.values);
    return field;
}

Result<Deviation> deviation(const Field& field, const Decoded& decoded, double bound) {
    const auto other_size = [] {
        return Error{ErrorCode::BadInput, "decoded to another number of samples", ""};
    };
    if (const auto* raster = std::get_if<Raster>(&decoded)) {
        if (raster->rows != field.raster.rows || raster->cols != field.raster.cols)
            return other_size();
        return deviation_of(field, bound, [raster](std::size_t k) {
            const std::size_t cols = static_cast<std::size_t>(raster->cols);
            return raster->planes[0](static_cast<std::int64_t>(k / cols),
                                     static_cast<std::int64_t>(k % cols));
        });
    }
    const auto compare = [&](const auto& all) -> Result<Deviation> {
        if (all.size() != field.count()) return other_size();
        return deviation_of(field, bound,
                            [&all](std::size_t k) { return static_cast<double>(all[k]); });
    };
    if (const auto* integers = std::get_if<std::vector<std::int16_t>>(&decoded))
        return compare(*integers);
    return compare(*std::get_if<std::vector<float>>(&decoded));
}

}  // namespace relief::peers
