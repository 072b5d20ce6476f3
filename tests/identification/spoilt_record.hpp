// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <limits>

#include "identification/chain_structure.hpp"

namespace kalfem::test {

/// What a sensor shows after it died.
enum class Spoilt { holds_zero, noise_only };

/// The chain with accelerometers of 15 % noise.
inline EstimationProblem spoilt_problem() {
  auto problem = chain_problem();
  for (auto& sensor : problem.sensors) sensor.noise = 0.15;
  problem.settings.settle = 1.0;
  problem.settings.substeps = 4;
  return problem;
}

/// A record of the chain with 1 % outliers of 20 deviations, the third sensor dead from 8 s on, 20 % of the samples
/// missing at random, and none at all from 5 to 6 s.
inline Record spoilt_chain_record(const EstimationProblem& problem, double duration, std::uint64_t seed,
                                  Spoilt spoilt) {
  Record record = chain_record(problem, duration, false);
  for (Eigen::Index i = 0; i < record.values.rows(); ++i) {
    RandomStream random(seed, "spoilt " + std::to_string(i));
    const double noise = record.channels[static_cast<std::size_t>(i)].noise;
    for (Eigen::Index k = 0; k < record.samples(); ++k) {
      double& value = record.values(i, k);
      value += noise * random.normal();
      const double outlier = random.uniform(), side = random.uniform(), missing = random.uniform();
      if (outlier < 0.01) value += (side < 0.5 ? -20.0 : 20.0) * noise;
      if (i == 2 && record.time(k) >= 8.0) value = spoilt == Spoilt::holds_zero ? 0.0 : noise * random.normal();
      if (missing < 0.2) value = std::numeric_limits<double>::quiet_NaN();
    }
  }
  for (Eigen::Index k = 0; k < record.samples(); ++k)
    if (record.time(k) >= 5.0 - 1e-9 && record.time(k) < 6.0 - 1e-9)
      record.values.col(k).setConstant(std::numeric_limits<double>::quiet_NaN());
  return record;
}

}  // namespace kalfem::test
