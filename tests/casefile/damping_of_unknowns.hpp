// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "base/places.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/simulation/outcome.hpp"
#include "kalfem/study/case_study.hpp"
#include "kalfem/yaml/case_reader.hpp"

/// The chain of the examples with unknown springs, masses and damping, from many first guesses and with many seeds.
namespace kalfem::test {

/// `text` with the first `from` in it changed to `to`; the text must hold it.
inline std::string with(std::string text, const std::string& from, const std::string& to) {
  const auto place = text.find(from);
  if (place == std::string::npos) throw std::logic_error("the case does not hold: " + from);
  return text.replace(place, from.size(), to);
}

/// The example without its prediction, with these unknowns beside the suspension's two.
inline std::string chain_case(const std::string& duration, const std::string& unknowns) {
  std::ostringstream file;
  file << std::ifstream(source_folder() + "/examples/chain/chain.yaml").rdbuf();
  std::string text = file.str();
  text.resize(text.find("predict:"));
  const std::string last = "    suspension.mu_c1: {initial: 16 N, std: 50 %}\n";
  return with(with(text, "duration: 20 s", "duration: " + duration), last, last + unknowns);
}

inline Study study_of(const std::string& text) {
  return make_study(read_case_text(text, "chain.yaml", description::case_schema()), "chain.yaml");
}

/// The record of the study with noise of another seed on it.
inline StudyResults record_with_noise(StudyResults simulated, std::uint64_t seed) {
  auto& outcome = simulated.get<SimulationOutcome>();
  for (std::size_t i = 0; i < outcome.measurements.channels.size(); ++i) {
    const auto& channel = outcome.measurements.channels[i];
    RandomStream random(seed, channel.name);
    auto row = outcome.measurements.values.row(static_cast<Eigen::Index>(i));
    row = outcome.reference.sensors.row(static_cast<Eigen::Index>(i));
    for (double& value : row) value += channel.noise * random.normal();
  }
  return simulated;
}

/// The last estimates of the unknowns.
struct LastEstimates {
  Eigen::VectorXd values, deviations;
  double nis = 0.0;
  int linearisations = 0;
};

inline LastEstimates estimates_of(const Study& study, const StudyResults& record) {
  const auto outcome = estimate_record(study.problem, *study.augmented_model, record_of(study, record));
  EXPECT_EQ(outcome.failure(), "");
  return {outcome.result.unknowns.mean.rightCols(1), outcome.result.unknowns.deviation.rightCols(1),
          outcome.consistency.mean_nis, outcome.result.linearisations};
}

inline Eigen::VectorXd truth_of(const Study& study) {
  Eigen::VectorXd truth(static_cast<Eigen::Index>(study.augmented_model->true_parameters.size()));
  for (Eigen::Index i = 0; i < truth.size(); ++i) truth[i] = *study.augmented_model->true_parameters[std::size_t(i)];
  return truth;
}

}  // namespace kalfem::test
