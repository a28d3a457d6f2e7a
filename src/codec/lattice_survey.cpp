#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <string>

#include "codec/lattice_encode.h"
#include "codec/sample_rows.h"
#include "relief/core/parallel.h"

namespace relief::codec {

namespace {

constexpr std::int64_t kStrip = TileTree::kTile;
constexpr std::int64_t kCoarse = std::int64_t{1} << TileTree::kTierLevels;

LatticeBox strip_box(const Raster& about, std::int64_t row) {
    return {row, 0, std::min(kStrip, about.rows - row), about.cols};
}

/// Statistics of the rows of a strip, and the first sample that is not a finite number.
struct RowSurvey {
    std::vector<SampleStatistics> components;
    std::int64_t bad_column = -1;
};

/// The first valid sample that equals `value`, which is one of them: zeros differ in their sign.
double first_equal(const double* samples, const std::uint8_t* valid, double value) {
    if (value != 0) return value;
    std::int64_t c = 0;
    while (samples[c] != 0 || (valid && !valid[c])) ++c;
    return samples[c];
}

/// As if the samples were added one by one.
SampleStatistics statistics_of(const double* samples, const std::uint8_t* valid, std::int64_t n,
                               const RowRange& range) {
    SampleStatistics statistics;
    for (std::int64_t c = 0; c < n && statistics.step != 1; ++c)
        if (!valid || valid[c]) statistics.add(samples[c]);
    statistics.count = valid ? n - std::count(valid, valid + n, std::uint8_t{0}) : n;
    if (statistics.count == 0) return statistics;
    statistics.lowest = first_equal(samples, valid, range.lowest);
    statistics.highest = first_equal(samples, valid, range.highest);
    return statistics;
}

RowSurvey survey_row(const RasterView& strip, std::int64_t r) {
    RowSurvey row;
    const std::uint8_t* valid = strip.valid_row(r);
    for (const GridView<const double>& plane : strip.planes) {
        const RowRange range = range_of_row(plane.row(r), valid, strip.cols);
        if (range.finite) {
            row.components.push_back(statistics_of(plane.row(r), valid, strip.cols, range));
            continue;
        }
        row.components.emplace_back();
        for (std::int64_t c = 0; c < strip.cols; ++c)
            if (strip.valid(r, c) && !std::isfinite(plane(r, c))) row.bad_column = c;
    }
    return row;
}

void keep_coarse(const RasterView& strip, std::int64_t row0, Raster& coarse) {
    for (std::int64_t r = 0; r < strip.rows; r += kCoarse) {
        const std::int64_t to = (row0 + r) / kCoarse;
        for (std::size_t p = 0; p < strip.planes.size(); ++p)
            for (std::int64_t c = 0; c < coarse.cols; ++c)
                coarse.planes[p](to, c) = strip.planes[p](r, c * kCoarse);
        for (std::int64_t c = 0; c < coarse.cols; ++c)
            coarse.mask(to, c) = strip.valid(r, c * kCoarse);
    }
}

Status cancelled() {
    return Error{ErrorCode::Cancelled, "encoding was cancelled", ""};
}

/// So many of the valid samples may be off a lattice.
double most_misfits(std::int64_t valid) {
    return kLatticeMisfits * static_cast<double>(valid);
}

/// How many valid samples of a component are off the lattice of `unit`: each would need a repair.
/// Where they are more than `most`, perhaps some only.
std::int64_t misfits(const RasterView& strip, std::size_t component, double unit,
                     const Raster& about, double bound, double most) {
    std::atomic<std::int64_t> off = 0;
    parallel_for(0, strip.rows, 16, [&](std::int64_t first, std::int64_t last) {
        std::vector<double> on(static_cast<std::size_t>(strip.cols));
        for (std::int64_t r = first; r < last && static_cast<double>(off) <= most; ++r) {
            const double* samples = strip.planes[component].row(r);
            lattice_row(samples, strip.cols, unit, on.data());
            stored_row(on.data(), strip.cols, about.type, about.nodata, on.data());
            off += count_off(on.data(), samples, strip.valid_row(r), strip.cols, bound);
        }
    });
    return off;
}

/// The lattice unit of a component with these statistics; 0: none.
Result<double> find_unit(const RasterSource& source, const Survey& seen, std::size_t component,
                         const SampleStatistics& statistics, double bound) {
    const Raster& about = source.description();
    const double largest = std::max(std::abs(statistics.lowest), std::abs(statistics.highest));
    if (is_integer(about.type)) {
        const double unit = std::max(statistics.step, 1.0);
        const bool useful = std::fmod(statistics.lowest, unit) == 0;
        // A coarse unit that does not divide the step would shorten it.
        const double step = 2 * std::floor(bound / unit) + 1;
        return useful && step * unit >= 2 * std::floor(bound) + 1 ? unit : 1.0;
    }
    const double most_coarse = most_misfits(seen.coarse.valid_count());
    const double most = most_misfits(seen.valid);
    const auto off = [&](const RasterView& strip, double unit, double enough) {
        return static_cast<double>(misfits(strip, component, unit, about, bound, enough));
    };
    for (int k = 0; const auto unit = lattice_candidate(k); ++k) {
        if (!(*unit > 4.8e-7 * largest)) continue;
        if (off(view_of(seen.coarse), *unit, most_coarse) > most_coarse) continue;
        double all = 0;
        for (std::int64_t row = 0; row < about.rows && all <= most; row += kStrip) {
            Raster room;
            RELIEF_TRY(const RasterView strip, source.view(strip_box(about, row), room));
            all += off(strip, *unit, most - all);
        }
        if (all <= most) return *unit;
    }
    return 0.0;
}

/// Statistics of the samples of a component by their binary order of magnitude.
using Magnitudes = std::map<int, SampleStatistics>;

Result<Magnitudes> magnitudes(const RasterSource& source, std::size_t component) {
    const Raster& about = source.description();
    Magnitudes all;
    for (std::int64_t row = 0; row < about.rows; row += kStrip) {
        Raster room;
        RELIEF_TRY(const RasterView strip, source.view(strip_box(about, row), room));
        for (std::int64_t r = 0; r < strip.rows; ++r)
            for (std::int64_t c = 0; c < strip.cols; ++c) {
                if (!strip.valid(r, c)) continue;
                const double sample = strip.planes[component](r, c);
                all[std::ilogb(sample)].add(sample);
            }
    }
    return all;
}

/// The domain of a component whose samples have these statistics; none: they do not fit.
Result<std::optional<IntegerDomain>> fitting_domain(const RasterSource& source, const Survey& seen,
                                                    std::size_t component,
                                                    const SampleStatistics& statistics,
                                                    double bound) {
    RELIEF_TRY(const double unit, find_unit(source, seen, component, statistics, bound));
    return make_domain(statistics, source.description().type, unit, bound);
}

/// The domain of a component. Where not all samples fit, those of the largest orders of magnitude
/// are left out, as few as it takes and no more than may be repaired.
Result<std::optional<IntegerDomain>> find_domain(const RasterSource& source, const Survey& seen,
                                                 std::size_t component, double bound) {
    const SampleStatistics& all = seen.components[component];
    RELIEF_TRY(auto domain, fitting_domain(source, seen, component, all, bound));
    if (domain) return domain;
    RELIEF_TRY(Magnitudes rest, magnitudes(source, component));
    const auto fewest =
        static_cast<std::int64_t>((1 - kMostOutliers) * static_cast<double>(all.count));
    for (;;) {
        rest.erase(std::prev(rest.end()));
        SampleStatistics inner;
        for (const auto& [order, statistics] : rest) inner.add(statistics);
        if (inner.count == 0 || inner.count < fewest) return domain;
        RELIEF_TRY(domain, fitting_domain(source, seen, component, inner, bound));
        if (!domain) continue;
        domain->outliers = true;
        return domain;
    }
}

/// The bilinear surface through the coarsest lattice.
class CoarsestSurface {
  public:
    CoarsestSurface(const RasterView& strip, const Survey& seen, const Raster& about)
        : strip_(strip),
          survey_(seen),
          coarse_(view_of(seen.coarse)),
          about_(about),
          levels_(TileTree(about.rows, about.cols).levels()),
          step_(std::int64_t{1} << levels_),
          per_cell_(1 / static_cast<double>(step_)) {}

    /// Squared distance of row `row` of the raster, which is row r of the strip.
    [[nodiscard]] double energy(std::int64_t r, std::int64_t row) const {
        PartialSums sums{};
        const std::uint8_t* valid = strip_.valid_row(r);
        const std::int64_t north = row >> levels_ << levels_;
        const std::int64_t south = next(north, about_.rows);
        const double down = per_cell_ * static_cast<double>(row - north);
        for (std::size_t p = 0; p < strip_.planes.size(); ++p) {
            const auto line = [&](std::int64_t col) {
                const double a = sample(p, north, col);
                return a + down * (sample(p, south, col) - a);
            };
            for (std::int64_t west = 0; west < strip_.cols; west += step_) {
                const double left = line(west);
                const double right = line(next(west, about_.cols));
                add_squares(strip_.planes[p].row(r) + west, valid ? valid + west : nullptr,
                            std::min(step_, strip_.cols - west), left, per_cell_ * (right - left),
                            sums);
            }
        }
        return std::accumulate(sums.begin(), sums.end(), 0.0);
    }

  private:
    /// The sample of the lattice after one at x, of n along an axis; the last one after itself.
    [[nodiscard]] std::int64_t next(std::int64_t x, std::int64_t n) const {
        return x + step_ < n ? x + step_ : x;
    }

    /// Holes have the middle value. A raster whose coarsest lattice is finer than the survey's is
    /// one strip.
    [[nodiscard]] double sample(std::size_t p, std::int64_t row, std::int64_t col) const {
        const bool surveyed = levels_ >= TileTree::kTierLevels;
        const RasterView& from = surveyed ? coarse_ : strip_;
        const int shift = surveyed ? TileTree::kTierLevels : 0;
        if (from.valid(row >> shift, col >> shift))
            return from.planes[p](row >> shift, col >> shift);
        return (survey_.components[p].lowest + survey_.components[p].highest) / 2;
    }

    const RasterView& strip_;
    const Survey& survey_;
    RasterView coarse_;
    const Raster& about_;
    int levels_;
    std::int64_t step_;
    double per_cell_;
};

/// How many low bits of quotients are noise: they grow with the octaves of what a sample is off
/// the mean of its neighbours to the west and east, in steps, in the mean. Below 4 steps or so all
/// bits are worth modelling.
Result<int> raw_bits_of(const RasterSource& source, std::size_t component,
                        const IntegerDomain& domain) {
    std::int64_t octaves = 0;
    std::int64_t count = 0;
    for (const LatticeBox& box : sample_strips(source.description())) {
        Raster room;
        RELIEF_TRY(const RasterView strip, source.view(box, room));
        std::vector<std::int32_t> v(static_cast<std::size_t>(box.cols));
        for (std::int64_t r = 0; r < box.rows; ++r) {
            integer_row(strip.planes[component].row(r), box.cols, domain, v.data());
            for (std::size_t c = 1; c + 1 < v.size(); ++c) {
                const auto at = static_cast<std::int64_t>(c);
                if (!strip.valid(r, at - 1) || !strip.valid(r, at) || !strip.valid(r, at + 1))
                    continue;
                const std::int64_t twice =
                    std::abs(2 * std::int64_t{v[c]} - v[c - 1] - v[c + 1]) / domain.step;
                octaves += std::bit_width(static_cast<std::uint64_t>(twice + 2)) - 2;
                ++count;
            }
        }
    }
    if (count == 0) return 0;
    const auto mean = static_cast<double>(octaves) / static_cast<double>(count);
    return std::clamp(static_cast<int>(std::floor(mean)) - 2, 0, kMostRawBits);
}

}  // namespace

std::vector<LatticeBox> sample_strips(const Raster& about) {
    constexpr std::int64_t most = 16;
    constexpr std::int64_t rows = 8;
    const std::int64_t strips = std::min(most, (about.rows + rows - 1) / rows);
    std::vector<LatticeBox> boxes;
    for (std::int64_t k = 0; k < strips; ++k) {
        const std::int64_t row0 = k * about.rows / strips / 2 * 2;
        boxes.push_back({row0, 0, std::min(rows, about.rows - row0), about.cols});
    }
    return boxes;
}

double coarse_energy(const RasterView& strip, std::int64_t row0, const Survey& seen,
                     const Raster& about) {
    const CoarsestSurface surface(strip, seen, about);
    std::vector<double> rows(static_cast<std::size_t>(strip.rows), 0.0);
    parallel_for(0, strip.rows, 16, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t r = first; r < last; ++r)
            rows[static_cast<std::size_t>(r)] = surface.energy(r, row0 + r);
    });
    double sum = 0;
    for (const double row : rows) sum += row;
    return sum;
}

Result<Survey> survey(const RasterSource& source, const Progress& progress) {
    const Raster& about = source.description();
    Survey seen;
    seen.components.resize(static_cast<std::size_t>(source.components()));
    seen.coarse.rows = level_size(about.rows, TileTree::kTierLevels);
    seen.coarse.cols = level_size(about.cols, TileTree::kTierLevels);
    seen.coarse.mask = Grid<std::uint8_t>(seen.coarse.rows, seen.coarse.cols);
    for (int p = 0; p < source.components(); ++p)
        seen.coarse.planes.emplace_back(seen.coarse.rows, seen.coarse.cols);
    for (std::int64_t row = 0; row < about.rows; row += kStrip) {
        Raster room;
        RELIEF_TRY(const RasterView strip, source.view(strip_box(about, row), room));
        std::vector<RowSurvey> rows(static_cast<std::size_t>(strip.rows));
        parallel_for(0, strip.rows, 16, [&](std::int64_t first, std::int64_t last) {
            for (std::int64_t r = first; r < last; ++r)
                rows[static_cast<std::size_t>(r)] = survey_row(strip, r);
        });
        for (std::size_t r = 0; r < rows.size(); ++r) {
            if (rows[r].bad_column >= 0)
                return Error{ErrorCode::BadInput,
                             "a valid sample is not a finite number; mark it as NODATA",
                             "row " + std::to_string(row + static_cast<std::int64_t>(r)) +
                                 ", column " + std::to_string(rows[r].bad_column)};
            for (std::size_t p = 0; p < seen.components.size(); ++p)
                seen.components[p].add(rows[r].components[p]);
        }
        keep_coarse(strip, row, seen.coarse);
        if (progress && !progress(0.1 * static_cast<double>(row) / static_cast<double>(about.rows)))
            return cancelled().error();
    }
    seen.valid = seen.components[0].count;
    if (seen.valid == 0)
        return Error{ErrorCode::BadInput, "no sample is valid: every one is NODATA or not a number",
                     ""};
    return seen;
}

Result<bool> choose_domains(const RasterSource& source, const Survey& seen, double bound,
                            LatticeCoding& coding) {
    coding.type = source.description().type;
    coding.nodata = source.description().nodata;
    coding.domains.clear();
    for (std::size_t p = 0; p < seen.components.size(); ++p) {
        RELIEF_TRY(auto domain, find_domain(source, seen, p, bound));
        // Bounds below the type's own steps: exactness costs less.
        if (!domain) domain = make_domain(seen.components[p], coding.type, 0, 0);
        if (!domain) return false;
        coding.domains.push_back(*domain);
        if (coding.profile == Profile::Dense) {
            RELIEF_TRY(coding.domains.back().raw_bits, raw_bits_of(source, p, *domain));
        }
    }
    return true;
}

}  // namespace relief::codec
