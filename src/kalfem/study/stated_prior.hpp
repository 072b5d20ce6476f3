// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/casefile/inference_description.hpp"
#include "kalfem/sampling/marginal_prior.hpp"

namespace kalfem {

/// The prior that a case states of a parameter, in the parameter's unit. Throws InvalidInput with its place where a
/// number has another unit, a median is not positive, or bounds are in the wrong order.
MarginalPrior stated_prior(const Located<description::Prior>& given, const std::string& unit);

/// A value in its middle, and its spread about it: where a search starts [as the case writes them].
struct PriorCentre {
  description::Value value;
  description::Value spread;
};
PriorCentre centre_of(const Located<description::Prior>& given);

}  // namespace kalfem
