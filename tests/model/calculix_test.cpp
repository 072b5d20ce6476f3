// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>

#include "base/absent.hpp"
#include "base/scratch_folder.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/assembly/assembly.hpp"
#include "model/calculix.hpp"
#include "model/inp_writer.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

TEST(CalculiX, VehicleFrameHasTheSameFirstTenElasticFrequencies) {
  if (!has_calculix()) KALFEM_ABSENT("CalculiX (ccx) is not installed");
  const auto model = frame();
  const auto assembled = assemble(model);
  const ScratchFolder folder("calculix");
  write_deck(model, folder / "frame.inp");
  ASSERT_TRUE(run_calculix(folder, "frame"));
  const auto theirs = frequencies_in(folder / "frame.dat");
  ASSERT_EQ(theirs.size(), 18u);
  const auto modes = lowest_modes(evaluate(assembled.stiffness, assembled.parameters),
                                  evaluate(assembled.mass, assembled.parameters), {.count = 16});
  // Six modes on the springs, found within 1.5e-5, then ten of the frame: two shell formulations on one mesh, .54 %.
  for (Index i = 0; i < 16; ++i) {
    const double ours = std::sqrt(modes.values[i]) / (2.0 * std::numbers::pi);
    EXPECT_NEAR(ours, theirs[static_cast<std::size_t>(i)], (i < 6 ? 4e-5 : 0.012) * ours) << i + 1;
  }
  EXPECT_GT(std::sqrt(modes.values[6]) / (2.0 * std::numbers::pi), 40.0);
}

}  // namespace
}  // namespace kalfem
