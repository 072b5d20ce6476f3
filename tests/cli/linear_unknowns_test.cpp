// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "updating_case.hpp"
#include "vehicle_case.hpp"

// Unknowns of the filter that are numbers of linear substructures, from case file to summary.

namespace kalfem::test {
namespace {

/// |estimate - truth| in reported standard deviations.
double z_score(const nlohmann::json& parameter) {
  return std::abs(parameter.at("estimate").get<double>() - parameter.at("true").get<double>()) /
         parameter.at("std").get<double>();
}

/// Three seconds of the vehicle on its coarse mesh: Young's modulus of two regions, 12 and 14 % off, beside the
/// suspension. Each is found to 1 %, as the frame's bases are made again at the estimates.
TEST(LinearUnknowns, YoungsModulusOfTwoRegionsOfTheVehicle) {
  const ScratchFolder folder("stiffness");
  const auto outcome = run_vehicle("run", "vehicle/stiffness.yaml", "DURATION=3 MESH=small.msh", folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const auto summary = read_summary(folder / "out");
  ASSERT_EQ(summary["parameters"].size(), 4u);
  for (const auto& [name, parameter] : summary["parameters"].items()) {
    EXPECT_LT(relative_error(parameter), 0.01) << name;
    EXPECT_LT(z_score(parameter), 4.0) << name;
  }
  const auto& estimation = summary["estimation"];
  EXPECT_EQ(estimation["filter"], "partially_linear_ukf");
  EXPECT_EQ(estimation["linear_unknowns"]["reductions"], 2);
  EXPECT_GT(estimation["linear_unknowns"]["linearisations"].get<int>(), 2);
  // 3,000 samples: standard error 0.07; found 0.20 off, on a coarse mesh.
  EXPECT_NEAR(estimation["nis"]["mean"].get<double>(), 7.0, 0.3);
  for (const char* point : {"p5.z", "p6.z", "p7.z", "p8.z"})
    EXPECT_LT(summary["prediction"]["frame"][point]["acceleration_nrmse_in_band"].get<double>(), 0.025)
        << point;  // found .8 %
  EXPECT_NE(outcome.output.find("Linear part: relinearised"), std::string::npos);
}

std::string chain_with(const std::string& unknowns) {
  return changed(changed(changed(read(example("chain/chain.yaml")), "duration: 20 s", "duration: 8 s"),
                         "tolerance: 1e-4", "tolerance: 1e-2"),
                 "    suspension.mu_c1: {initial: 16 N, std: 50 %}\n", unknowns);
}

/// The damping of all modes is no dashpot's, so that no connector can carry it.
TEST(LinearUnknowns, DampingOfAllModesOfTheChain) {
  const ScratchFolder folder("modal-damping");
  const auto text = chain_with("    body.damping.modal: {initial: 1.6 %, std: 30 %}\n");
  const auto outcome =
      run_command("run " + written(folder, text).string() + " --out " + folder.path().string(), folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const auto summary = read_summary(folder);
  const auto& ratio = summary["parameters"]["body.damping.modal"];
  EXPECT_LT(z_score(ratio), 3.0);
  EXPECT_LT(relative_error(ratio), 0.008);  // found .25 %
  EXPECT_EQ(summary["estimation"]["linear_unknowns"]["reductions"], 1);
}

/// Every filter takes them.
TEST(LinearUnknowns, WithTheOtherFilters) {
  for (const std::string filter : {"ukf", "ukf_square_root", "partially_linear_ukf_square_root", "ekf"}) {
    const ScratchFolder folder("modal-damping-" + filter);
    const auto text = changed(chain_with("    body.damping.modal: {initial: 1.2 %, std: 30 %}\n"), "filter: auto",
                              "filter: " + filter);
    const auto outcome =
        run_command("estimate " + written(folder, text).string() + " --out " + folder.path().string(), folder);
    ASSERT_EQ(outcome.code, 0) << outcome.errors;
    EXPECT_EQ(outcome.errors, "");
    EXPECT_LT(z_score(read_summary(folder)["parameters"]["body.damping.modal"]), 3.5) << filter;
  }
}

struct UnknownMistake {
  const char* name;
  std::string text;
  std::string message;
};

class LinearUnknownMistake : public testing::TestWithParam<UnknownMistake> {};

TEST_P(LinearUnknownMistake, IsOneClearMessage) {
  const ScratchFolder folder(std::string("linear-unknown-") + GetParam().name);
  const auto outcome = run_command("check " + written(folder, GetParam().text).string(), folder);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find(GetParam().message), std::string::npos) << outcome.errors;
  EXPECT_NE(outcome.errors.find("case.yaml:"), std::string::npos) << outcome.errors;
}

INSTANTIATE_TEST_SUITE_P(
    Mistakes, LinearUnknownMistake,
    testing::Values(
        UnknownMistake{"Misspelt", chain_with("    body.damping.model: {initial: 1 %}\n"),
                       "there is no parameter 'body.damping.model' (did you mean 'body.damping.modal'?)"},
        UnknownMistake{"OfTwoKinds",
                       chain_with("    both: {initial: 1, applies_to: [suspension.mu_c1, body.damping.modal]}\n"),
                       "applies to parameters of connectors and of linear substructures"},
        UnknownMistake{"OfTwoUnits",
                       chain_with("    both: {initial: 1, applies_to: [body.damping.modal, "
                                  "body.damping.mass_factor]}\n"),
                       "applies to parameters in - and in 1/s"},
        UnknownMistake{"GivenTwice",
                       chain_with("    body.damping.modal: {initial: 1 %}\n"
                                  "    again: {initial: 1 %, applies_to: [body.damping.modal]}\n"),
                       "'body.damping.modal' is estimated already by estimate.unknown.body.damping.modal"},
        UnknownMistake{"WhileUpdating",
                       changed(short_chain(), "  unknown:\n", "  unknown:\n    body.damping.modal: {initial: 1 %}\n"),
                       "'body.damping.modal' is updated already by update.parameters.body.damping.modal"}),
    [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace kalfem::test
