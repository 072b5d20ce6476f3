// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/written_units.hpp"

#include "casefile/record_cases.hpp"

// What a study remembers of the case as it was written: units of parameters, and the files that were read.

namespace kalfem::record_cases {
namespace {

TEST(WrittenUnit, IsWhatFollowsTheNumber) {
  EXPECT_EQ(unit_written_in("30 kN/m"), "kN/m");
  EXPECT_EQ(unit_written_in("-2.5e-3 m/s^2/sqrt(Hz)"), "m/s^2/sqrt(Hz)");
  EXPECT_EQ(unit_written_in("1e3N "), "N");
  for (const std::string text : {"30", "20 %", "0 s", "-1e-3", "", "auto", "3 apples"})
    EXPECT_EQ(unit_written_in(text), "") << text;
}

class WhatWasWritten : public RecordCase {};

TEST_F(WhatWasWritten, UnitsStayThoseOfTheUser) {
  write_record(si_columns());
  EXPECT_EQ(load().written_unit("s.k.stiffness"), "N/m");
  EXPECT_EQ(load({{"initial: 760 N/m", "initial: 0.76 kN/m"}}).written_unit("s.k.stiffness"), "kN/m");
  EXPECT_EQ(load({{"initial: 760 N/m", "initial: 760"}}).written_unit("s.k.stiffness"), "");
  EXPECT_EQ(load().written_unit("another"), "");
}

TEST_F(WhatWasWritten, FilesAreKnown) {
  write_record(si_columns());
  const auto files = load().files;
  ASSERT_EQ(files.size(), 2U) << "of the excitation and of the record";
  for (const auto& file : files) EXPECT_EQ(file, folder_ / "record.csv");
}

}  // namespace
}  // namespace kalfem::record_cases
