// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// A comparison of a model with measurements, as an updating left it.
struct ComparedMeasurement {
  std::string name;
  double rms = 1.0;                 ///< of the residual, in its stated standard deviations
  double degrees_of_freedom = 0.0;  ///< values less the parameters' share of them
  bool has_bounds = false;          ///< its deviations are upper bounds of the noise
  /// Pairs of a measured mode with nothing, or with a shape that hardly agrees: "12.3 Hz (MAC 0.4)".
  std::vector<std::string> poor_pairs;
};

/// A parameter at the end of an updating.
struct UpdatedValue {
  std::string name, unit;
  double initial = 0.0, value = 0.0;
  std::optional<double> prior_deviation;  ///< if it has a prior
  double widening = 1.0;                  ///< robust over stated standard deviation
  double widening_freedom = 0.0;          ///< degrees of freedom of the robust one
  bool at_bound = false;
  bool positive_by_nature = false;  ///< a stiffness, mass, thickness or modulus
};

/// An updating in the numbers that its verdict needs.
struct UpdatingRecord {
  bool converged = true;
  std::string termination;
  std::vector<ComparedMeasurement> comparisons;
  std::vector<UpdatedValue> parameters;
  /// Parameters of each combination, and of each pair of high correlation, that the data cannot tell apart.
  std::vector<std::vector<std::string>> not_told_apart;
  std::vector<std::string> not_identified;  ///< parameters whose value comes from the prior or the start
};

/// What contradicts an updating: a residual far from what was stated ("residual_large", "residual_small"), a search
/// that did not end at a minimum ("not_converged"), modes that pair with nothing or poorly ("poor_pairs"), parameters
/// at a bound ("at_bound"), beyond four prior deviations from their first guess ("far_from_prior"), below zero though
/// positive by nature ("unphysical_sign"), that the data do not determine ("not_identified") or cannot tell apart
/// ("correlated"), and, where a residual is large, deviations that are too small ("deviation_too_small"). A size counts
/// where it is both beyond chance by four standard deviations, with as many values as are independent, and beyond the
/// limits of state_of().
std::vector<Reason> updating_reasons(const UpdatingRecord& record);

}  // namespace kalfem
