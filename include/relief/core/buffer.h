#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <utility>

namespace relief {

namespace detail {
/// Cache-line aligned storage; blocks of 4 MiB and more are aligned to huge pages and offered to
/// them, because first touch of small pages costs more than a whole transform. Throws
/// std::bad_alloc.
void* allocate_aligned(std::size_t bytes);
void free_aligned(void* block) noexcept;
}  // namespace detail

/// An owned, cache-line aligned array. Elements are NOT initialised: whoever allocates, fills.
template <class T>
class Buffer {
    static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

  public:
    Buffer() = default;
    explicit Buffer(std::size_t size)
        : data_(size ? static_cast<T*>(detail::allocate_aligned(size * sizeof(T))) : nullptr),
          size_(size),
          capacity_(size) {}
    /// What is moved from is empty.
    Buffer(Buffer&& other) noexcept
        : data_(std::move(other.data_)),
          size_(std::exchange(other.size_, 0)),
          capacity_(std::exchange(other.capacity_, 0)) {}
    Buffer& operator=(Buffer&& other) noexcept {
        data_ = std::move(other.data_);
        size_ = std::exchange(other.size_, 0);
        capacity_ = std::exchange(other.capacity_, 0);
        return *this;
    }

    /// Becomes an array of another size; what was in it is lost. Allocates only if it must grow
    /// beyond all sizes that it had.
    void renew(std::size_t size) {
        if (size > capacity_) {
            *this = Buffer();  // before there is another block
            *this = Buffer(size);
        }
        size_ = size;
    }

    [[nodiscard]] T* data() { return data_.get(); }
    [[nodiscard]] const T* data() const { return data_.get(); }
    [[nodiscard]] std::size_t size() const { return size_; }
    T& operator[](std::size_t k) { return data_.get()[k]; }
    const T& operator[](std::size_t k) const { return data_.get()[k]; }

  private:
    struct Free {
        void operator()(T* block) const noexcept { detail::free_aligned(block); }
    };
    std::unique_ptr<T[], Free> data_;
    std::size_t size_ = 0;
    std::size_t capacity_ = 0;
};

}  // namespace relief
