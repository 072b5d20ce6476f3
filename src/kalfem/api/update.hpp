// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/api/structure.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// A natural frequency that was measured.
struct MeasuredFrequency {
  double frequency = 0.0;        ///< [Hz]
  double std = 0.0;              ///< its standard deviation [Hz]
  std::optional<int> mode = {};  ///< number of the model's mode at the initial values, from 1; if empty, by order
};

/// A parameter to refine: {"frame.steel.youngs_modulus", {.initial = 200e9}}.
struct RefinedParameter {
  std::string name;
  struct Range {
    std::optional<double> initial = {};  ///< if empty, the structure's own value
    std::optional<double> std = {};      ///< of the prior about `initial`; if empty, there is no prior
    double lower = 0.0;
    double upper = std::numeric_limits<double>::infinity();
  } range = {};
};

struct UpdateOptions {
  std::string substructure;  ///< whose modes were measured
  std::vector<MeasuredFrequency> frequencies;
  std::vector<RefinedParameter> parameters;
  double above = 0.0;  ///< modes up to this frequency are not elastic ones [Hz]
  int max_evaluations = 100;
};

/// A measured frequency beside the model's.
struct FrequencyComparison {
  double measured = 0.0, before = 0.0, after = 0.0;  ///< [Hz]
};

/// Result of an updating.
struct UpdateResult {
  struct Parameter {
    std::string name, unit;
    double initial = 0.0, value = 0.0;
    double std = 0.0;  ///< infinite if neither frequencies nor prior determine it, not a number at a bound
    /// From the scatter of the frequencies' residuals; not a number if none is left or `std` is none. With a right
    /// model it is about `std`.
    double std_robust = std::numeric_limits<double>::quiet_NaN();
    /// From the deviation whose interval is the wider one, cut at the bounds; not a number if `std` is none.
    struct Interval {
      double lower = std::numeric_limits<double>::quiet_NaN(), upper = lower;
    } interval_95 = {};
  };
  std::vector<Parameter> parameters;
  std::vector<FrequencyComparison> frequencies;
  bool converged = false;
  std::string reason;  ///< why it ended, in words
  Verdict verdict;     ///< whether the numbers agree with each other and with what was stated about them

  /// Whether nothing in the numbers makes them worthless.
  [[nodiscard]] bool usable() const { return verdict.state() != VerdictState::unusable; }
};

/// Refines parameters of a substructure by natural frequencies: minimises
///     sum ((f_model - f_measured) / std)^2 + sum ((theta - initial) / std)^2
/// by a bounded Gauss-Newton method with exact derivatives. Throws InvalidInput with every argument that is wrong, by
/// its place; how the search ended is in the result.
UpdateResult update(const Structure& structure, const UpdateOptions& options);

}  // namespace kalfem
