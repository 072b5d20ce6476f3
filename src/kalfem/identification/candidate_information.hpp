// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/identification/fisher_information.hpp"

namespace kalfem {

/// A sensor that could be mounted: one channel, or several that stand or fall together.
struct CandidateSensor {
  std::string name;
  std::vector<Sensor> channels;
};

/// The problem with these sensors in place of its own; what is unknown of sensors that are not among them is dropped.
EstimationProblemPtr with_sensors(const EstimationProblem& problem, const std::vector<CandidateSensor>& set);

/// (a) Information of each candidate alone from the sensitivities of noise-free outputs y along the expected
/// excitation,
///     I_c = sum_channels sum_k (dy_k/di) (dy_k/dj) / sigma^2,
/// by central differences of simulations from rest in one time step, two a parameter whatever the number of candidates.
/// It adds up over candidates [1/(unit_i unit_j)]. `drive`: its time is simulated; the excitation is the structure's.
/// `names`: of the problem's unknowns. A noise that is relative to the channel is that of the noise-free channel at
/// theta; a channel that does not move then informs of nothing: one whose rms is below a millionth (120 dB) of the
/// largest of its unit, which is rounding. It holds channels x samples x parameters numbers. Empty where a simulation
/// fails. The relative step is shorter than that of filter passes: the phase of a lightly damped
/// response turns by tens of radians per change of a stiffness by itself, and over 1e-3 the error of the differences
/// looks like information on a direction that has none. Throws InvalidInput where an excitation or a name is unknown, a
/// candidate has no channel or a channel no noise, or a value has no scale.
///
/// Equal to (b) where the inputs are known, there is no process noise, the start is known and sensors' noise does not
/// depend on the parameters: then nothing is integrated out. Otherwise an upper bound of it.
std::optional<std::vector<Eigen::MatrixXd>> candidate_information(
    const EstimationProblemPtr& problem, const Record& drive, const std::vector<CandidateSensor>& candidates,
    const std::vector<std::string>& names, const Eigen::VectorXd& theta,
    const FisherInformationOptions& options = {.relative_step = 1e-4});

/// (b) Information of a set of candidates with the states integrated out: fisher_information() on the expected record
/// of the problem with these sensors in place of its own. Empty where a run fails.
std::optional<Eigen::MatrixXd> set_information(const EstimationProblemPtr& problem, const Record& drive,
                                               const std::vector<CandidateSensor>& set,
                                               const std::vector<std::string>& names, const Eigen::VectorXd& theta,
                                               const FisherInformationOptions& options = {});

}  // namespace kalfem
