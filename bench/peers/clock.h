#pragma once

#include <time.h>

namespace relief::peers {

/// What the clock of this thread says, in seconds: other programs do not drive it.
[[nodiscard]] inline double thread_seconds() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace relief::peers
