#include "relief/core/buffer.h"

#include <cstdint>
#include <cstdlib>
#include <new>

// Sanitizers watch the heap only.
#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__)
#define RELIEF_MAP_BLOCKS
#include <sys/mman.h>
#endif

namespace relief::detail {

namespace {

constexpr std::size_t kLine = 64;

/// Stands in the cache line before a block.
struct Header {
    void* start;         ///< of what was allocated
    std::size_t mapped;  ///< bytes of a mapping of its own; 0: from the heap
};
static_assert(sizeof(Header) <= kLine);

void* put_header(std::byte* block, const Header& header) {
    new (block - kLine) Header(header);
    return block;
}

#ifdef RELIEF_MAP_BLOCKS
constexpr std::size_t kHugePage = std::size_t{2} << 20;
constexpr std::size_t kHugeFrom = 2 * kHugePage;
constexpr std::size_t kPage = 4096;

/// A mapping of its own goes back to the system as a whole; blocks aligned to huge pages would tear
/// the heap.
void* map_block(std::size_t bytes) {
    const std::size_t needed = (bytes + kPage - 1) / kPage * kPage;
    const std::size_t reserved = needed + kHugePage + kPage;
    if (reserved < bytes) throw std::bad_alloc();
    void* const region =
        mmap(nullptr, reserved, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (region == MAP_FAILED) throw std::bad_alloc();
    auto* const first = static_cast<std::byte*>(region);
    const std::size_t past = (reinterpret_cast<std::uintptr_t>(first) + kPage) & (kHugePage - 1);
    std::byte* const block = first + kPage + (past == 0 ? 0 : kHugePage - past);
    // Whole huge pages only: the rest of a last one would be memory for nothing.
    madvise(block, bytes / kHugePage * kHugePage, MADV_HUGEPAGE);
    return put_header(block, {region, reserved});
}
#endif

}  // namespace

void* allocate_aligned(std::size_t bytes) {
#ifdef RELIEF_MAP_BLOCKS
    if (bytes >= kHugeFrom) return map_block(bytes);
#endif
    const std::size_t padded = (bytes + 2 * kLine - 1) / kLine * kLine;
    if (padded < bytes) throw std::bad_alloc();
    void* const start = std::aligned_alloc(kLine, padded);
    if (!start) throw std::bad_alloc();
    return put_header(static_cast<std::byte*>(start) + kLine, {start, 0});
}

void free_aligned(void* block) noexcept {
    const Header header = *reinterpret_cast<const Header*>(static_cast<std::byte*>(block) - kLine);
#ifdef RELIEF_MAP_BLOCKS
    if (header.mapped > 0) {
        munmap(header.start, header.mapped);
        return;
    }
#endif
    std::free(header.start);
}

}  // namespace relief::detail
