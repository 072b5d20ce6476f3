// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "command.hpp"

// The filter's loops are compiled for several widths of vector registers; KALFEM_CPU names the set that runs.

namespace kalfem::test {
namespace {

struct KernelSets : testing::Test {
  const ScratchFolder folder{"kernel-sets"};

  Outcome run_with(const std::string& set, const std::string& arguments) {
    setenv("KALFEM_CPU", set.c_str(), 1);
    const auto outcome = run_command(arguments, folder);
    unsetenv("KALFEM_CPU");
    return outcome;
  }
};

/// They round differently: estimates agree to a millionth of their deviations.
TEST_F(KernelSets, GiveTheSameEstimates) {
  ASSERT_EQ(run_command("new chain " + (folder / "chain").string(), folder).code, 0);
  nlohmann::json first;
  for (const std::string set : {"baseline", "avx2", "avx512"}) {
    const auto out = folder / set;
    const auto outcome = run_with(set, "run " + (folder / "chain/case.yaml").string() + " --out " + out.string());
    if (outcome.errors.find("and this processor runs") != std::string::npos) continue;
    ASSERT_EQ(outcome.code, 0) << outcome.errors;
    const auto found = read_summary(out)["parameters"];
    ASSERT_FALSE(found.empty());
    if (first.is_null()) first = found;
    for (const auto& [name, values] : found.items()) {
      const double estimate = first[name]["estimate"], deviation = first[name]["std"];
      EXPECT_NEAR(values["estimate"].get<double>(), estimate, 1e-6 * deviation) << set << ", " << name;
      EXPECT_NEAR(values["std"].get<double>(), deviation, 1e-6 * deviation) << set << ", " << name;
    }
  }
}

TEST_F(KernelSets, AreNamedByTheVersion) {
  EXPECT_NE(run_with("baseline", "--version").output.find("baseline kernels"), std::string::npos);
}

TEST_F(KernelSets, ThatDoNotExistAreRefused) {
  const auto outcome = run_with("avx1024", "check " + example("chain/chain.yaml"));
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("KALFEM_CPU is 'avx1024'"), std::string::npos) << outcome.errors;
  EXPECT_NE(outcome.errors.find("this processor runs baseline"), std::string::npos) << outcome.errors;
}

}  // namespace
}  // namespace kalfem::test
