#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace fluovox {

/// Memory for large tables that are read here and there: from 2 MB on the kernel is asked for it in pages of that size,
/// so that the processor need not look up the address of a small page at each read. What is left over at the end lies
/// in small pages: nothing is rounded up. Throws std::bad_alloc. Give the same `bytes` to free_in_huge_pages.
[[nodiscard]] void* allocate_in_huge_pages(std::size_t bytes);
void free_in_huge_pages(void* memory, std::size_t bytes) noexcept;

/// As std::allocator, of memory in huge pages.
template <class T>
struct HugePageAllocator {
    using value_type = T;

    HugePageAllocator() = default;
    template <class U>
    explicit HugePageAllocator(const HugePageAllocator<U>& /*of_other*/) {}

    [[nodiscard]] T* allocate(std::size_t count) {
        if (count > static_cast<std::size_t>(-1) / sizeof(T)) throw std::bad_array_new_length();
        return static_cast<T*>(allocate_in_huge_pages(count * sizeof(T)));
    }
    void deallocate(T* memory, std::size_t count) noexcept { free_in_huge_pages(memory, count * sizeof(T)); }

    bool operator==(const HugePageAllocator& /*other*/) const = default;
};

template <class T>
using HugePageVector = std::vector<T, HugePageAllocator<T>>;

}  // namespace fluovox
