// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "casefile/small_cases.hpp"
#include "updating_case.hpp"

// Updatings by a simulation that is not smooth in its parameters.

namespace kalfem::test {
namespace {

const std::string rattle =
    rattling_mass + R"(simulate: {duration: 5 s, sample_rate: 100 Hz, integrator: newmark, substeps: 16}
update:
  parameters: {body.k.stiffness: {initial: 12 N/m}}
  compare: {record: {simulation: all}}
  check_sensitivities: true
)";

TEST(RoughUpdating, SaysThatTheResidualIsNotSmooth) {
  const ScratchFolder folder("update-rough");
  const auto outcome =
      run_command("update " + written(folder, rattle).string() + " --out " + folder.path().string(), folder);
  EXPECT_EQ(outcome.code, 3) << outcome.output;
  const std::string reason = "finite differences by 'body.k.stiffness' scatter: the residual is not smooth";
  EXPECT_NE(outcome.output.find(reason), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.errors.find(reason), std::string::npos) << outcome.errors;
  const auto updating = read_summary(folder)["updating"];
  EXPECT_FALSE(updating["converged"].get<bool>());
  EXPECT_NE(updating["termination"].get<std::string>().find(reason), std::string::npos);
  // The check at the start says the same.
  EXPECT_EQ(updating["sensitivities"]["body.k.stiffness"]["verdict"], "undecided: the differences scatter");
  EXPECT_EQ(updating["comparisons"]["record"]["substeps"], 4);
}

}  // namespace
}  // namespace kalfem::test
