#pragma once

#include <cstdint>
#include <type_traits>

namespace relief {

/// How many threads `parallel_for` uses from now on, process wide. 0: as many as the machine has
/// cores.
void set_thread_count(int threads);
[[nodiscard]] int thread_count();

namespace detail {
using RangeFunction = void (*)(void* context, std::int64_t begin, std::int64_t end);
void parallel_for_blocks(std::int64_t begin, std::int64_t end, std::int64_t grain,
                         RangeFunction run, void* context);
}  // namespace detail

/// Calls fn(first, last) for consecutive blocks of `grain` indices that cover [begin, end), in any
/// order and from several threads. Block borders depend on begin, end and grain only, so a function
/// whose blocks write disjoint results gives the same bytes for every thread count. fn must not
/// throw (std::bad_alloc passes). Requires: grain >= 1. Runs in the calling thread when one block
/// or one thread is all there is.
template <class Function>
void parallel_for(std::int64_t begin, std::int64_t end, std::int64_t grain, Function&& fn) {
    using Plain = std::remove_reference_t<Function>;
    detail::parallel_for_blocks(
        begin, end, grain,
        [](void* context, std::int64_t first, std::int64_t last) {
            (*static_cast<Plain*>(context))(first, last);
        },
        const_cast<void*>(static_cast<const void*>(&fn)));
}

}  // namespace relief
