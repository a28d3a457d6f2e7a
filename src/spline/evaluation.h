#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "relief/core/result.h"
#include "relief/spline/jet.h"

/// What evaluation of all surfaces shares. Private to the module.
namespace relief::spline {

/// A coordinate moved into [0, last], as cell and place in it; NaN counts as 0.
template <class T>
struct Place {
    Place(double x, std::int64_t last) {
        const double inside = x > 0 ? std::min(x, static_cast<double>(last)) : 0;
        cell = static_cast<std::int64_t>(inside);
        fraction = static_cast<T>(inside - static_cast<double>(cell));
    }
    std::int64_t cell;
    T fraction;
};

/// Whether `out` has room for some derivatives at points of as many i as j.
template <class T>
Status check_spans(std::size_t i, std::size_t j, int derivatives, const JetSpans<T>& out) {
    if (derivatives < 0 || derivatives > 2)
        return Error{ErrorCode::InvalidArgument,
                     "derivatives must be 0, 1 or 2, not " + std::to_string(derivatives),
                     "evaluate"};
    const bool sizes =
        j == i && out.value.size() == i &&
        (derivatives < 1 || (out.di.size() == i && out.dj.size() == i)) &&
        (derivatives < 2 || (out.dii.size() == i && out.dij.size() == i && out.djj.size() == i));
    if (sizes) return {};
    return Error{ErrorCode::InvalidArgument,
                 "all spans must have the size of the points, " + std::to_string(i), "evaluate"};
}

}  // namespace relief::spline
