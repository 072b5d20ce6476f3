// SPDX-License-Identifier: Apache-2.0
// Runs a case file as the command does, and reads its results.
// Usage: run_case chain.yaml results
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/report/run_case.hpp"

int main(int, char** argv) try {
  const std::filesystem::path folder = argv[2];
  const kalfem::CaseResult result = kalfem::run_case(argv[1], folder);
  for (const auto& warning : result.warnings) std::cout << "warning: " << warning << '\n';
  if (!result.usable()) {
    std::cerr << "the numbers are not usable: " << result.failure << '\n';
    return 1;
  }
  for (const auto& p : result.estimated)
    std::cout << p.name << " = " << p.mean << " +- " << std::max(p.std, p.std_robust) << ' ' << p.unit << '\n';
  std::cout << "verdict: " << to_string(result.verdict.state()) << '\n';
  for (const auto& file : result.files) std::cout << "wrote " << (folder / file).string() << '\n';

  // The case simulates its record with mu_k1 = 20 N.
  const auto& k = result.estimated.at(0);
  const bool right = k.name == "suspension.mu_k1" && std::abs(k.mean - 20) < 3 * k.std;
  return right && std::filesystem::exists(folder / "summary.json") ? 0 : 1;
} catch (const kalfem::InvalidInput& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
