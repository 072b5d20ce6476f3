// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>
#include <iostream>

#include <fmt/format.h>

#include "base/places.hpp"
#include "base/scratch_folder.hpp"
#include "kalfem/steps/run_study.hpp"

namespace kalfem::test {
namespace {

std::string example(const std::string& name) {
  std::ifstream file(source_folder() + "/examples/" + name);
  return {std::istreambuf_iterator<char>(file), {}};
}

void replace(std::string& text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
}

/// Part of the seeds whose run is consistent; prints the reasons of the others.
double consistent_part(const std::string& text, const std::string& seed, int seeds) {
  const ScratchFolder folder("false-alarms");
  int consistent = 0;
  for (int i = 1; i <= seeds; ++i) {
    std::string changed = text;
    replace(changed, seed, fmt::format("  seed: {}", i));
    std::ofstream(folder / "case.yaml") << changed;
    const auto results = run_study(load_study((folder / "case.yaml").string()), "estimate");
    if (results.verdict.state() == VerdictState::consistent)
      ++consistent;
    else
      std::cout << "seed " << i << ": " << results.verdict.reasons().front().text << std::endl;
  }
  std::cout << consistent << " of " << seeds << " are consistent" << std::endl;
  return double(consistent) / seeds;
}

// Right models, whose runs differ by the noise of the sensors: at least 95 % are consistent.
TEST(FalseAlarms, AreRareOnTheChain) {
  EXPECT_GE(consistent_part(example("chain/chain.yaml"), "  seed: 1\n", 100), 0.95);
}

TEST(FalseAlarms, AreRareOnTheHystereticChain) {
  EXPECT_GE(consistent_part(example("chain/bouc_wen.yaml"), "  seed: 1\n", 40), 0.95);
}

TEST(FalseAlarms, AreRareOnTheVehicle) {
  std::string text = example("vehicle/vehicle.yaml");
  replace(text, "${MESH:-frame.msh}", source_folder() + "/examples/vehicle/small.msh");
  replace(text, "${REFERENCE:-full}", "superelement");
  replace(text, "${DURATION:-10}", "5");
  EXPECT_GE(consistent_part(text, "  seed: 5", 20), 0.95);
}

}  // namespace
}  // namespace kalfem::test
