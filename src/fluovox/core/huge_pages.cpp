#include "fluovox/core/huge_pages.h"

#include <sys/mman.h>
#include <unistd.h>

#include <bit>
#include <cstdint>
#include <new>

namespace fluovox {
namespace {

constexpr std::size_t kHugePage = std::size_t{1} << 21U;

bool is_large(std::size_t bytes) {
    return bytes >= kHugePage;
}

std::size_t in_whole_pages(std::size_t bytes) {
    static const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    return (bytes + page - 1) / page * page;
}

}  // namespace

// Fresh from the kernel: what the heap gives back has its small pages already.
void* allocate_in_huge_pages(std::size_t bytes) {
    if (!is_large(bytes)) return ::operator new(bytes);
    const std::size_t wanted = in_whole_pages(bytes);
    void* mapped = mmap(nullptr, wanted + kHugePage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapped == MAP_FAILED) throw std::bad_alloc();
    auto* first = static_cast<std::byte*>(mapped);
    const std::size_t before = (kHugePage - std::bit_cast<std::uintptr_t>(first) % kHugePage) % kHugePage;
    std::byte* memory = first + before;
    if (before > 0) munmap(first, before);
    munmap(memory + wanted, kHugePage - before);
#ifdef MADV_HUGEPAGE
    (void)madvise(memory, wanted - wanted % kHugePage, MADV_HUGEPAGE);  // a wish: without it all is right, but slower
#endif
    return memory;
}

void free_in_huge_pages(void* memory, std::size_t bytes) noexcept {
    if (is_large(bytes)) {
        munmap(memory, in_whole_pages(bytes));
    } else {
        ::operator delete(memory);
    }
}

}  // namespace fluovox
