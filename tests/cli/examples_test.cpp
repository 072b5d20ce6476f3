// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/figures.hpp"
#include "command.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"

namespace kalfem::test {
namespace {

/// Runs an example and returns its summary; the folder holds the five files of the contract.
nlohmann::json run_example(const std::string& name, const std::filesystem::path& folder) {
  const auto outcome = run_command("run " + example(name) + " --out " + (folder / "out").string(), folder);
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors, "");
  for (const char* file : {"summary.json", "results.h5", "report.html", "case.resolved.yaml", "case.identified.yaml"})
    EXPECT_TRUE(std::filesystem::exists(folder / "out" / file)) << file;
  return read_summary(folder / "out");
}

double relative_error(const nlohmann::json& parameter) {
  return std::abs(parameter["estimate"].get<double>() / parameter["true"].get<double>() - 1.0);
}

double normalised_error(const nlohmann::json& parameter) {
  return std::abs(parameter["estimate"].get<double>() - parameter["true"].get<double>()) /
         parameter["std"].get<double>();
}

/// The truth within `scores` reported deviations, and these no larger than a share of the truth: so that what is found
/// is neither surer than it may be nor vaguer than the record allows.
void expect_found(const nlohmann::json& parameters, double scores, double share) {
  for (const auto& [name, parameter] : parameters.items()) {
    EXPECT_LT(normalised_error(parameter), scores) << name;
    EXPECT_LT(parameter["std"].get<double>(), share * parameter["true"].get<double>()) << name;
  }
}

// One score of a normal variable in 2,000 is larger, and the seeds are fixed.
constexpr double scores = 3.5;
// Three standard errors of the mean NIS of 4 channels over 18,000 samples, 0.021 each.
constexpr double nis_of_four = 0.063;

TEST(Examples, ChainReachesTheFiguresOfThePaper) {
  const ScratchFolder folder("chain");
  const auto summary = run_example("chain/chain.yaml", folder);
  for (const char* name : {"suspension.mu_k1", "suspension.mu_c1"}) {
    EXPECT_LT(relative_error(summary["parameters"][name]), 0.01) << name;  // the paper's
    expect_figure("chain." + std::string(name) + ".error", relative_error(summary["parameters"][name]));
    expect_figure("chain." + std::string(name) + ".z", normalised_error(summary["parameters"][name]));
  }
  expect_found(summary["parameters"], 3.0, 0.003);  // .10 and .17 %
  expect_figure("chain.nis", summary["estimation"]["nis"]["mean"].get<double>());
  expect_figure("chain.displacement", summary["estimation"]["states"]["body.3"]["displacement_nrmse"].get<double>());
  std::vector<double> predicted;
  for (const auto& [point, errors] : summary["prediction"]["body"].items())
    predicted.push_back(errors["acceleration_nrmse"].get<double>());
  expect_figure("chain.prediction.least", std::ranges::min(predicted));
  expect_figure("chain.prediction.most", std::ranges::max(predicted));
  EXPECT_NEAR(summary["estimation"]["nis"]["mean"].get<double>(), 4.0, nis_of_four);
  // Seeds give .20 to .46 %.
  EXPECT_LE(summary["estimation"]["states"]["body.3"]["displacement_nrmse"].get<double>(), 0.005);
  EXPECT_EQ(summary["prediction"]["body"].size(), 10u);
  for (const auto& [point, errors] : summary["prediction"]["body"].items())
    EXPECT_LE(errors["acceleration_nrmse"].get<double>(), 0.02) << point;  // up to 1.0 %
}

TEST(Examples, ResultsFileHoldsTheContract) {
  const ScratchFolder folder("contract");
  run_example("chain/expression.yaml", folder);
  const auto file = Hdf5File::open((folder / "out" / "results.h5").string());
  for (const char* name :
       {"/time", "/measurements/a3", "/truth/body.3/displacement", "/truth/body.3/velocity",
        "/truth/body.3/acceleration", "/estimate/body.3/displacement", "/estimate/body.3/displacement_std",
        "/estimate/body.3/velocity", "/estimate/body.3/acceleration_std", "/estimate/parameters/suspension.mu_k1",
        "/estimate/parameters/suspension.mu_k1_std", "/innovation/value/a3", "/innovation/nis",
        "/prediction/body.10/acceleration"})
    EXPECT_TRUE(file.contains(name)) << name;
  EXPECT_EQ(file.read("/time").size(), file.read("/truth/body.3/displacement").size());
  EXPECT_EQ(file.text_attribute("/truth/body.3/displacement", "unit"), "m");
  EXPECT_EQ(file.number_attribute("/truth/body.3/displacement", "sample_rate"), 1000.0);
}

TEST(Examples, ClusteredSensors) {
  const auto summary = run_example("chain/clustered.yaml", ScratchFolder("clustered"));
  expect_found(summary["parameters"], scores, 0.003);  // .08 and .15 %
  EXPECT_NEAR(summary["estimation"]["nis"]["mean"].get<double>(), 4.0, nis_of_four);
}

TEST(Examples, BoucWenSuspension) {
  const auto summary = run_example("chain/bouc_wen.yaml", ScratchFolder("bouc-wen"));
  expect_found(summary["parameters"], scores, 0.01);  // .10 and .52 %
}

TEST(Examples, ExpressionLaw) {
  const auto summary = run_example("chain/expression.yaml", ScratchFolder("expression"));
  expect_found(summary["parameters"], scores, 0.006);  // .18 and .32 %
}

TEST(Examples, LocalModel) {
  const auto summary = run_example("chain/local.yaml", ScratchFolder("local"));
  expect_found(summary["parameters"], scores, 0.0015);  // .06 % both
}

TEST(Examples, TheResolvedCaseRunsAgainWithTheSameResult) {
  const ScratchFolder folder("resolved");
  std::filesystem::create_directories(folder / "again");
  const auto first = run_example("chain/local.yaml", folder);
  const auto outcome = run_command(
      "run " + (folder / "out" / "case.resolved.yaml").string() + " --out " + (folder / "again").string(), folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_EQ(first["parameters"].dump(), read_summary(folder / "again")["parameters"].dump());
}

}  // namespace
}  // namespace kalfem::test
