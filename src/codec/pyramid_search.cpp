#include "codec/pyramid_search.h"

#include <string>

#include "codec/decimal.h"
#include "codec/quantised_refit.h"

namespace relief::codec {

namespace {

/// A coefficient is worth refitting when its weighted magnitude is at least this part of the step.
constexpr double kRefitThreshold = 0.55;
constexpr int kRefitIterations = 8;
/// Samples up to here leave room for what filters add.
constexpr double kLargestSample = 1e45;

}  // namespace

std::vector<double> means_of(const multires::Planes<double>& scaling) {
    std::vector<double> means;
    for (const Grid<double>& plane : scaling) {
        double sum = 0;
        for (std::int64_t r = 0; r < plane.rows(); ++r)
            for (std::int64_t c = 0; c < plane.cols(); ++c) sum += plane(r, c);
        means.push_back(rounded(sum / static_cast<double>(plane.count()), 5));
    }
    return means;
}

Status check_samples(const Raster& part, std::int64_t row0, std::int64_t col0) {
    for (const Grid<double>& plane : part.planes)
        for (std::int64_t r = 0; r < plane.rows(); ++r)
            for (std::int64_t c = 0; c < plane.cols(); ++c)
                if (part.valid(r, c) && !(std::abs(plane(r, c)) <= kLargestSample))
                    return Error{
                        ErrorCode::BadInput,
                        "a valid sample is not a number or beyond 1e45; mark it as NODATA",
                        "row " + std::to_string(row0 + r) + ", column " + std::to_string(col0 + c)};
    return {};
}

Pyramid<double> copy_of(const Pyramid<double>& pyramid) {
    Pyramid<double> copy;
    copy.layout = pyramid.layout;
    for (const multires::Planes<double>& band : pyramid.bands) {
        multires::Planes<double> planes;
        for (const Grid<double>& plane : band) planes.push_back(plane.clone());
        copy.bands.push_back(std::move(planes));
    }
    return copy;
}

Pyramid<double> improved(const Pyramid<double>& exact, const Target& target,
                         const PyramidCoding& coding, Effort effort, bool fixed_scaling) {
    Pyramid<double> chosen = copy_of(exact);
    if (effort == Effort::Select) return chosen;
    Selection selection = select_above(chosen, kRefitThreshold * coding.step);
    if (fixed_scaling) {
        Grid<std::uint8_t>& scaling = selection.masks[0];
        scaling = Grid<std::uint8_t>(scaling.rows(), scaling.cols(), 0);
    }
    if (effort == Effort::Reselect && !fixed_scaling) {
        choose(chosen, selection.kept, target, Effort::Reselect);
    } else {
        apply(selection, chosen);
        refit(chosen, selection, target, kRefitIterations);
    }
    refit_quantised(chosen, coding, target, fixed_scaling ? 1 : 0);
    return chosen;
}

}  // namespace relief::codec
