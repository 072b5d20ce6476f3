// SPDX-License-Identifier: Apache-2.0
// What tests over many random records share.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

#include <fmt/format.h>

#include "random_record.hpp"

namespace kalfem::calibration {

/// A number from the environment, so that other seeds, or a part of them, can be looked at.
inline int number(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text ? std::atoi(text) : otherwise;
}

/// Whether a count of intervals that hold the truth lies in the 99 % binomial range of 95 %.
inline bool is_binomial(int held, int intervals) {
  return std::abs(held - 0.95 * intervals) <= 2.576 * std::sqrt(0.95 * 0.05 * intervals);
}

inline bool holds(const ParameterEstimate& found, double truth) {
  return found.interval_95.lower <= truth && truth <= found.interval_95.upper;
}

/// Intervals and how many of them hold the truth.
struct Coverage {
  int held = 0, intervals = 0;
  void add(bool holds) {
    held += holds ? 1 : 0;
    ++intervals;
  }
  [[nodiscard]] bool is_binomial() const { return calibration::is_binomial(held, intervals); }
};

/// Adds what no sensor shows, at one random instant each after the first quarter; the names of what its band does not
/// hold. Before a stop is touched that alone is unknown, a motion from rest is known exactly, to what both integrations
/// leave: 3e-5 of its root mean square.
inline std::string add_unmeasured(const EstimateResult& found, const RandomRecord& given, int seed,
                                  Coverage& coverage) {
  std::mt19937_64 generator(static_cast<std::uint64_t>(seed) + 55);
  std::string missed;
  for (const auto& [output, truth] : given.unmeasured) {
    const auto k = std::uniform_int_distribution<Eigen::Index>(truth.size() / 4, truth.size() - 1)(generator);
    const auto& estimated = found.output(output.name);
    const double size = truth.norm() / std::sqrt(static_cast<double>(truth.size()));
    const double error = estimated.mean[k] - truth[k];
    const bool holds = std::abs(error) <= 1.96 * estimated.std[k] + 3e-5 * size;
    coverage.add(holds);
    if (!holds)
      missed += fmt::format("; {} {:+.1f} deviations, {:.1g} of its size", output.name, error / estimated.std[k],
                            std::abs(error) / size);
  }
  return missed;
}

/// The codes of its reasons with their weights, worst first.
inline std::string codes_of(const Verdict& verdict) {
  std::string text;
  for (const auto& reason : verdict.reasons()) text += fmt::format(" {} ({:.2g})", reason.code, reason.weight);
  return text;
}

}  // namespace kalfem::calibration
