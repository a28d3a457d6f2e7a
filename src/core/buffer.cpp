#include "relief/core/buffer.h"

#include <cstdlib>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace relief::detail {

namespace {
constexpr std::size_t kHugePage = std::size_t{2} << 20;
constexpr std::size_t kHugeFrom = 2 * kHugePage;
}  // namespace

void* allocate_aligned(std::size_t bytes) {
    const std::size_t alignment = bytes >= kHugeFrom ? kHugePage : 64;
    const std::size_t padded = (bytes + alignment - 1) / alignment * alignment;
    if (padded < bytes) throw std::bad_alloc();
    void* block = std::aligned_alloc(alignment, padded);
    if (!block) throw std::bad_alloc();
#ifdef __linux__
    // Whole huge pages only: the rest of a last one would be memory for nothing.
    if (bytes >= kHugeFrom) madvise(block, bytes / kHugePage * kHugePage, MADV_HUGEPAGE);
#endif
    return block;
}

void free_aligned(void* block) noexcept {
    std::free(block);
}

}  // namespace relief::detail
