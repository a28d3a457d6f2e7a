#pragma once

#include <cstring>

#include "relief/multires/cubic.h"

/// What the tests of scheme `cubic` share.
namespace relief::multires::cubic {

inline SchemeSpec spec_of(int levels = -1, bool exact = false) {
    return {.id = SchemeId::Cubic, .levels = levels, .exact = exact};
}

template <class T>
Pyramid<T> analysed(const Grid<T>& finest, const SchemeSpec& spec) {
    auto pyramid = Pyramid<T>::allocate(*layout(spec, finest.rows(), finest.cols(), 1));
    analyse<T>(finest.view(), 0, pyramid);
    return pyramid;
}

/// A pyramid of one component whose bands are all zero.
template <class T>
Pyramid<T> empty_pyramid(const SchemeSpec& spec, std::int64_t rows, std::int64_t cols) {
    auto pyramid = Pyramid<T>::allocate(*layout(spec, rows, cols, 1));
    for (std::size_t k = 0; k < pyramid.bands.size(); ++k) {
        const LatticeBox& box = pyramid.layout.bands[k].box;
        pyramid.bands[k][0] = Grid<T>(box.rows, box.cols, T(0));
    }
    return pyramid;
}

template <class T>
bool same_bytes(const Grid<T>& a, const Grid<T>& b) {
    if (a.rows() != b.rows() || a.cols() != b.cols()) return false;
    for (std::int64_t r = 0; r < a.rows(); ++r)
        if (a.cols() > 0 && std::memcmp(a.row(r), b.row(r), std::size_t(a.cols()) * sizeof(T)) != 0)
            return false;
    return true;
}

template <class T>
bool same_bytes(const Pyramid<T>& a, const Pyramid<T>& b) {
    for (std::size_t k = 0; k < a.bands.size(); ++k)
        if (!same_bytes(a.bands[k][0], b.bands[k][0])) return false;
    return a.bands.size() == b.bands.size();
}

}  // namespace relief::multires::cubic
