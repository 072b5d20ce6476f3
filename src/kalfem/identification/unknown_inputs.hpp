// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/identification/augmented_model_setup.hpp"

namespace kalfem {

/// Estimate of an unknown input after each sample.
struct EstimatedInput {
  UnknownInput input;
  Eigen::VectorXd mean, deviation;      ///< [unit of its process]
  Eigen::VectorXd truth = {};           ///< empty if not known
  std::optional<double> nrmse = {};     ///< against the truth, after settling
  std::optional<double> coverage = {};  ///< part of the samples after settling with the truth in the 95 % band

  /// Root mean square of the deviation from sample `first` on, over the stationary one; of a random walk over that of
  /// its changes in one second.
  [[nodiscard]] double shrinkage(Eigen::Index first) const;
};

/// Makes the unknown inputs states of the filter's model, which has one entry of `input_sources` per input by now. An
/// unknown input outside a local model is left out.
void treat_as_unknown(const std::vector<UnknownInput>& inputs, AugmentedModelSetup& setup);

/// Prior and white noise of the unknown inputs, once the model is coupled.
void set_noise_of_unknown_inputs(const std::vector<UnknownInput>& inputs, AugmentedModelSetup& setup);

/// Those of these inputs that the filter's model holds.
std::vector<UnknownInput> held_by(const std::vector<UnknownInput>& inputs, const AugmentedModelSetup& setup);

/// Adds the value of each of these inputs, or its acceleration where that is the process, to the outputs.
OutputMap with_inputs(OutputMap outputs, const std::vector<UnknownInput>& inputs, const CoupledModel& model);

/// What the sensors can tell of the unknown inputs by their frequency responses H, the structure as stiff as at rest.
struct InputObservability {
  std::vector<std::string> unseen;          ///< no sensor answers to it at any frequency
  bool separable = true;                    ///< those that are seen: H has full column rank at some frequency
  std::vector<std::string> unseen_if_slow;  ///< H vanishes towards frequency zero: only changes are seen
};
InputObservability observability_of(const std::vector<UnknownInput>& held, const AugmentedModelSetup& setup);

/// Problems of unknown inputs that no run can overcome: more inputs than sensors, an input that no sensor answers to,
/// inputs that act alike, and a process that is rougher than the derivatives through which the input acts.
void check_unknown_inputs(const std::vector<UnknownInput>& inputs, const AugmentedModelSetup& setup, IssueList& issues);

/// The highest derivative of this input that acts on the structure or on a sensor: 0 its value alone, 1 its rate too, 2
/// its acceleration too.
int highest_acting_derivative(const std::string& input, const AugmentedModelSetup& setup);

}  // namespace kalfem
