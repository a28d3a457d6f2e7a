#pragma once

#include <cstdint>

/// Copies of rows into or past the caches. Private to the module.
namespace relief::multires {

/// Whether a row that is written will be wanted soon, or would only push others out of the cache.
enum class Traffic { Cached, Streamed };

/// Planes of some megabytes leave the cache before anyone comes back to them.
template <class T>
constexpr Traffic streamed_if_large(std::int64_t elements) {
    constexpr std::int64_t large = std::int64_t{4} << 20;
    return elements * std::int64_t(sizeof(T)) >= large ? Traffic::Streamed : Traffic::Cached;
}

/// Streamed rows must be followed by finish_streaming() in the same thread before others read them.
template <class T>
void copy_row(const T* row, std::int64_t n, T* out, Traffic traffic);
void finish_streaming();

}  // namespace relief::multires
