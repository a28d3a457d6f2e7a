#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "relief/core/grid.h"

namespace relief::spline {

inline nlohmann::json golden() {
    std::ifstream file(RELIEF_TEST_DATA "/box_spline.json");
    return nlohmann::json::parse(file);
}

template <class T>
Grid<T> noise(std::int64_t rows, std::int64_t cols, unsigned seed) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<T> draw(-1, 1);
    Grid<T> grid(rows, cols);
    for (std::int64_t r = 0; r < rows; ++r)
        for (std::int64_t c = 0; c < cols; ++c) grid(r, c) = draw(engine);
    return grid;
}

/// grid(r, c) = f(r, c).
template <class T, class Function>
Grid<T> sampled(std::int64_t rows, std::int64_t cols, Function f) {
    Grid<T> grid(rows, cols);
    for (std::int64_t r = 0; r < rows; ++r)
        for (std::int64_t c = 0; c < cols; ++c)
            grid(r, c) = static_cast<T>(f(static_cast<double>(r), static_cast<double>(c)));
    return grid;
}

/// A periodic array repeated `copies` times along both axes.
inline Grid<double> tiled(const nlohmann::json& array, std::int64_t copies) {
    const auto values = array.get<std::vector<std::vector<double>>>();
    const auto rows = static_cast<std::int64_t>(values.size());
    const auto cols = static_cast<std::int64_t>(values[0].size());
    Grid<double> grid(rows * copies, cols * copies);
    for (std::int64_t r = 0; r < grid.rows(); ++r)
        for (std::int64_t c = 0; c < grid.cols(); ++c) grid(r, c) = values[r % rows][c % cols];
    return grid;
}

template <class T>
double largest_difference(const Grid<T>& a, const Grid<T>& b) {
    double largest = 0;
    for (std::int64_t r = 0; r < a.rows(); ++r)
        for (std::int64_t c = 0; c < a.cols(); ++c)
            largest = std::max(
                largest, std::abs(static_cast<double>(a(r, c)) - static_cast<double>(b(r, c))));
    return largest;
}

template <class T>
double largest(const Grid<T>& a) {
    return largest_difference(a, Grid<T>(a.rows(), a.cols(), T(0)));
}

template <class T>
bool same_bytes(const Grid<T>& a, const Grid<T>& b) {
    for (std::int64_t r = 0; r < a.rows(); ++r)
        if (std::memcmp(a.row(r), b.row(r), static_cast<std::size_t>(a.cols()) * sizeof(T)) != 0)
            return false;
    return true;
}

}  // namespace relief::spline
