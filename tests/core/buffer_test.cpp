#include "relief/core/buffer.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>

namespace relief {
namespace {

/// Memory stays where it is until it is too little; blocks of all sizes can be written to.
TEST(Buffer, Renew) {
    Buffer<std::uint32_t> buffer(1000);
    const std::uint32_t* const first = buffer.data();
    buffer.renew(10);
    EXPECT_EQ(buffer.size(), 10U);
    buffer.renew(1000);
    EXPECT_EQ(buffer.data(), first);
    for (const std::size_t size :
         {std::size_t{3'000'000}, std::size_t{0}, std::size_t{2'000'000}}) {
        buffer.renew(size);
        ASSERT_EQ(buffer.size(), size);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(buffer.data()) % 64, 0U);
        for (std::size_t k = 0; k < size; ++k) buffer[k] = static_cast<std::uint32_t>(k);
        for (std::size_t k = 0; k < size; k += 997) ASSERT_EQ(buffer[k], k);
    }
    Buffer<std::uint32_t> fresh = std::move(buffer);
    EXPECT_EQ(fresh.size(), 2'000'000U);
    buffer.renew(5);  // NOLINT(bugprone-use-after-move): it is empty
    buffer[4] = 7;
    EXPECT_EQ(buffer[4], 7U);
    fresh = {};
    EXPECT_EQ(fresh.size(), 0U);
    fresh.renew(5);
    fresh[4] = 7;
    EXPECT_EQ(fresh[4], 7U);
}

}  // namespace
}  // namespace relief
