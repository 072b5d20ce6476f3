// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/figures.hpp"
#include "updating_case.hpp"
#include "vehicle_case.hpp"

// Figures of docs/accuracy.md that take minutes: not part of `scripts/test`, but of `scripts/accuracy heavy`.

namespace kalfem::test {
namespace {

double z_score(const nlohmann::json& parameter) {
  return std::abs(parameter.at("estimate").get<double>() - parameter.at("true").get<double>()) /
         parameter.at("std").get<double>();
}

/// `code`: with which the run is to end.
nlohmann::json vehicle_summary(const std::string& verb, const std::string& case_file, const std::string& variables,
                               int code = 0) {
  const ScratchFolder folder("accuracy");
  const auto outcome = run_vehicle(verb, case_file, variables, folder);
  EXPECT_EQ(outcome.code, code) << outcome.errors;
  return outcome.code == code ? read_summary(folder / "out") : nlohmann::json{};
}

std::string stem(const std::string& figure, const std::string& parameter) {
  return figure + "." + parameter.substr(parameter.find('.') + 1);
}

/// Relative error of each parameter, and the error in standard deviations.
void expect_errors(const std::string& figure, const nlohmann::json& parameters) {
  for (const auto& [name, parameter] : parameters.items()) {
    expect_figure(stem(figure, name) + ".error", relative_error(parameter));
    expect_figure(stem(figure, name) + ".z", z_score(parameter));
  }
}

void expect_estimates(const std::string& figure, const nlohmann::json& parameters) {
  for (const auto& [name, parameter] : parameters.items()) {
    expect_figure(stem(figure, name) + ".estimate", parameter["estimate"].get<double>());
    expect_figure(stem(figure, name) + ".std", parameter["std"].get<double>());
  }
}

TEST(Accuracy, ChainWithOtherNoise) {
  const ScratchFolder folder("accuracy-chain");
  double most = 0.0;
  std::vector<double> displacements;
  for (int seed = 2; seed <= 7; ++seed) {
    const auto text = changed(read(example("chain/chain.yaml")), "\n  seed: 1", "\n  seed: " + std::to_string(seed));
    const auto outcome =
        run_command("run " + written(folder, text).string() + " --out " + folder.path().string(), folder);
    ASSERT_EQ(outcome.code, 0) << outcome.errors;
    const auto summary = read_summary(folder);
    for (const auto& [name, parameter] : summary["parameters"].items())
      most = std::max(most, relative_error(parameter));
    displacements.push_back(summary["estimation"]["states"]["body.3"]["displacement_nrmse"].get<double>());
  }
  expect_figure("chain_seeds.error.most", most);
  expect_figure("chain_seeds.displacement.least", std::ranges::min(displacements));
  expect_figure("chain_seeds.displacement.most", std::ranges::max(displacements));
}

TEST(Accuracy, VehicleOverTenSeconds) {
  const auto summary = vehicle_summary("run", "vehicle/vehicle.yaml", "REFERENCE=superelement");
  expect_estimates("vehicle", summary["parameters"]);
  expect_errors("vehicle", summary["parameters"]);
  const auto& estimation = summary["estimation"];
  expect_figure("vehicle.nis", estimation["nis"]["mean"].get<double>());
  std::vector<double> ratios;
  for (const auto& [sensor, ratio] : estimation["innovation_to_noise"].items()) ratios.push_back(ratio.get<double>());
  expect_figure("vehicle.innovation.least", std::ranges::min(ratios));
  expect_figure("vehicle.innovation.most", std::ranges::max(ratios));
  for (const std::string point : {"p5", "p6", "p7", "p8"}) {
    expect_figure("vehicle.displacement." + point,
                  estimation["states"]["frame." + point + ".z"]["displacement_nrmse"].get<double>());
    const auto& predicted = summary["prediction"]["frame"][point + ".z"];
    expect_figure("vehicle.prediction." + point, predicted["acceleration_nrmse_in_band"].get<double>());
    expect_figure("vehicle.prediction_wide." + point, predicted["acceleration_nrmse"].get<double>());
  }
}

/// The vehicle at 1 kHz, its augmented model with so many substeps a sample.
nlohmann::json vehicle_at_1_khz(int substeps) {
  const ScratchFolder folder("accuracy-1-khz");
  const auto text =
      changed(changed(read(example("vehicle/vehicle.yaml")), "${MESH:-frame.msh}", example("vehicle/frame.msh")),
              "\n  substeps: 1", "\n  substeps: " + std::to_string(substeps));
  setenv("SAMPLE_RATE", "1000", 1);
  setenv("REFERENCE", "superelement", 1);
  const auto outcome =
      run_command("run " + written(folder, text).string() + " --out " + folder.path().string(), folder);
  unsetenv("SAMPLE_RATE");
  unsetenv("REFERENCE");
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  return outcome.code == 0 ? read_summary(folder) : nlohmann::json{};
}

TEST(Accuracy, VehicleAtOneKilohertz) {
  const auto one = vehicle_at_1_khz(1), two = vehicle_at_1_khz(2);
  expect_errors("vehicle_1_khz.one_substep", one["parameters"]);
  expect_errors("vehicle_1_khz.two_substeps", two["parameters"]);
  std::vector<double> predicted;
  for (const std::string point : {"p5.z", "p6.z", "p7.z", "p8.z"})
    predicted.push_back(two["prediction"]["frame"][point]["acceleration_nrmse_in_band"].get<double>());
  expect_figure("vehicle_1_khz.prediction.least", std::ranges::min(predicted));
  expect_figure("vehicle_1_khz.prediction.most", std::ranges::max(predicted));
}

TEST(Accuracy, VehicleUpdatedByItsRecord) {
  const auto summary = vehicle_summary("update", "vehicle/update.yaml", "");
  for (const auto& [name, parameter] : summary["updating"]["parameters"].items())
    expect_figure("vehicle_update." + name, signed_error(parameter));
  for (const auto& [name, parameter] : summary["parameters"].items()) {
    expect_figure("vehicle_update." + name, relative_error(parameter));
    const double without = summary["updating"]["unknowns_without_updating"][name];
    expect_figure("vehicle_update." + name + ".without", without / parameter["true"].get<double>() - 1.0);
  }
  expect_figure("vehicle_update.stages", static_cast<double>(summary["updating"]["stages"].size()));
}

TEST(Accuracy, VehicleWithUnknownStiffness) {
  const auto summary = vehicle_summary("run", "vehicle/stiffness.yaml", "");
  expect_errors("vehicle_stiffness", summary["parameters"]);
  expect_figure("vehicle_stiffness.nis", summary["estimation"]["nis"]["mean"].get<double>());
}

/// Modes that the record shows are missing in the filter's model: the verdict is unusable.
TEST(Accuracy, VehicleSeenByWideBandSensors) {
  const auto summary = vehicle_summary("run", "vehicle/wide_band.yaml", "", 3);
  expect_estimates("wide_band", summary["parameters"]);
  expect_errors("wide_band", summary["parameters"]);
  expect_figure("wide_band.nis", summary["estimation"]["nis"]["mean"].get<double>());
}

}  // namespace
}  // namespace kalfem::test
