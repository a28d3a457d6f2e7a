#include "relief/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#if RELIEF_HAS_TBB
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#endif

namespace relief {

namespace {

std::atomic<int> g_threads{0};

#if RELIEF_PLAIN_THREADS
/// Threads of the standard library, started for each loop: for checkers of races, which can not see
/// into oneTBB. Loops inside of loops run in their thread.
template <class Block>
void run_on_threads(std::int64_t blocks, const Block& block) {
    thread_local bool inside = false;
    if (inside) {
        for (std::int64_t b = 0; b < blocks; ++b) block(b);
        return;
    }
    std::atomic<std::int64_t> next{0};
    const auto work = [&] {
        inside = true;
        for (std::int64_t b = next++; b < blocks; b = next++) block(b);
        inside = false;
    };
    std::vector<std::thread> threads;
    const std::int64_t count = std::min<std::int64_t>(blocks, thread_count());
    for (std::int64_t k = 1; k < count; ++k) threads.emplace_back(work);
    work();
    for (std::thread& thread : threads) thread.join();
}
#endif

}  // namespace

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
#if RELIEF_PLAIN_THREADS
    if (blocks > 1 && thread_count() > 1) return run_on_threads(blocks, block);
#endif
    for (std::int64_t b = 0; b < blocks; ++b) block(b);
}

}  // namespace detail
}  // namespace relief
