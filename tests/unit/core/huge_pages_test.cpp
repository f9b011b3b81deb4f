#include "fluovox/core/huge_pages.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <numeric>
#include <utility>

namespace fluovox {
namespace {

constexpr std::size_t kHugePage = std::size_t{1} << 21U;

TEST(HugePages, LargeTablesBeginWherePagesDoAndKeepTheirValues) {
    for (const std::size_t bytes : {kHugePage, kHugePage + 4, 3 * kHugePage - 4, 5 * kHugePage + 12344}) {
        HugePageVector<std::uint32_t> table(bytes / 4);
        EXPECT_EQ(std::bit_cast<std::uintptr_t>(table.data()) % kHugePage, 0U);
        std::iota(table.begin(), table.end(), 7U);
        const HugePageVector<std::uint32_t> copy = table;
        const HugePageVector<std::uint32_t> moved = std::move(table);
        for (std::size_t i = 0; i < copy.size(); ++i) {
            ASSERT_EQ(copy[i], i + 7);
            ASSERT_EQ(moved[i], i + 7);
        }
    }
}

TEST(HugePages, TablesGrowFromNothing) {
    HugePageVector<std::uint16_t> table;
    for (std::size_t i = 0; i < kHugePage; ++i)
        table.push_back(static_cast<std::uint16_t>(i));
    table.shrink_to_fit();
    for (std::size_t i = 0; i < table.size(); ++i)
        ASSERT_EQ(table[i], static_cast<std::uint16_t>(i));
}

TEST(HugePages, TooMuchIsAnException) {
    EXPECT_THROW((void)allocate_in_huge_pages(std::size_t{1} << 62U), std::bad_alloc);
    EXPECT_THROW((void)HugePageAllocator<double>().allocate(static_cast<std::size_t>(-1) / 4), std::bad_alloc);
}

}  // namespace
}  // namespace fluovox
