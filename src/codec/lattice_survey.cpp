#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <iterator>
#include <map>
#include <string>

#include "codec/lattice_encode.h"
#include "relief/core/parallel.h"

namespace relief::codec {

namespace {

constexpr std::int64_t kStrip = TileTree::kTile;
constexpr std::int64_t kCoarse = std::int64_t{1} << TileTree::kTierLevels;

LatticeBox strip_box(const Raster& about, std::int64_t row) {
    return {row, 0, std::min(kStrip, about.rows - row), about.cols};
}

bool is_valid(const Raster& strip, std::int64_t r, std::int64_t c) {
    return strip.mask.empty() || strip.mask(r, c) != 0;
}

/// Statistics of the rows of a strip, and the first sample that is not a finite number.
struct RowSurvey {
    std::vector<SampleStatistics> components;
    std::int64_t bad_column = -1;
};

RowSurvey survey_row(const Raster& strip, std::int64_t r) {
    RowSurvey row;
    for (const Grid<double>& plane : strip.planes) {
        SampleStatistics& statistics = row.components.emplace_back();
        for (std::int64_t c = 0; c < strip.cols; ++c) {
            if (!is_valid(strip, r, c)) continue;
            if (!std::isfinite(plane(r, c))) row.bad_column = c;
            statistics.add(plane(r, c));
        }
    }
    return row;
}

void keep_coarse(const Raster& strip, std::int64_t row0, Raster& coarse) {
    for (std::int64_t r = 0; r < strip.rows; r += kCoarse) {
        const std::int64_t to = (row0 + r) / kCoarse;
        for (std::size_t p = 0; p < strip.planes.size(); ++p)
            for (std::int64_t c = 0; c < coarse.cols; ++c)
                coarse.planes[p](to, c) = strip.planes[p](r, c * kCoarse);
        for (std::int64_t c = 0; c < coarse.cols; ++c)
            coarse.mask(to, c) = is_valid(strip, r, c * kCoarse);
    }
}

Status cancelled() {
    return Error{ErrorCode::Cancelled, "encoding was cancelled", ""};
}

/// How many valid samples are off the lattice, of how many, one component.
struct Misfits {
    std::int64_t off = 0;
    std::int64_t all = 0;
    [[nodiscard]] bool accepted() const {
        return static_cast<double>(off) <= kLatticeMisfits * static_cast<double>(all);
    }
};

Misfits misfits(const Raster& strip, std::size_t component, double unit, const Raster& about,
                double bound) {
    std::atomic<std::int64_t> off = 0;
    std::atomic<std::int64_t> all = 0;
    parallel_for(0, strip.rows, 16, [&](std::int64_t first, std::int64_t last) {
        Misfits some;
        for (std::int64_t r = first; r < last; ++r)
            for (std::int64_t c = 0; c < strip.cols; ++c) {
                if (!is_valid(strip, r, c)) continue;
                ++some.all;
                some.off += off_lattice(strip.planes[component](r, c), unit, about.type,
                                        about.nodata, bound);
            }
        off += some.off;
        all += some.all;
    });
    return {off, all};
}

/// The lattice unit of a component with these statistics; 0: none.
Result<double> find_unit(const RasterSource& source, const Raster& coarse, std::size_t component,
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
    for (int k = 0; const auto unit = lattice_candidate(k); ++k) {
        if (!(*unit > 4.8e-7 * largest)) continue;
        if (!misfits(coarse, component, *unit, about, bound).accepted()) continue;
        Misfits all;
        for (std::int64_t row = 0; row < about.rows; row += kStrip) {
            RELIEF_TRY(const Raster strip, source.read(strip_box(about, row)));
            const Misfits some = misfits(strip, component, *unit, about, bound);
            all.off += some.off;
            all.all += some.all;
        }
        if (all.accepted()) return *unit;
    }
    return 0.0;
}

/// Statistics of the samples of a component by their binary order of magnitude.
using Magnitudes = std::map<int, SampleStatistics>;

Result<Magnitudes> magnitudes(const RasterSource& source, std::size_t component) {
    const Raster& about = source.description();
    Magnitudes all;
    for (std::int64_t row = 0; row < about.rows; row += kStrip) {
        RELIEF_TRY(const Raster strip, source.read(strip_box(about, row)));
        for (std::int64_t r = 0; r < strip.rows; ++r)
            for (std::int64_t c = 0; c < strip.cols; ++c) {
                if (!is_valid(strip, r, c)) continue;
                const double sample = strip.planes[component](r, c);
                all[std::ilogb(sample)].add(sample);
            }
    }
    return all;
}

/// The domain of a component whose samples have these statistics; none: they do not fit.
Result<std::optional<IntegerDomain>> fitting_domain(const RasterSource& source,
                                                    const Raster& coarse, std::size_t component,
                                                    const SampleStatistics& statistics,
                                                    double bound) {
    RELIEF_TRY(const double unit, find_unit(source, coarse, component, statistics, bound));
    return make_domain(statistics, source.description().type, unit, bound);
}

/// The domain of a component. Where not all samples fit, those of the largest orders of magnitude
/// are left out, as few as it takes and no more than may be repaired.
Result<std::optional<IntegerDomain>> find_domain(const RasterSource& source, const Survey& seen,
                                                 std::size_t component, double bound) {
    const SampleStatistics& all = seen.components[component];
    RELIEF_TRY(auto domain, fitting_domain(source, seen.coarse, component, all, bound));
    if (domain) return domain;
    RELIEF_TRY(Magnitudes rest, magnitudes(source, component));
    const auto fewest =
        static_cast<std::int64_t>((1 - kMostOutliers) * static_cast<double>(all.count));
    for (;;) {
        rest.erase(std::prev(rest.end()));
        SampleStatistics inner;
        for (const auto& [order, statistics] : rest) inner.add(statistics);
        if (inner.count == 0 || inner.count < fewest) return domain;
        RELIEF_TRY(domain, fitting_domain(source, seen.coarse, component, inner, bound));
        if (!domain) continue;
        domain->outliers = true;
        return domain;
    }
}

/// The bilinear surface through the coarsest lattice.
class CoarsestSurface {
  public:
    CoarsestSurface(const Raster& strip, const Survey& seen, const Raster& about)
        : strip_(strip),
          survey_(seen),
          about_(about),
          levels_(TileTree(about.rows, about.cols).levels()) {}

    /// Squared distance of row `row` of the raster, which is row r of the strip.
    [[nodiscard]] double energy(std::int64_t r, std::int64_t row) const {
        double sum = 0;
        const Between down = between(row, about_.rows);
        for (std::size_t p = 0; p < strip_.planes.size(); ++p) {
            const auto line = [&](std::int64_t col) {
                const double a = sample(p, down.first, col);
                return a + down.part * (sample(p, down.second, col) - a);
            };
            std::int64_t cell = -1;
            double left = 0;
            double right = 0;
            for (std::int64_t c = 0; c < strip_.cols; ++c) {
                if (!strip_.valid(r, c)) continue;
                const Between across = between(c, about_.cols);
                if (across.first != cell) {
                    left = line(across.first);
                    right = line(across.second);
                    cell = across.first;
                }
                const double difference =
                    strip_.planes[p](r, c) - (left + across.part * (right - left));
                sum += difference * difference;
            }
        }
        return sum;
    }

  private:
    /// A place between samples of the lattice, along one axis.
    struct Between {
        std::int64_t first, second;  ///< samples of the raster
        double part;
    };
    [[nodiscard]] Between between(std::int64_t x, std::int64_t n) const {
        const std::int64_t step = std::int64_t{1} << levels_;
        const std::int64_t first = x / step * step;
        const std::int64_t second = first + step < n ? first + step : first;
        return {first, second, static_cast<double>(x - first) / static_cast<double>(step)};
    }

    /// Holes have the middle value. A raster whose coarsest lattice is finer than the survey's is
    /// one strip.
    [[nodiscard]] double sample(std::size_t p, std::int64_t row, std::int64_t col) const {
        const bool surveyed = levels_ >= TileTree::kTierLevels;
        const Raster& from = surveyed ? survey_.coarse : strip_;
        const int shift = surveyed ? TileTree::kTierLevels : 0;
        if (from.valid(row >> shift, col >> shift))
            return from.planes[p](row >> shift, col >> shift);
        return (survey_.components[p].lowest + survey_.components[p].highest) / 2;
    }

    const Raster& strip_;
    const Survey& survey_;
    const Raster& about_;
    int levels_;
};

/// How many low bits of quotients are noise: they grow with the octaves of what a sample is off
/// the mean of its neighbours to the west and east, in steps, in the mean. Below 4 steps or so all
/// bits are worth modelling.
Result<int> raw_bits_of(const RasterSource& source, std::size_t component,
                        const IntegerDomain& domain) {
    std::int64_t octaves = 0;
    std::int64_t count = 0;
    for (const LatticeBox& box : sample_strips(source.description())) {
        RELIEF_TRY(const Raster strip, source.read(box));
        std::vector<std::int32_t> v(static_cast<std::size_t>(box.cols));
        for (std::int64_t r = 0; r < box.rows; ++r) {
            domain.integers(strip.planes[component].row(r), box.cols, v.data());
            for (std::size_t c = 1; c + 1 < v.size(); ++c) {
                const auto at = static_cast<std::int64_t>(c);
                if (!is_valid(strip, r, at - 1) || !is_valid(strip, r, at) ||
                    !is_valid(strip, r, at + 1))
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
    constexpr std::int64_t most = 8;
    constexpr std::int64_t rows = 64;
    const std::int64_t strips = std::min(most, (about.rows + rows - 1) / rows);
    std::vector<LatticeBox> boxes;
    for (std::int64_t k = 0; k < strips; ++k) {
        const std::int64_t row0 = k * about.rows / strips / 2 * 2;
        boxes.push_back({row0, 0, std::min(rows, about.rows - row0), about.cols});
    }
    return boxes;
}

double coarse_energy(const Raster& strip, std::int64_t row0, const Survey& seen,
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
        RELIEF_TRY(const Raster strip, source.read(strip_box(about, row)));
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
        RELIEF_TRY(const auto domain, find_domain(source, seen, p, bound));
        if (!domain) return false;
        coding.domains.push_back(*domain);
        if (coding.profile == Profile::Dense) {
            RELIEF_TRY(coding.domains.back().raw_bits, raw_bits_of(source, p, *domain));
        }
    }
    return true;
}

}  // namespace relief::codec
