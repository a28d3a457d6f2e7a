#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "relief/core/raster.h"

namespace relief {
namespace {

/// The same value as one at a time, for every type, with and without nodata, in place too.
TEST(StoredRow, EqualsStoredValueForEveryType) {
    const std::vector<double> values = {0,         -0.0,      0.5,   1.5,    -3.25, 7,
                                        7.0000001, -32768.4,  255.5, 1e300,  -1e40, 65535.6,
                                        7.0000012, -9999.002, 3e9,   -1e-45, 0.1,   -9999};
    for (int t = 0; t <= static_cast<int>(SampleType::Float64); ++t) {
        const auto type = static_cast<SampleType>(t);
        for (const std::optional<double> nodata : {std::optional<double>(),
                                                   {7.0},
                                                   {-9999.0},
                                                   {0.0},
                                                   {1e-46},
                                                   {1e300},
                                                   {-3.4e38},
                                                   {std::numeric_limits<double>::quiet_NaN()}}) {
            std::vector<double> row = values;
            stored_row(row.data(), static_cast<std::int64_t>(row.size()), type, nodata, row.data());
            for (std::size_t k = 0; k < row.size(); ++k) {
                const double expected = stored_value(values[k], type, nodata);
                EXPECT_EQ(expected, row[k]) << sample_type_name(type) << ' ' << values[k];
                EXPECT_EQ(std::signbit(expected), std::signbit(row[k]));
            }
        }
    }
}

}  // namespace
}  // namespace relief
