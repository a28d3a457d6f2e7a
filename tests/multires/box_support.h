#pragma once

#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "relief/multires/box.h"

/// What the tests of scheme `box` share.
namespace relief::multires::box {

using Rows = std::vector<std::vector<double>>;

inline nlohmann::json golden() {
    std::ifstream file(std::string(RELIEF_TEST_DATA) + "/box.json");
    return nlohmann::json::parse(file);
}

template <class T = double>
Grid<T> grid_of(const Rows& rows) {
    Grid<T> grid(std::int64_t(rows.size()), std::int64_t(rows[0].size()));
    for (std::size_t i = 0; i < rows.size(); ++i)
        for (std::size_t j = 0; j < rows[i].size(); ++j)
            grid(std::int64_t(i), std::int64_t(j)) = T(rows[i][j]);
    return grid;
}

template <class T, class Value>
Grid<T> grid_from(std::int64_t rows, std::int64_t cols, Value value) {
    Grid<T> grid(rows, cols);
    for (std::int64_t i = 0; i < rows; ++i)
        for (std::int64_t j = 0; j < cols; ++j) grid(i, j) = T(value(i, j));
    return grid;
}

/// Uniform in [-1, 1].
template <class T>
Grid<T> noise(std::int64_t rows, std::int64_t cols, unsigned seed) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> draw(-1, 1);
    return grid_from<T>(rows, cols, [&](auto, auto) { return draw(engine); });
}

/// A pyramid of one component whose bands are all zero.
template <class T>
Pyramid<T> empty_pyramid(int order, std::int64_t rows, std::int64_t cols, int levels = -1) {
    auto pyramid =
        Pyramid<T>::allocate(layout({.order = order, .levels = levels}, rows, cols, 1).value());
    for (Planes<T>& band : pyramid.bands)
        for (std::int64_t i = 0; i < band[0].rows(); ++i)
            std::fill_n(band[0].row(i), band[0].cols(), T(0));
    return pyramid;
}

template <class T>
Pyramid<T> analysed(int order, const Grid<T>& finest, int levels = -1) {
    auto pyramid = empty_pyramid<T>(order, finest.rows(), finest.cols(), levels);
    analyse<T>(finest.view(), 0, pyramid);
    return pyramid;
}

/// Band of edge kind 1 .. 3 of a level.
template <class T>
Grid<T>& edge_band(Pyramid<T>& pyramid, int level, int channel) {
    for (std::size_t k = 0; k < pyramid.bands.size(); ++k) {
        const BandLayout& band = pyramid.layout.bands[k];
        if (band.level == level && band.channel == channel) return pyramid.bands[k][0];
    }
    throw std::out_of_range("no such band");
}

template <class T, class U>
double largest_difference(const Grid<T>& a, const Grid<U>& b) {
    if (a.rows() != b.rows() || a.cols() != b.cols()) return HUGE_VAL;
    double most = 0;
    for (std::int64_t i = 0; i < a.rows(); ++i)
        for (std::int64_t j = 0; j < a.cols(); ++j)
            most = std::max(most, std::abs(double(a(i, j)) - double(b(i, j))));
    return most;
}

template <class T>
double largest(const Grid<T>& a) {
    double most = 0;
    for (std::int64_t i = 0; i < a.rows(); ++i)
        for (std::int64_t j = 0; j < a.cols(); ++j)
            most = std::max(most, std::abs(double(a(i, j))));
    return most;
}

template <class T>
bool same_bytes(const Grid<T>& a, const Grid<T>& b) {
    if (a.rows() != b.rows() || a.cols() != b.cols()) return false;
    for (std::int64_t i = 0; i < a.rows(); ++i)
        if (std::memcmp(a.row(i), b.row(i), std::size_t(a.cols()) * sizeof(T)) != 0) return false;
    return true;
}

template <class T>
bool same_bytes(const Pyramid<T>& a, const Pyramid<T>& b) {
    for (std::size_t k = 0; k < a.bands.size(); ++k)
        if (!same_bytes(a.bands[k][0], b.bands[k][0])) return false;
    return a.bands.size() == b.bands.size();
}

}  // namespace relief::multires::box
