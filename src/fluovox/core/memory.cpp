#include "fluovox/core/memory.h"

#include <sys/resource.h>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace fluovox {

std::uint64_t peak_resident_bytes() {
    rusage usage{};
    if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
    const auto kibibytes = usage.ru_maxrss;  // NOLINT(*-union-access): the C library has two names for one number
    return static_cast<std::uint64_t>(kibibytes) * 1024;
}

void release_freed_memory() {
#ifdef __GLIBC__
    ::malloc_trim(0);
#endif
}

}  // namespace fluovox
