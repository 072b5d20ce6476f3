// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/candidate_information.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/base/parallel.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/identification/channel_sensitivities.hpp"
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
  const auto absent = [&](const std::string& sensor) {
    return std::ranges::find(own->sensors, sensor, &Sensor::name) == own->sensors.end();
  };
  std::erase_if(own->offsets, [&](const auto& each) { return absent(each.sensor); });
  for (auto& unknown : own->settings.likelihood_unknowns) std::erase_if(unknown.sensors, absent);
  std::erase_if(own->settings.likelihood_unknowns, [](const auto& each) {
    return each.sensors.empty() && each.kind != LikelihoodUnknownKind::process_noise;
  });
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
