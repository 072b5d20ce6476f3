// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>

#include "casefile/blow_records.hpp"
#include "casefile/case_run.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/steps/updating/outcome.hpp"
#include "kalfem/study/study.hpp"
#include "kalfem/updating/parameter_interval.hpp"

/// Damping that a case identifies from a record of a random chain, against the truth.
namespace kalfem::test {

struct DampingTrial {
  double truth = 0.0, found = 0.0;
  double lower = 0.0, upper = 0.0;  ///< of the 95 % interval; both 0: there is none
  bool consistent = false;          ///< but for correlated stiffnesses, as a chain struck at one end may have
  std::string words;                ///< structure, record and verdict

  [[nodiscard]] bool covered() const { return lower <= truth && truth <= upper; }
  [[nodiscard]] double half_width() const { return 0.5 * (upper - lower) / truth; }
};

/// Runs the update of a case from text; the last parameter is the damping.
inline DampingTrial damping_of(const std::string& text, double truth) {
  const Study study = study_of(text);
  const StudyResults results = run_study(study, "update");
  DampingTrial trial{.truth = truth};
  if (!results.has<UpdatingOutcome>() || !results.complete()) {
    trial.words = results.failure;
    return trial;
  }
  const auto& outcome = results.get<UpdatingOutcome>();
  const Eigen::Index last = outcome.values.size() - 1;
  trial.found = outcome.values[last];
  const auto interval =
      parameter_interval(study.updating->parameters.back(), last, trial.found, outcome.statistics, outcome.robust);
  if (interval) trial.lower = interval->lower, trial.upper = interval->upper;
  trial.consistent = std::ranges::all_of(results.verdict.reasons(), [](const Reason& reason) {
    return reason.code == "correlated" || reason.code == "combination";
  });
  for (const auto& reason : results.verdict.reasons()) trial.words += reason.code + " ";
  return trial;
}

/// Two to six masses, damping of .3 to 3 %, noise of 1 to 5 %, 40 to 120 s; accelerations or displacements. White
/// forces act before the record starts, too.
inline DampingTrial damping_trial(BlowTest::Force force, std::uint64_t seed, const ScratchFolder& folder) {
  RandomStream random(seed, "structure");
  const auto between = [&](double low, double high) { return low + (high - low) * random.uniform(); };
  const auto n = 2 + static_cast<Eigen::Index>(5.0 * random.uniform());
  BlowChain chain{Eigen::VectorXd(n), Eigen::VectorXd(n), std::exp(between(std::log(0.003), std::log(0.03))), 0};
  std::vector<double> wrong;
  for (Eigen::Index i = 0; i < n; ++i) {
    chain.masses[i] = between(3.0, 8.0);
    chain.stiffnesses[i] = between(20e3, 80e3);
    wrong.push_back(between(0.93, 1.07));
  }
  const BlowTest test{.force = force,
                      .duration = between(40.0, 120.0),
                      .noise = between(0.01, 0.05),
                      .derivative = seed % 2 == 0 ? 2 : 0,
                      .from_rest = force == BlowTest::Force::blows};
  const std::string file = (folder / ("record" + std::to_string(seed) + ".csv")).string();
  write_csv(file, record_of(chain, test, seed));
  const std::string quantity = test.derivative == 0 ? "      quantity: displacement\n" : "";
  DampingTrial trial = damping_of(blow_case(chain, {file}, wrong, quantity), chain.ratio);
  trial.words += std::to_string(n) + " masses, " + std::to_string(test.duration) + " s, noise " +
                 std::to_string(test.noise) + (quantity.empty() ? ", accelerations" : ", displacements");
  std::filesystem::remove(file);
  return trial;
}

}  // namespace kalfem::test
