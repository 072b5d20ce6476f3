// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/online_problem.hpp"

#include <algorithm>

#include "kalfem/api/filter_problem.hpp"
#include "kalfem/api/structure_description.hpp"
#include "kalfem/system/signals/sampled.hpp"

namespace kalfem {

using Eigen::VectorXd;

namespace {

void require_online(const Structure& structure, const EstimateOptions& options) {
  IssueList issues;
  const auto& parts = structure.description().parts;
  const auto& signals = structure.description().signals;
  const auto& by_velocity = structure.description().by_velocity;
  for (std::size_t i = 0; i < signals.size(); ++i)
    if (!signals[i] && std::ranges::find(by_velocity, parts.inputs[i].name) != by_velocity.end())
      issues.add({}, "input '" + parts.inputs[i].name + "' is given by its velocity sample by sample",
                 "its displacement would drift with the offset of the velocity, which only a whole record tells",
                 "integrate it behind a high-pass, and give a base_displacement");
  const auto refuse = [&](bool given, const char* name) {
    if (given)
      issues.add({}, std::string(name) + " needs a whole record", "an OnlineFilter does not know what follows",
                 "use estimate()");
  };
  refuse(options.initial_state_from_record, "initial_state_from_record");
  refuse(options.passes > 1, "passes");
  refuse(!options.known_to.empty(), "known_to");
  refuse(options.adaptive_noise.sensors || options.adaptive_noise.process, "adaptive_noise");
  refuse(options.free != FreeNumbers::ask, "free");
  refuse(options.settle.has_value(), "settle");
  refuse_measurement_unknowns(options.unknowns, issues);
  issues.raise();
}

/// Zero at all times, instead of a signal whose values come online.
SignalPtr silence() {
  return make_sampled(VectorXd::Zero(2), {.interpolation = Interpolation::linear, .beyond = BeyondRecord::hold});
}

/// The structure with a signal for every input, so that its model can be made.
Structure with_signals(const Structure& structure) {
  auto description = structure.description();
  for (auto& signal : description.signals)
    if (!signal) signal = silence();
  return Structure(description);
}

/// With substeps where none are given: on hours of samples, forces at four instants leave a bias of a few standard
/// deviations.
EstimateOptions with_substeps(const EstimateOptions& options) {
  EstimateOptions online = options;
  if (!online.substeps) online.substeps = online.step_order == 4 ? 4 : 8;
  return online;
}

}  // namespace

FilterProblem online_problem(const Structure& structure, double sample_rate, const EstimateOptions& options) {
  require_online(structure, options);
  return make_filter_problem(with_signals(structure), sample_rate, with_substeps(options));
}

std::vector<OnlineInput> online_inputs(const Structure& structure) {
  std::vector<OnlineInput> inputs;
  const auto& description = structure.description();
  for (std::size_t i = 0; i < description.signals.size(); ++i) {
    const auto& input = description.parts.inputs[i];
    inputs.push_back({input.name, input.kind == InputKind::base_displacement, description.signals[i]});
  }
  return inputs;
}

}  // namespace kalfem
