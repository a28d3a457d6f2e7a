#include "io/weld.h"

#include <algorithm>
#include <numeric>

namespace relief::io::detail {

Welded weld(std::span<const double> rows, std::size_t width) {
    const std::size_t count = rows.size() / width;
    const auto row = [&](std::int32_t k) {
        return rows.subspan(static_cast<std::size_t>(k) * width, width);
    };
    std::vector<std::int32_t> order(count);
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
        const auto left = row(a);
        const auto right = row(b);
        const auto [l, r] = std::mismatch(left.begin(), left.end(), right.begin());
        return l == left.end() ? a < b : *l < *r;
    });
    // The first row of each run of equal ones, then their numbers in order of appearance.
    Welded welded;
    welded.numbers.resize(count);
    std::int32_t first = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const auto current = row(order[k]);
        if (k == 0 || !std::equal(current.begin(), current.end(), row(first).begin()))
            first = order[k];
        welded.numbers[static_cast<std::size_t>(order[k])] = first;
    }
    for (std::size_t k = 0; k < count; ++k) {
        const auto leader = static_cast<std::size_t>(welded.numbers[k]);
        if (leader == k) {
            welded.numbers[k] = static_cast<std::int32_t>(welded.firsts.size());
            welded.firsts.push_back(static_cast<std::int32_t>(k));
        } else {
            welded.numbers[k] = welded.numbers[leader];
        }
    }
    return welded;
}

}  // namespace relief::io::detail
