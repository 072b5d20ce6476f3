// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/estimation_problem.hpp"
#include "kalfem/sampling/marginal_prior.hpp"

namespace kalfem {

/// The distribution of an unknown before the data: normal, of a positive one log-normal about its initial value, cut at
/// its bounds.
MarginalPrior prior_of(const Unknown& unknown);
/// The same of an unknown of the measurement: log-normal where it is positive and not of a clock.
MarginalPrior prior_of(const LikelihoodUnknown& unknown);

}  // namespace kalfem
