// SPDX-License-Identifier: Apache-2.0
#include "kalfem/page/typeset.hpp"

#include <gtest/gtest.h>

namespace kalfem {
namespace {

TEST(Typeset, PowersOfUnitsAreRaised) {
  EXPECT_EQ(typeset("m/s^2"), "m/s²");
  EXPECT_EQ(typeset("12.012 ± 0.061 MN/m^3"), "12.012 ± 0.061 MN/m³");
  EXPECT_EQ(typeset("m^-2 kg s^-12"), "m⁻² kg s⁻¹²");
  EXPECT_EQ(typeset("(m/s)^2/Hz"), "(m/s)²/Hz");
  EXPECT_EQ(typeset("m^n, m^(1/2), 3 ^ 2, m^1.5"), "m^n, m^(1/2), 3 ^ 2, m^1.5");
}

TEST(Typeset, PowersOfTenAreWrittenOutOrRaised) {
  EXPECT_EQ(typeset("8.89e+03 and 1.3e+03 times"), "8890 and 1300 times");
  EXPECT_EQ(typeset("1.2345e2, 1.5e-3 and 2e-4"), "123.45, 0.0015 and 0.0002");
  EXPECT_EQ(typeset("-5.057e-06, 2.1e+11"), "-5.057×10⁻⁶, 2.1×10¹¹");
  EXPECT_EQ(typeset("0 +- 0.04"), "0 ± 0.04");
}

TEST(Typeset, NamesHashesAndWhatIsTypedStay) {
  for (const char* text :
       {"3e8a91c", "x1e5", "strut_2e3", "1e5_2", "`noise: 2.1e-05 m/s^2`", "1.5.2e3", "5 mm", "", "^2"})
    EXPECT_EQ(typeset(text), text);
}

}  // namespace
}  // namespace kalfem
