#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "relief/core/grid.h"

/// What the tests of all modules share: reference vectors, noise, comparisons.
namespace relief::test {

inline nlohmann::json reference(const std::string& name) {
    std::ifstream file(std::string(RELIEF_TEST_DATA) + "/" + name);
    return nlohmann::json::parse(file);
}

/// "3/8", "-2" or a number.
inline double rational(const nlohmann::json& value) {
    if (value.is_number()) return value.get<double>();
    const std::string text = value.get<std::string>();
    const std::size_t slash = text.find('/');
    return slash == std::string::npos
               ? std::stod(text)
               : std::stod(text.substr(0, slash)) / std::stod(text.substr(slash + 1));
}

template <class T = double>
Grid<T> grid_of(const nlohmann::json& rows) {
    Grid<T> grid(static_cast<std::int64_t>(rows.size()), static_cast<std::int64_t>(rows[0].size()));
    for (std::int64_t r = 0; r < grid.rows(); ++r)
        for (std::int64_t c = 0; c < grid.cols(); ++c)
            grid(r, c) = static_cast<T>(
                rational(rows[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)]));
    return grid;
}

/// Deterministic values in [-1, 1), the same on every machine.
class Noise {
  public:
    explicit Noise(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15ULL + 1) {}
    double operator()() {
        state_ ^= state_ << 13;
        state_ ^= state_ >> 7;
        state_ ^= state_ << 17;
        return static_cast<double>(state_ >> 11) * 0x1p-52 - 1;
    }

  private:
    std::uint64_t state_;
};

template <class T>
Grid<T> noise_grid(std::int64_t rows, std::int64_t cols, std::uint64_t seed) {
    Noise noise(seed);
    Grid<T> grid(rows, cols);
    for (std::int64_t r = 0; r < rows; ++r)
        for (std::int64_t c = 0; c < cols; ++c) grid(r, c) = static_cast<T>(noise());
    return grid;
}

template <class T>
double largest_difference(GridView<const T> a, GridView<const T> b) {
    if (a.rows != b.rows || a.cols != b.cols) return INFINITY;
    double largest = 0;
    for (std::int64_t r = 0; r < a.rows; ++r)
        for (std::int64_t c = 0; c < a.cols; ++c) {
            const double difference =
                std::abs(static_cast<double>(a(r, c)) - static_cast<double>(b(r, c)));
            if (!(difference <= largest)) largest = difference;
        }
    return largest;
}

template <class T>
double largest_difference(const Grid<T>& a, const Grid<T>& b) {
    return largest_difference<T>(a.view(), b.view());
}

template <class T>
double dot(GridView<const T> a, GridView<const T> b) {
    double sum = 0;
    for (std::int64_t r = 0; r < a.rows; ++r)
        for (std::int64_t c = 0; c < a.cols; ++c)
            sum += static_cast<double>(a(r, c)) * static_cast<double>(b(r, c));
    return sum;
}

}  // namespace relief::test
