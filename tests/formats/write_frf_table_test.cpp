// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tables/write_frf_table.hpp"

#include <gtest/gtest.h>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/tables/frf_table.hpp"

namespace kalfem {
namespace {

TEST(WrittenFrfTable, IsReadAgainToTheLastDigit) {
  const ScratchFolder folder("written_frf");
  FrequencyResponse written{.lines = Eigen::Vector3d(0.0, 1.0 / 3.0, 1e3),
                            .outputs = {{"frame.p6.z", "(m/s^2)/N"}, {"wheel-1.z", "m/N"}},
                            .values = Eigen::MatrixXcd::Random(3, 2)};
  written.values(1, 0) = {-1e-12 / 7.0, 1e9 / 7.0};
  write_frf_table(folder / "frf.csv", written);
  const auto found = read_frf_table(folder / "frf.csv");
  EXPECT_EQ(found.lines, written.lines);
  EXPECT_EQ(found.values, written.values);
  ASSERT_EQ(found.outputs.size(), 2u);
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_EQ(found.outputs[j].name, written.outputs[j].name);
    EXPECT_EQ(found.outputs[j].unit, written.outputs[j].unit);
  }
}

TEST(WrittenFrfTable, RefusesAPlaceThatCannotBeWritten) {
  const ScratchFolder folder("written_frf");
  EXPECT_THROW(write_frf_table(folder.path(), {}), InvalidInput);
}

}  // namespace
}  // namespace kalfem
