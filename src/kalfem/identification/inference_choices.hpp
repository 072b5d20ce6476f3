// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kalfem {

/// What the likelihood of parameters is made of.
enum class LikelihoodKind {
  filter,       ///< of the record by the filter: states and process noise are integrated out
  simulation,   ///< of the record against an open-loop simulation with correlated model error
  comparisons,  ///< of the comparisons of an updating
};

/// How a posterior is computed.
enum class PosteriorMethod {
  filter,      ///< the filter's normal distribution at the record's end, parameters in its state
  laplace,     ///< normal distribution about the maximum
  importance,  ///< importance samples about the maximum
  tempered,    ///< from the prior to the posterior by tempering
  metropolis,  ///< adaptive Markov chains
};

}  // namespace kalfem
