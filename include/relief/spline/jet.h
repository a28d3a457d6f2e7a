#pragma once

#include <span>

/// What evaluation of any surface gives.
namespace relief::spline {

/// A value with its first and second derivatives along i (rows) and j (columns), in lattice units.
template <class T>
struct SurfaceJet {
    T value{};
    T di{};
    T dj{};
    T dii{};
    T dij{};
    T djj{};
};

/// Where evaluation at many points writes: one element a point. Derivatives that were not asked for
/// may stay empty.
template <class T>
struct JetSpans {
    std::span<T> value;
    std::span<T> di{};
    std::span<T> dj{};
    std::span<T> dii{};
    std::span<T> dij{};
    std::span<T> djj{};
};

}  // namespace relief::spline
