#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "command.hpp"

namespace kalfem::test {

/// Runs a verb on a case of the vehicle with variables set; the results are in folder/out.
inline Outcome run_vehicle(const std::string& verb, const std::string& case_file, const std::string& variables,
                           const std::filesystem::path& folder) {
  const std::string line = "env OPENBLAS_NUM_THREADS=1 " + variables + " " + KALFEM_COMMAND + " " + verb + " " +
                           example(case_file) + " --out " + (folder / "out").string() + " >" +
                           (folder / "stdout.txt").string() + " 2>" + (folder / "stderr.txt").string();
  const int status = std::system(line.c_str());
  return {WEXITSTATUS(status), read(folder / "stdout.txt"), read(folder / "stderr.txt")};
}

inline double error_of(const nlohmann::json& parameter) {
  return std::abs(parameter["estimate"].get<double>() - parameter["true"].get<double>());
}

/// Sensors wider than the reduced model: the bias is there, and so are the warning and the NIS that tell of it.
inline void expect_wide_band_bias(const std::string& variables) {
  const ScratchFolder folder("wide-band");
  const auto outcome = run_vehicle("run", "vehicle/wide_band.yaml", variables, folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("three times the sensors' bandwidth"), std::string::npos) << outcome.errors;
  const auto summary = read_summary(folder / "out");
  EXPECT_GT(summary["estimation"]["nis"]["mean"].get<double>(), 14.0);
  for (const auto& [name, parameter] : summary["parameters"].items())
    EXPECT_GT(error_of(parameter), 5.0 * parameter["std"].get<double>()) << name;
}

}  // namespace kalfem::test
