#include "relief/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <thread>

#if RELIEF_HAS_TBB
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#endif

namespace relief {

namespace {
std::atomic<int> g_threads{0};
}

void set_thread_count(int threads) {
    g_threads = std::max(0, threads);
}

int thread_count() {
    const int wanted = g_threads;
    return wanted > 0 ? wanted : std::max(1U, std::thread::hardware_concurrency());
}

namespace detail {

void parallel_for_blocks(std::int64_t begin, std::int64_t end, std::int64_t grain,
                         RangeFunction run, void* context) {
    if (begin >= end) return;
    grain = std::max<std::int64_t>(1, grain);
    const std::int64_t blocks = (end - begin + grain - 1) / grain;
    const auto block = [&](std::int64_t b) {
        run(context, begin + b * grain, std::min(end, begin + (b + 1) * grain));
    };
#if RELIEF_HAS_TBB
    if (blocks > 1 && thread_count() > 1) {
        // More threads than cores are allowed: tests ask for them.
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                        static_cast<std::size_t>(thread_count()));
        tbb::task_arena arena(thread_count());
        arena.execute(
            [&] { tbb::parallel_for(std::int64_t{0}, blocks, block, tbb::simple_partitioner()); });
        return;
    }
#endif
    for (std::int64_t b = 0; b < blocks; ++b) block(b);
}

}  // namespace detail
}  // namespace relief
