// SPDX-License-Identifier: Apache-2.0
#include "kalfem/inference/predictive_bands.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/base/parallel.hpp"
#include "kalfem/identification/expected_record.hpp"
#include "kalfem/sampling/importance_sampler.hpp"
#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Whether every unknown of the structure is inferred: a simulation needs a value of each.
bool infers_all(const InferenceProblem& problem) {
  const auto names = names_of(problem);
  return std::ranges::all_of(problem.problem->settings.unknowns, [&](const Unknown& unknown) {
    return std::ranges::find(names, unknown.name) != names.end();
  });
}

}  // namespace

bool can_be_simulated(const InferenceProblem& problem) {
  IssueList unknown;
  check_excitation_is_known(*problem.problem, unknown);
  return unknown.empty() && !problem.problem->settings.local && infers_all(problem);
}

namespace {

/// The responses that were simulated, one a draw.
std::vector<Record> responses(const InferenceProblem& problem, const Record& record, const SampleSet& draws) {
  const auto names = names_of(problem);
  std::vector<std::optional<Record>> all(static_cast<std::size_t>(draws.values.cols()));
  for_each_index(all.size(), problem.threads(), [&](std::size_t k) {
    all[k] = expected_record(problem.problem, record, names, draws.values.col(static_cast<Index>(k)));
  });
  std::vector<Record> found;
  for (auto& each : all)
    if (each) found.push_back(std::move(*each));
  return found;
}

PredictiveBand band_of(const std::vector<Record>& responses, const Record& record, const std::string& sensor) {
  const Index row = record.find(sensor), samples = record.samples_used();
  PredictiveBand band{.sensor = sensor, .start = record.start, .sample_rate = record.sample_rate};
  band.unit = record.channels[static_cast<std::size_t>(row)].unit;
  band.measured = record.values.row(row).head(samples).transpose();
  VectorXd sum = VectorXd::Zero(samples), squares = sum;
  double noise = 0.0;
  for (const auto& response : responses) {
    const VectorXd values = response.values.row(response.find(sensor)).head(samples).transpose();
    sum += values;
    squares += values.cwiseAbs2();
    noise = response.channels[static_cast<std::size_t>(response.find(sensor))].noise;
  }
  const double count = static_cast<double>(responses.size());
  band.mean = sum / count;
  const VectorXd spread =
      ((squares / count - band.mean.cwiseAbs2()).array().max(0.0) + noise * noise).sqrt() * normal_quantile(0.975);
  band.lower = band.mean - spread;
  band.upper = band.mean + spread;
  Index known = 0, inside = 0;
  for (Index k = 0; k < samples; ++k) {
    if (!std::isfinite(band.measured[k])) continue;
    ++known;
    if (band.lower[k] <= band.measured[k] && band.measured[k] <= band.upper[k]) ++inside;
  }
  band.coverage = known > 0 ? static_cast<double>(inside) / static_cast<double>(known) : 0.0;
  return band;
}

}  // namespace

std::vector<PredictiveBand> predictive_bands(const InferenceProblem& problem, const Record& record,
                                             const SampleSet& samples) {
  if (problem.predictions == 0 || !problem.problem || !can_be_simulated(problem)) return {};
  const auto found = responses(problem, record, resample(samples, problem.predictions, problem.seed));
  std::vector<PredictiveBand> bands;
  if (found.empty()) return bands;
  for (const auto& sensor : problem.problem->sensors)
    if (record.find(sensor.name) >= 0) bands.push_back(band_of(found, record, sensor.name));
  return bands;
}

}  // namespace kalfem
