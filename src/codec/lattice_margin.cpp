#include "codec/lattice_margin.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "codec/lattice_encode.h"

namespace relief::codec {

namespace {

/// Fewer samples than these say little.
constexpr std::int64_t kFewest = 4096;
/// Shares of means that differ by as much are no accident.
constexpr double kClear = 0.05;

/// How many samples with an index of one parity are means of their neighbours, of how many.
struct Means {
    std::int64_t held = 0;
    std::int64_t all = 0;
    [[nodiscard]] double share() const {
        return static_cast<double>(held) / static_cast<double>(all);
    }
};
using Parities = std::array<Means, 2>;

/// Up to rounding to the sample type.
bool is_mean(double before, double sample, double after, SampleType type) {
    const double rounding = is_integer(type) ? 1 : 0x1p-22 * std::abs(sample);
    return std::abs(2 * sample - before - after) <= rounding;
}

struct ParitySurvey {
    Parities rows;  ///< by the row's parity, of neighbours above and below
    Parities cols;

    void add(const RasterView& strip, std::size_t component, SampleType type) {
        const GridView<const double>& plane = strip.planes[component];
        const auto count = [&](Means& means, std::int64_t r, std::int64_t c, std::int64_t dr,
                               std::int64_t dc) {
            if (!strip.valid(r, c) || !strip.valid(r - dr, c - dc) || !strip.valid(r + dr, c + dc))
                return;
            ++means.all;
            means.held += is_mean(plane(r - dr, c - dc), plane(r, c), plane(r + dr, c + dc), type);
        };
        for (std::int64_t r = 0; r < strip.rows; ++r)
            for (std::int64_t c = 0; c < strip.cols; ++c) {
                if (r > 0 && r + 1 < strip.rows)
                    count(rows[static_cast<std::size_t>(r % 2)], r, c, 1, 0);
                if (c > 0 && c + 1 < strip.cols)
                    count(cols[static_cast<std::size_t>(c % 2)], r, c, 0, 1);
            }
    }
};

std::int64_t margin_of(const Parities& parities) {
    const auto& [even, odd] = parities;
    const bool enough = even.all >= kFewest && odd.all >= kFewest;
    return enough && even.share() > odd.share() + kClear ? 1 : 0;
}

}  // namespace

Result<LatticeMargin> choose_margin(const RasterSource& source) {
    const Raster& about = source.description();
    ParitySurvey seen;
    for (const LatticeBox& box : sample_strips(about)) {
        Raster room;
        RELIEF_TRY(const RasterView strip, source.view(box, room));
        for (std::size_t p = 0; p < strip.planes.size(); ++p) seen.add(strip, p, about.type);
    }
    return LatticeMargin{about.rows < INT32_MAX ? margin_of(seen.rows) : 0,
                         about.cols < INT32_MAX ? margin_of(seen.cols) : 0};
}

RasterWithMargin::RasterWithMargin(const RasterSource& source, LatticeMargin margin)
    : source_(source), margin_(margin), description_(description_of(source.description())) {
    description_.rows += margin.rows;
    description_.cols += margin.cols;
}

Result<RasterView> RasterWithMargin::view(const LatticeBox& window, Raster& room) const {
    if (margin_ == LatticeMargin()) return source_.view(window, room);
    return RasterSource::view(window, room);
}

Result<Raster> RasterWithMargin::read(const LatticeBox& window) const {
    const auto inner = [](std::int64_t lattice, std::int64_t margin) {
        return std::max<std::int64_t>(lattice - margin, 0);
    };
    const std::int64_t row0 = inner(window.row0, margin_.rows);
    const std::int64_t col0 = inner(window.col0, margin_.cols);
    const std::int64_t rows = inner(window.row0 + window.rows - 1, margin_.rows) - row0 + 1;
    const std::int64_t cols = inner(window.col0 + window.cols - 1, margin_.cols) - col0 + 1;
    RELIEF_TRY(Raster part, source_.read({row0, col0, rows, cols}));
    if (rows == window.rows && cols == window.cols) return part;
    const auto widened = [&]<class T>(const Grid<T>& from) {
        Grid<T> to(window.rows, window.cols);
        for (std::int64_t r = 0; r < window.rows; ++r) {
            const T* row = from.row(inner(window.row0 + r, margin_.rows) - row0);
            std::copy_n(row, cols, to.row(r) + (window.cols - cols));
            if (window.cols > cols) to(r, 0) = row[0];
        }
        return to;
    };
    for (Grid<double>& plane : part.planes) plane = widened(plane);
    if (!part.mask.empty()) part.mask = widened(part.mask);
    part.rows = window.rows;
    part.cols = window.cols;
    return part;
}

}  // namespace relief::codec
