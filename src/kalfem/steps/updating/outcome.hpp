// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/updating/considered.hpp"
#include "kalfem/updating/first_information.hpp"
#include "kalfem/updating/gauss_newton.hpp"
#include "kalfem/updating/modal_residual.hpp"
#include "kalfem/updating/parameter_statistics.hpp"
#include "kalfem/updating/robust_statistics.hpp"
#include "kalfem/updating/sensitivity_check.hpp"

namespace kalfem {

/// One evaluation of an updating.
struct UpdatingStep {
  bool accepted = false;
  Eigen::VectorXd tried;       ///< parameters
  Eigen::VectorXd parameters;  ///< last accepted ones
  double residual = 0.0;       ///< rms of the weighted residual there
  double seconds = 0.0;
};

/// A point at which searches from several starts ended.
struct FoundMinimum {
  Eigen::VectorXd parameters;
  double residual = 0.0;  ///< rms of the weighted residual
  double cost = 0.0;      ///< half the sum of squares, with the priors' share: the lowest one is the result
  int reached = 0;        ///< by so many starts
  bool converged = false;
};

/// One frequency response, measured and of the model with its best factor.
struct FrfCurve {
  std::string name;                          ///< "2 per force at 1"
  std::string quantity, unit;                ///< "acceleration", "(m/s^2)/N"
  Eigen::VectorXd lines;                     ///< [Hz]
  Eigen::VectorXcd measured, before, after;  ///< H
  bool magnitudes_only = false;              ///< the measured one has no phases
  Eigen::VectorXd coherence;                 ///< of the measurement; empty: not known
  std::optional<double> scale;               ///< best factor on the updated model, if it is free
};

/// A comparison before and after the updating.
struct ComparisonResult {
  std::string name, kind;
  double weight = 1.0;
  Eigen::Index size = 0;
  double rms_initial = 0.0, rms_final = 0.0;           ///< of the residual, in standard deviations
  bool has_bounds = false;                             ///< these are upper bounds of the noise, see has_bounds()
  std::string derivatives;                             ///< of a driven record: which ones, and why
  std::vector<FrfCurve> responses;                     ///< of frequency responses
  std::vector<PairedMode> modes_initial, modes_final;  ///< of natural frequencies
  Eigen::MatrixXd mac_initial, mac_final;              ///< measured x the model's elastic modes
};

struct AlternativeOutcome;

struct UpdatingOutcome {
  std::string method;  ///< name of the method, in words
  std::vector<ComparisonResult> comparisons;
  FirstInformation first;  ///< what the comparisons tell at the initial values
  Eigen::VectorXd values;  ///< one per parameter
  ParameterStatistics statistics;
  RobustStatistics robust;
  std::optional<Considered> considered;  ///< what stated fixed numbers add; nothing where nothing is stated
  std::vector<std::string> remarks;      ///< parameters that the data cannot identify, one sentence each
  std::optional<Termination> end;        ///< of the least-squares search; nothing if there was none
  std::string termination;               ///< why it stopped, in words
  bool converged = false;
  double residual_initial = 0.0, residual_final = 0.0;  ///< rms of the weighted residual
  int evaluations = 0, iterations = 0;
  int resumed_at = 0;  ///< evaluations that an earlier run had made
  std::vector<UpdatingStep> trace;
  std::vector<FoundMinimum> minima;                  ///< of several starts, lowest cost first; otherwise empty
  std::vector<SensitivityComparison> sensitivities;  ///< if the case asks for them
  Eigen::VectorXd unknowns_before;               ///< last estimates of the filter before the updating; empty: no filter
  std::optional<double> log_evidence;            ///< log_evidence(), where all parameters have priors
  double weight = 1.0;                           ///< of this choice of parameters among the alternatives
  std::vector<AlternativeOutcome> alternatives;  ///< with other parameters; empty: none are given
  double seconds = 0.0;
};

/// The updating with other parameters.
struct AlternativeOutcome {
  std::shared_ptr<const AlternativeUpdating> plan;
  UpdatingOutcome outcome;
  std::string failure;  ///< why it has no numbers; empty: it has
};

}  // namespace kalfem
