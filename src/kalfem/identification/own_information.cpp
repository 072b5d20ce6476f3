// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/own_information.hpp"

#include <algorithm>

#include "kalfem/base/parallel.hpp"
#include "kalfem/identification/channel_sensitivities.hpp"
#include "kalfem/identification/expected_record.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::optional<OwnInformation> own_information(const EstimationProblemPtr& problem, const Record& drive,
                                              const FisherInformationOptions& options) {
  OwnInformation own;
  std::vector<std::string> names;
  std::vector<double> initial;
  for (const auto& unknown : problem->settings.unknowns) {
    if (unknown.random_walk > 0.0) continue;
    names.push_back(unknown.name);
    initial.push_back(unknown.initial);
    own.parameters.push_back({unknown.name, unknown.initial, unknown.deviation});
  }
  IssueList issues;
  check_excitation_is_known(*problem, issues);
  const VectorXd theta = VectorXd::Map(initial.data(), std::ssize(initial));
  auto bindings = bindings_of_unknowns(*problem, names, issues);
  const VectorXd step = difference_steps(names, theta, options, issues);
  issues.raise();
  ChannelSimulation simulation(*problem, drive, problem->sensors, std::move(bindings), theta);
  const auto size = simulation.start(problem->structure, theta);
  const auto here = size ? simulation.outputs(theta) : std::nullopt;
  auto derivatives = here ? sensitivities(simulation, theta, step, options.threads > 0 ? options.threads : processors())
                          : std::nullopt;
  if (!derivatives) return std::nullopt;
  for (const auto& unknown : problem->settings.likelihood_unknowns) {
    const auto is_of = [&](const Sensor& sensor) { return unknown.is_of(sensor.name); };
    if (unknown.kind != LikelihoodUnknownKind::sensor_gain || std::ranges::none_of(problem->sensors, is_of)) continue;
    own.parameters.push_back({unknown.name, unknown.initial, unknown.deviation});
    derivatives->push_back(MatrixXd::Zero(here->rows(), here->cols()));
    for (std::size_t j = 0; j < problem->sensors.size(); ++j) {
      const auto row = static_cast<Index>(j);
      if (is_of(problem->sensors[j])) derivatives->back().row(row) = here->row(row) / unknown.initial;
    }
  }
  if (own.parameters.empty()) return std::nullopt;
  own.information = MatrixXd::Zero(std::ssize(own.parameters), std::ssize(own.parameters));
  const auto moves = moving(problem->sensors, *size);
  for (std::size_t j = 0; j < problem->sensors.size(); ++j) {
    const auto channel = static_cast<Index>(j);
    const double deviation = problem->sensors[j].deviation((*size)[channel]);
    if (moves[j] && deviation > 0.0) own.information += channel_information(*derivatives, channel, deviation);
  }
  return own;
}

}  // namespace kalfem
