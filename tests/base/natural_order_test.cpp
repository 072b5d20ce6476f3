// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/natural_order.hpp"

#include <gtest/gtest.h>

namespace kalfem {
namespace {

TEST(NaturalOrder, NumbersInNamesCountAsNumbers) {
  const std::vector<std::string> wanted{"1", "2", "10", "11", "a", "k2", "k10", "k10.a2", "k10.a10", "k11"};
  std::vector<std::string> names(wanted.rbegin(), wanted.rend());
  EXPECT_EQ(in_natural_order(names), wanted);
  std::ranges::sort(names);
  EXPECT_NE(names, wanted);
}

/// Also for names with leading zeros, digits beyond any integer, and bytes above 127.
TEST(NaturalOrder, IsAStrictOrder) {
  const std::vector<std::string> names{"",
                                       "0",
                                       "00",
                                       "1",
                                       "01",
                                       "001",
                                       "k1",
                                       "k01",
                                       "k01a",
                                       "k1a",
                                       "k1b",
                                       "9999999999999999999999",
                                       "10000000000000000000000",
                                       "\xC3\xBC"
                                       "2",
                                       "\xC3\xBC"
                                       "10",
                                       "-2",
                                       "-10",
                                       "1.5",
                                       "1.10"};
  for (const auto& a : names)
    for (const auto& b : names) {
      EXPECT_EQ(natural_less(a, b) || natural_less(b, a), a != b) << a << " and " << b;
      EXPECT_FALSE(natural_less(a, b) && natural_less(b, a)) << a << " and " << b;
      for (const auto& c : names)
        if (natural_less(a, b) && natural_less(b, c)) EXPECT_TRUE(natural_less(a, c)) << a << ", " << b << ", " << c;
    }
  EXPECT_TRUE(natural_less("9999999999999999999999", "10000000000000000000000"));
  EXPECT_TRUE(
      natural_less("\xC3\xBC"
                   "2",
                   "\xC3\xBC"
                   "10"));
}

}  // namespace
}  // namespace kalfem
