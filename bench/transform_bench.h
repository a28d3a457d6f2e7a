#pragma once

#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <cstring>

#include "relief/core/grid.h"
#include "relief/core/parallel.h"

/// Shared by the transform benchmarks: the measure of all of them is a memcpy of the raster in the same run.
namespace relief::bench {

/// A smooth surface plus roughness: denormals and zeros would be unfair either way.
template <class T>
Grid<T> terrain(std::int64_t n) {
    Grid<T> grid(n, n);
    std::uint32_t state = 12345;
    for (std::int64_t r = 0; r < n; ++r)
        for (std::int64_t c = 0; c < n; ++c) {
            state = state * 1664525U + 1013904223U;
            grid(r, c) = static_cast<T>(0.01 * static_cast<double>(r + c) + 1e-8 * static_cast<double>(state));
        }
    return grid;
}

/// Median nanoseconds per sample of copying an n x n raster between warm buffers, measured once per type and size.
template <class T>
double memcpy_ns(std::int64_t n) {
    static thread_local double cached = 0;
    static thread_local std::int64_t cached_n = 0;
    if (cached_n == n) return cached;
    const Grid<T> from = terrain<T>(n);
    Grid<T> to(n, n, T(0));
    double times[9];
    const auto bytes = static_cast<std::size_t>(from.stride() * n) * sizeof(T);
    const int repeats = static_cast<int>(1 + (std::int64_t{1} << 24) / (n * n));
    for (double& time : times) {
        timespec begin{};
        timespec end{};
        clock_gettime(CLOCK_MONOTONIC, &begin);
        for (int k = 0; k < repeats; ++k) {
            std::memcpy(to.row(0), from.row(0), bytes);
            benchmark::ClobberMemory();
        }
        clock_gettime(CLOCK_MONOTONIC, &end);
        time = (static_cast<double>(end.tv_sec - begin.tv_sec) * 1e9 + static_cast<double>(end.tv_nsec - begin.tv_nsec)) /
               repeats;
    }
    std::sort(times, times + 9);
    cached_n = n;
    return cached = times[4] / static_cast<double>(n * n);
}

/// Adds ns/sample and the ratio to memcpy to a benchmark that ran once per iteration over n x n samples.
template <class T>
class PerSample {
  public:
    PerSample(benchmark::State& state, std::int64_t n) : state_(state), n_(n), copy_(memcpy_ns<T>(n)) {
        clock_gettime(CLOCK_MONOTONIC, &begin_);
    }
    ~PerSample() {
        timespec end{};
        clock_gettime(CLOCK_MONOTONIC, &end);
        const double ns = (static_cast<double>(end.tv_sec - begin_.tv_sec) * 1e9 +
                           static_cast<double>(end.tv_nsec - begin_.tv_nsec)) /
                          static_cast<double>(state_.iterations()) / static_cast<double>(n_ * n_);
        state_.counters["ns_per_sample"] = ns;
        state_.counters["memcpy_ns"] = copy_;
        state_.counters["times_memcpy"] = ns / copy_;
    }
    PerSample(const PerSample&) = delete;
    PerSample& operator=(const PerSample&) = delete;

  private:
    benchmark::State& state_;
    std::int64_t n_;
    double copy_;
    timespec begin_{};
};

}  // namespace relief::bench
