// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/updating/modal_residual.hpp"
#include "kalfem/updating/parameter_statistics.hpp"
#include "kalfem/updating/robust_statistics.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// A comparison at the end of an updating.
struct EndOfComparison {
  std::string name;
  Eigen::Index size = 0;               ///< values that it compares
  double rms = 0.0;                    ///< of the residual, in its stated standard deviations
  bool predicted = false;              ///< its deviations come from a model that was not yet updated, not from noise
  std::vector<PairedMode> modes = {};  ///< of natural frequencies
};

/// An updating at its end.
struct EndOfUpdating {
  const std::vector<UpdatingParameter>& parameters;
  const Eigen::VectorXd& values;  ///< one per parameter
  const ParameterStatistics& statistics;
  const RobustStatistics& robust;
  std::vector<EndOfComparison> comparisons = {};
  bool converged = false;
  std::string termination = {};  ///< why the search stopped, in words
};

/// What contradicts it: its comparisons, its parameters and what the data determine of them.
std::vector<Reason> updating_reasons(const EndOfUpdating& updating);

}  // namespace kalfem
