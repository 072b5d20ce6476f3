// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/candidate_information.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "kalfem/base/parallel.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/identification/channel_simulation.hpp"
#include "kalfem/identification/expected_record.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/open_loop.hpp"
#include "kalfem/identification/parameterised_structure.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

std::vector<Sensor> channels_of(const std::vector<CandidateSensor>& candidates) {
  std::vector<Sensor> channels;
  for (const auto& candidate : candidates)
    channels.insert(channels.end(), candidate.channels.begin(), candidate.channels.end());
  return channels;
}

void check_noise(const std::vector<CandidateSensor>& candidates, IssueList& issues) {
  for (const auto& candidate : candidates) {
    if (candidate.channels.empty())
      issues.add({}, "the candidate '" + candidate.name + "' has no channel", "it would measure nothing",
                 "give it a channel, or remove it");
    for (const auto& channel : candidate.channels)
      if (!(channel.noise > 0.0) || !std::isfinite(channel.noise))
        issues.add(channel.location,
                   "the candidate '" + candidate.name + "' has a channel with the noise " + shortest(channel.noise),
                   "its information is relative to its noise", "give it a positive noise");
  }
}

/// dy/dtheta_i, channels x samples, one a parameter.
std::optional<std::vector<MatrixXd>> sensitivities(const ChannelSimulation& simulation, const VectorXd& theta,
                                                   const VectorXd& step, int threads) {
  std::vector<MatrixXd> derivatives(static_cast<std::size_t>(theta.size()));
  std::vector<char> failed(derivatives.size(), 0);
  for_each_index(derivatives.size(), threads, [&](std::size_t i) {
    VectorXd above = theta, below = theta;
    above[static_cast<Index>(i)] += step[static_cast<Index>(i)];
    below[static_cast<Index>(i)] -= step[static_cast<Index>(i)];
    auto right = simulation.outputs(above);
    const auto left = right ? simulation.outputs(below) : std::nullopt;
    failed[i] = left ? 0 : 1;
    if (left) derivatives[i] = (*right - *left) / (above - below)[static_cast<Index>(i)];
  });
  if (std::ranges::count(failed, 1) > 0) return std::nullopt;
  return derivatives;
}

/// Which channels move by more than rounding: sizes are compared among channels of one unit.
std::vector<char> moving(const std::vector<Sensor>& channels, const VectorXd& size) {
  constexpr double smallest_part = 1e-6;
  std::map<std::string, double> largest;
  for (std::size_t j = 0; j < channels.size(); ++j) {
    double& most = largest[channels[j].unit];
    most = std::max(most, size[static_cast<Index>(j)]);
  }
  std::vector<char> moves;
  for (std::size_t j = 0; j < channels.size(); ++j)
    moves.push_back(size[static_cast<Index>(j)] > smallest_part * largest[channels[j].unit]);
  return moves;
}

/// sum_k (dy_k/di) (dy_k/dj) / sigma^2 of a channel.
MatrixXd channel_information(const std::vector<MatrixXd>& derivatives, Index channel, double deviation) {
  MatrixXd rows(static_cast<Index>(derivatives.size()), derivatives.front().cols());
  for (Index i = 0; i < rows.rows(); ++i) rows.row(i) = derivatives[static_cast<std::size_t>(i)].row(channel);
  return rows * rows.transpose() / (deviation * deviation);
}

}  // namespace

std::optional<std::vector<MatrixXd>> candidate_information(const EstimationProblemPtr& problem, const Record& drive,
                                                           const std::vector<CandidateSensor>& candidates,
                                                           const std::vector<std::string>& names, const VectorXd& theta,
                                                           const FisherInformationOptions& options) {
  IssueList issues;
  check_excitation_is_known(*problem, issues);
  check_noise(candidates, issues);
  auto bindings = bindings_of_unknowns(*problem, names, issues);
  const VectorXd step = difference_steps(names, theta, options, issues);
  issues.raise();
  const auto channels = channels_of(candidates);
  ChannelSimulation simulation(*problem, drive, channels, std::move(bindings), theta);
  const auto size = simulation.start(problem->structure, theta);
  if (!size) return std::nullopt;
  const auto derivatives = sensitivities(simulation, theta, step, options.threads > 0 ? options.threads : processors());
  if (!derivatives) return std::nullopt;
  std::vector<MatrixXd> information;
  const auto moves = moving(channels, *size);
  Index channel = 0;
  for (const auto& candidate : candidates) {
    MatrixXd sum = MatrixXd::Zero(theta.size(), theta.size());
    for (const auto& each : candidate.channels) {
      const double deviation = each.deviation((*size)[channel]);
      if (moves[static_cast<std::size_t>(channel)] && deviation > 0.0)
        sum += channel_information(*derivatives, channel, deviation);
      ++channel;
    }
    information.push_back(std::move(sum));
  }
  return information;
}

EstimationProblemPtr with_sensors(const EstimationProblem& problem, const std::vector<CandidateSensor>& set) {
  auto own = std::make_shared<EstimationProblem>(problem);
  own->sensors = channels_of(set);
  const auto absent = [&](const auto& each) {
    return !each.sensor.empty() && std::ranges::find(own->sensors, each.sensor, &Sensor::name) == own->sensors.end();
  };
  std::erase_if(own->offsets, absent);
  std::erase_if(own->settings.likelihood_unknowns, absent);
  return own;
}

std::optional<MatrixXd> set_information(const EstimationProblemPtr& problem, const Record& drive,
                                        const std::vector<CandidateSensor>& set, const std::vector<std::string>& names,
                                        const VectorXd& theta, const FisherInformationOptions& options) {
  IssueList issues;
  check_noise(set, issues);
  if (set.empty()) issues.add({}, "the set of sensors is empty", "it would measure nothing", "give it a candidate");
  issues.raise();
  const auto own = with_sensors(*problem, set);
  const auto record = expected_record(own, drive, names, theta);
  if (!record) return std::nullopt;
  return fisher_information(FilterLikelihood(own, *record, names, {.first = theta}), theta, options);
}

}  // namespace kalfem
