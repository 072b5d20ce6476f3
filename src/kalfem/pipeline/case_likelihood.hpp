#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/sampling/posterior.hpp"

namespace kalfem {

/// The likelihood of the parameters that a case infers.
struct CaseLikelihood {
  std::vector<std::string> names;
  LogLikelihood log_likelihood;
  /// Fisher information at theta [1/(unit_i unit_j)]; empty where it cannot be computed.
  std::function<std::optional<Eigen::MatrixXd>(const Eigen::VectorXd& theta)> information;
  std::string words;  ///< what it is made of
};

/// Of the simulated or the measured record (`study.problem` is there), or of the updating's comparisons. Throws
/// InvalidInput where it cannot be made at the parameters' start.
CaseLikelihood likelihood_of(const Study& study, const StudyResults& results);

/// The same of a record that is given, under the study's excitation.
CaseLikelihood likelihood_of(const Study& study, const Record& record);

/// Names of the plan's parameters, and where their search starts.
std::vector<std::string> names_of(const InferencePlan& plan);
Eigen::VectorXd start_of(const InferencePlan& plan);

}  // namespace kalfem
