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

/// (a) Information of each candidate alone from the sensitivities of noise-free outputs y along the expected
/// excitation,
///     I_c = sum_channels sum_k (dy_k/di) (dy_k/dj) / sigma^2,
/// by central differences of simulations, two a parameter whatever the number of candidates. It adds up over
/// candidates. Empty where a simulation fails.
///
/// Equal to (b) where the inputs are known, there is no process noise, the start is known and sensors' noise does not
/// depend on the parameters: then nothing is integrated out. Otherwise an upper bound of it.
std::optional<std::vector<Eigen::MatrixXd>> candidate_information(
    const EstimationProblemPtr& problem, const Record& drive, const std::vector<CandidateSensor>& candidates,
    const std::vector<std::string>& names, const Eigen::VectorXd& theta, const FisherInformationOptions& options = {});

/// (b) Information of a set of candidates with the states integrated out: fisher_information() on the expected record
/// of the problem with these sensors in place of its own. Empty where a run fails.
std::optional<Eigen::MatrixXd> set_information(const EstimationProblemPtr& problem, const Record& drive,
                                               const std::vector<CandidateSensor>& set,
                                               const std::vector<std::string>& names, const Eigen::VectorXd& theta,
                                               const FisherInformationOptions& options = {});

}  // namespace kalfem
