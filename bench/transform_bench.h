#pragma once

#include <benchmark/benchmark.h>
#include <ctime>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>
#include <string>

#include "relief/core/grid.h"
#include "relief/core/parallel.h"

/// Shared by the transform benchmarks: the yardstick of all is a memcpy of the raster, measured
/// beside each because other work on the machine changes both.
namespace relief::bench {

/// A smooth surface plus roughness: denormals and zeros would be unfair either way.
template <class T>
Grid<T> terrain(std::int64_t n) {
    Grid<T> grid(n, n);
    std::uint32_t state = 12345;
    for (std::int64_t r = 0; r < n; ++r)
        for (std::int64_t c = 0; c < n; ++c) {
            state = state * 1664525U + 1013904223U;
            grid(r, c) = static_cast<T>(0.01 * static_cast<double>(r + c) +
                                        1e-8 * static_cast<double>(state));
        }
    return grid;
}

/// Nanoseconds of the wall clock, or of this thread alone, which other programs do not disturb.
inline double nanoseconds(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return static_cast<double>(now.tv_sec) * 1e9 + static_cast<double>(now.tv_nsec);
}

/// What one call of `body` takes.
template <class Body>
double time_of(clockid_t clock, Body body) {
    const double start = nanoseconds(clock);
    body();
    benchmark::ClobberMemory();
    return nanoseconds(clock) - start;
}

template <class T>
void copy(const Grid<T>& from, Grid<T>& to) {
    std::memcpy(to.row(0), from.row(0), std::size_t(from.rows() * from.stride()) * sizeof(T));
}

/// Best of some.
template <class T>
double copy_nanoseconds(const Grid<T>& samples) {
    Grid<T> to = samples.clone();
    double best = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 9; ++k)
        best = std::min(best, time_of(CLOCK_THREAD_CPUTIME_ID, [&] { copy(samples, to); }));
    return best;
}

/// Runs `body` with some threads and reports its best time in nanoseconds a sample and in memcpys
/// of `samples`. One thread is measured by its own clock.
template <class T, class Body>
void measure(benchmark::State& state, const Grid<T>& samples, std::int64_t threads, Body body) {
    const double reference = copy_nanoseconds(samples);
    set_thread_count(static_cast<int>(threads));
    const clockid_t clock = threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC;
    double best = std::numeric_limits<double>::infinity();
    for (auto _ : state) best = std::min(best, time_of(clock, body));
    set_thread_count(0);
    state.counters["ns_per_sample"] = best / double(samples.count());
    state.counters["memcpys"] = best / reference;
}

/// Runs `body` with one and with two threads in turn and reports the ratio of the best times.
template <class Body>
void measure_two_threads(benchmark::State& state, Body body) {
    double best[2] = {std::numeric_limits<double>::infinity(),
                      std::numeric_limits<double>::infinity()};
    for (auto _ : state)
        for (int k = 0; k < 2; ++k) {
            set_thread_count(k + 1);
            best[k] = std::min(best[k], time_of(CLOCK_MONOTONIC, body));
        }
    set_thread_count(0);
    state.counters["speedup"] = best[0] / best[1];
}

/// A line "key: n kB" of /proc/self/status, in bytes; 0 where there is none.
inline double memory_status(const std::string& key) {
    std::ifstream status("/proc/self/status");
    std::string word;
    double kilobytes = 0;
    while (status >> word)
        if (word == key + ":" && status >> kilobytes) return 1024 * kilobytes;
    return 0;
}

/// Runs `body`, which returns the bytes of what it was given and has made, and reports how much
/// more memory it took at its peak.
template <class Body>
void measure_peak(benchmark::State& state, Body body) {
    for (auto _ : state) {
        const double before = memory_status("VmRSS");
        std::ofstream("/proc/self/clear_refs") << "5";  // the peak starts anew
        const double kept = body();
        const double peak = memory_status("VmHWM");
        if (before == 0 || peak == 0) return state.SkipWithError("needs Linux");
        state.counters["peak_over_kept"] = (peak - before) / kept;
    }
}

}  // namespace relief::bench
