// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "vehicle_case.hpp"

namespace kalfem::test {
namespace {

double error_of(const nlohmann::json& parameter) {
  return std::abs(parameter["estimate"].get<double>() - parameter["true"].get<double>());
}

/// Four seconds of the vehicle, the record made from a superelement with modes to 1,200 Hz.
TEST(Vehicle, ShortenedRunReachesItsFigures) {
  const ScratchFolder folder("vehicle");
  const auto outcome = run_vehicle("run", "vehicle/vehicle.yaml", "DURATION=4 REFERENCE=superelement", folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors, "");
  const auto summary = read_summary(folder / "out");
  const auto& frame = summary["model"]["substructures"]["frame"];
  EXPECT_EQ(frame["dofs"], 45564);
  for (const auto& mode : frame["reduction"]["modes"])
    if (const double full = mode["full_hz"].get<double>(); full < 150.0)  // half the cut-off; found 1.5e-6
      EXPECT_NEAR(mode["reduced_hz"].get<double>(), full, 5e-6 * full);
  for (const auto& [name, parameter] : summary["parameters"].items()) {
    // found .15 %
    EXPECT_LT(error_of(parameter), 0.005 * parameter["true"].get<double>()) << name;
    EXPECT_LT(error_of(parameter), 3.0 * parameter["std"].get<double>()) << name;
  }
  const auto& estimation = summary["estimation"];
  // Mean of 4,000 samples of chi-squared with 7 degrees of freedom: standard error 0.06.
  EXPECT_NEAR(estimation["nis"]["mean"].get<double>(), 7.0, 0.2);
  for (const auto& [sensor, ratio] : estimation["innovation_to_noise"].items()) {
    // three standard errors over 4,000 samples, 0.011 each
    EXPECT_GE(ratio.get<double>(), 0.97) << sensor;
    EXPECT_LE(ratio.get<double>(), 1.035) << sensor;
  }
  for (const char* point : {"frame.p5.z", "frame.p6.z", "frame.p7.z", "frame.p8.z"})
    EXPECT_LT(estimation["states"][point]["displacement_nrmse"].get<double>(), 0.006) << point;  // found .26 %
  for (const char* point : {"p5.z", "p6.z", "p7.z", "p8.z"})
    EXPECT_LT(summary["prediction"]["frame"][point]["acceleration_nrmse_in_band"].get<double>(), 0.025)
        << point;  // found 1.0 %
}

/// Sensors wider than the reduced model: the bias is there, and so are the warning and the NIS that tell of it.
TEST(Vehicle, WideBandSensorsBiasAndTheProgramSaysSo) {
  const ScratchFolder folder("wide-band");
  const auto outcome = run_vehicle("run", "vehicle/wide_band.yaml", "", folder);
  ASSERT_EQ(outcome.code, 3) << outcome.errors;
  EXPECT_NE(outcome.errors.find("three times the sensors' bandwidth"), std::string::npos) << outcome.errors;
  const auto summary = read_summary(folder / "out");
  EXPECT_EQ(summary["verdict"]["state"], "unusable");
  EXPECT_GT(summary["estimation"]["nis"]["mean"].get<double>(), 14.0);
  for (const auto& [name, parameter] : summary["parameters"].items())
    EXPECT_GT(error_of(parameter), 5.0 * parameter["std"].get<double>()) << name;
}

}  // namespace
}  // namespace kalfem::test
