// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>
#include <variant>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

/// N(mean, deviation^2), truncated to [lower, upper].
struct NormalPrior {
  double mean = 0.0;
  double deviation = 1.0;
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
};

/// ln theta ~ N(ln median, log_deviation^2), truncated to [lower, upper].
struct LogNormalPrior {
  double median = 1.0;
  double log_deviation = 1.0;
  double lower = 0.0;
  double upper = std::numeric_limits<double>::infinity();
};

/// Constant on [lower, upper].
struct UniformPrior {
  double lower = 0.0;
  double upper = 1.0;
};

using MarginalPrior = std::variant<NormalPrior, LogNormalPrior, UniformPrior>;

/// Where a parameter has prior density.
struct Support {
  double lower = 0.0;
  double upper = 0.0;
};

/// Of one marginal, truncation included. x = from_normal(w) is the value whose probability is that of the standard
/// normal w, found from the nearer tail: exact far out on both sides.
Support support(const MarginalPrior& marginal);
double log_density(const MarginalPrior& marginal, double x);  ///< normalised; -infinity outside the support
double from_normal(const MarginalPrior& marginal, double w);
double to_normal(const MarginalPrior& marginal, double x);  ///< within +-37, where double precision ends
double mean(const MarginalPrior& marginal);
double deviation(const MarginalPrior& marginal);

/// Adds what is wrong with the prior of the parameter `name`: deviations that are not positive, bounds in the wrong
/// order or without probability between them (under 1e-250), a uniform one without bounds.
void check(const std::string& name, const MarginalPrior& marginal, IssueList& issues);

}  // namespace kalfem
