#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "relief/core/parallel.h"
#include "relief/core/result.h"
#include "relief/mesh/index.h"

/// Errors and loops that the parts of the scheme share.
namespace relief::multires::ps {

inline constexpr std::int64_t kGrain = 1024;

/// "name: what to do" at an element.
[[nodiscard]] inline Error bad_input(std::string message, std::string where = "") {
    return {ErrorCode::BadInput, std::move(message), std::move(where)};
}

/// Calls fn(k) for k below count, from several threads.
template <class Fn>
void for_each_index(std::size_t count, Fn&& fn) {
    parallel_for(0, static_cast<std::int64_t>(count), kGrain,
                 [&](std::int64_t first, std::int64_t last) {
                     for (std::int64_t k = first; k < last; ++k) fn(static_cast<mesh::Index>(k));
                 });
}

/// Sets `least` to the number if that is smaller.
inline void lower(std::atomic<std::size_t>& least, std::size_t number) {
    std::size_t known = least;
    while (number < known && !least.compare_exchange_weak(known, number)) {
    }
}

/// Calls good(k) for k below count from several threads; the first k for which it is false, or
/// count.
template <class Fn>
[[nodiscard]] std::size_t first_failure(std::size_t count, Fn&& good) {
    std::atomic<std::size_t> first = count;
    for_each_index(count, [&](mesh::Index k) {
        if (!good(k)) lower(first, k);
    });
    return first;
}

}  // namespace relief::multires::ps
