#pragma once

// Loops over many small items that come out the same for any number of threads: the pieces have a fixed size, and what
// they yield is put together in their order.

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace fluovox {

inline constexpr std::size_t kItemsPerChunk = 16384;

/// Calls `work(begin, end)` for consecutive ranges of `items` in parallel, each kItemsPerChunk long but the last;
/// returns what each gave, in order.
template <class Work>
auto map_chunks(std::size_t items, const Work& work) {
    const std::size_t chunks = (items + kItemsPerChunk - 1) / kItemsPerChunk;
    std::vector<decltype(work(items, items))> results(chunks);
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
        results[chunk] = work(chunk * kItemsPerChunk, std::min(items, (chunk + 1) * kItemsPerChunk));
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

/// Turns counts into the places where what was counted begins; returns their sum.
template <class Counts>
std::size_t counts_to_places(Counts& counts) {
    std::size_t sum = 0;
    for (auto& count : counts)
        count = std::exchange(sum, sum + count);
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
