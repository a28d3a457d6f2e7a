#include "relief/core/banded.h"

#include <algorithm>
#include <cmath>

namespace relief {

BandedCholesky::BandedCholesky(std::size_t size, std::size_t half_width)
    : size_(size), width_(half_width), rows_(size * (half_width + 1), 0.0) {}

void BandedCholesky::add(std::size_t i, std::size_t j, double value) {
    at(std::max(i, j), std::min(i, j)) += value;
}

bool BandedCholesky::factor() {
    for (std::size_t i = 0; i < size_; ++i) {
        for (std::size_t j = first(i); j <= i; ++j) {
            double sum = at(i, j);
            for (std::size_t k = std::max(first(i), first(j)); k < j; ++k)
                sum -= at(i, k) * at(j, k);
            if (j < i)
                at(i, j) = sum / at(j, j);
            else if (sum > 0)
                at(i, i) = std::sqrt(sum);
            else
                return false;
        }
    }
    return true;
}

}  // namespace relief
