#pragma once

// Loops over many small items that come out the same for any number of threads: the pieces have a fixed size, and what
// they yield is put together in their order.

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace fluovox {

/// Calls `work(begin, end)` for consecutive ranges of `items` in parallel; returns what each gave, in order.
template <class Work>
auto map_chunks(std::size_t items, const Work& work) {
    constexpr std::size_t kChunk = 16384;
    const std::size_t chunks = (items + kChunk - 1) / kChunk;
    std::vector<decltype(work(items, items))> results(chunks);
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
        results[chunk] = work(chunk * kChunk, std::min(items, (chunk + 1) * kChunk));
    });
    return results;
}

/// Sum of `value(i)` over all items, always added in the same order.
template <class Value>
double sum_of(std::size_t items, const Value& value) {
    double sum = 0;
    for (const double part : map_chunks(items, [&](std::size_t begin, std::size_t end) {
             double some = 0;
             for (std::size_t i = begin; i < end; ++i)
                 some += value(i);
             return some;
         }))
        sum += part;
    return sum;
}

/// Calls `work(i)` for every item in parallel.
template <class Work>
void for_items(std::size_t items, const Work& work) {
    constexpr std::size_t kGrain = 1024;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, items, kGrain), [&](const auto& range) {
        for (std::size_t i = range.begin(); i != range.end(); ++i)
            work(i);
    });
}

}  // namespace fluovox
