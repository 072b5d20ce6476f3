#include <gtest/gtest.h>

#include "command.hpp"

namespace kalfem::test {
namespace {

nlohmann::json run_vehicle(const std::string& case_file, const std::string& variables, const std::string& name) {
  const auto folder = fresh_folder(name);
  const auto out = folder / "out";
  const std::string line = "env " + variables + " " + KALFEM_COMMAND + " run " + example(case_file) + " --out " +
                           out.string() + " >" + (folder / "stdout.txt").string() + " 2>" +
                           (folder / "stderr.txt").string();
  EXPECT_EQ(std::system(line.c_str()), 0) << read(folder / "stderr.txt");
  auto summary = read_summary(out);
  summary["errors"] = read(folder / "stderr.txt");
  return summary;
}

/// Four seconds of the vehicle, the record made from a superelement with modes to 1,200 Hz.
TEST(Vehicle, ShortenedRunReachesItsFigures) {
  const auto summary = run_vehicle("vehicle/vehicle.yaml", "DURATION=4 REFERENCE=superelement", "vehicle");
  EXPECT_EQ(summary["errors"], "");
  EXPECT_EQ(summary["model"]["substructures"]["frame"]["dofs"], 45564);
  for (const auto& [name, parameter] : summary["parameters"].items()) {
    const double error = std::abs(parameter["estimate"].get<double>() - parameter["true"].get<double>());
    EXPECT_LT(error, 0.03 * parameter["true"].get<double>()) << name;  // 1 % is reached at 10 s
    EXPECT_LT(error, 3.0 * parameter["std"].get<double>()) << name;
  }
  const auto& estimation = summary["estimation"];
  // Mean of 4,000 samples of chi-squared with 7 degrees of freedom: standard error 0.06.
  EXPECT_NEAR(estimation["nis"]["mean"].get<double>(), 7.0, 0.4);
  for (const auto& [sensor, ratio] : estimation["innovation_to_noise"].items())
    EXPECT_NEAR(ratio.get<double>(), 1.0, 0.06) << sensor;
  for (const char* point : {"frame.p5.z", "frame.p6.z", "frame.p7.z", "frame.p8.z"})
    EXPECT_LT(estimation["states"][point]["displacement_nrmse"].get<double>(), 0.01) << point;
  for (const char* point : {"p5.z", "p6.z", "p7.z", "p8.z"})
    EXPECT_LT(summary["prediction"]["frame"][point]["acceleration_nrmse"].get<double>(), 0.10) << point;
}

}  // namespace
}  // namespace kalfem::test
