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
  bool has_bounds = false;             ///< its deviations are upper bounds, see has_bounds()
  std::vector<PairedMode> modes = {};  ///< of natural frequencies
};

/// Whether the deviations of a comparison are upper bounds of the noise, which say nothing where a residual is smaller:
/// those of a filter's innovations hold the model that was not yet updated, those of measured spectra what a force may
/// do between its samples.
bool has_bounds(const Residual& residual);

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
