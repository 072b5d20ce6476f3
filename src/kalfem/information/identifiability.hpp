// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace kalfem {

/// A parameter whose information is judged.
struct InformedParameter {
  std::string name;
  double value = 0.0;            ///< at which the information holds [unit]
  double prior_deviation = 0.0;  ///< [unit]; infinity: no prior
};

struct IdentifiabilityOptions {
  double weak = 0.5;  ///< a combination is undetermined where the record leaves more than this of its prior deviation
  double significant = 0.1;      ///< share of a combination below which a parameter is not named, to its largest
  int largest_exponent = 3;      ///< numerator and denominator of exponents that are recognised
  double exponent_error = 0.05;  ///< of such an exponent
  std::string data = "record";   ///< that the information is of, in sentences
};

/// A direction in the scaled parameters q_i = (theta_i - value_i) / scale_i that the record informs independently of
/// the others: an eigenvector of the scaled information. Exponents e_i of a determined one: it is the product
/// prod_i theta_i^e_i; of another: the record does not tell theta_i from theta_i c^e_i for a factor c.
struct ParameterCombination {
  Eigen::VectorXd direction;         ///< one per parameter, of unit length
  double deviation = 0.0;            ///< by the record alone, along the direction, in scales; infinity: not informed
  double posterior_deviation = 0.0;  ///< with the prior; infinity without both
  bool determined = false;           ///< by the record
  std::vector<double> exponents;     ///< see below; empty: not simple ratios
  std::string words;                 ///< one sentence
};

/// What an information matrix says of its parameters.
struct Identifiability {
  std::vector<InformedParameter> parameters;
  Eigen::VectorXd scale;                ///< prior deviation, or |value| without a prior [unit]
  Eigen::VectorXd cramer_rao;           ///< smallest deviation of an unbiased estimate [unit]; infinity: not determined
  Eigen::VectorXd posterior_deviation;  ///< with the prior [unit]
  Eigen::MatrixXd posterior_correlation;
  std::vector<ParameterCombination> combinations;  ///< the best determined first
  std::string text;                                ///< words of all that are not determined; or that every parameter is
};

/// Judges an information matrix [1/(unit_i unit_j)]. Throws InvalidInput where sizes do not fit, a number is not
/// finite, the matrix is not symmetric and positive semidefinite to rounding, or a value without a prior is zero.
Identifiability identifiability(const Eigen::MatrixXd& information, const std::vector<InformedParameter>& parameters,
                                const IdentifiabilityOptions& options = {});

}  // namespace kalfem
