// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/estimate.hpp"

namespace kalfem {

/// In standard deviations of the last pass, whose bias lies within.
inline constexpr double narrow_prior_breadth = 5.0;

/// The prior of a further pass over the record: the constant unknowns at the last pass's estimates, within
/// narrow_prior_breadth of their deviations there, all else as stated. A filter spreads its sigma points as far as the
/// prior does; about a wide one it learns its first samples through another model than the one that it ends with, and
/// never forgets. A random walk, an unknown whose prior is correlated with the motion, and one that the record says
/// little of keep their own.
Gaussian narrow_prior(const AugmentedModel& augmented_model, const EstimationResult& last);

/// Puts the stated prior N(m, P) of the constants in the place of the narrow one N(m', P') that the pass began with.
/// The record's information is what the pass added, G_k = P_k^-1 - P'^-1, so that after sample k
///     P_k <- (G_k + P^-1)^-1,    theta_k <- m' + P_k (P_k'^-1 (theta_k' - m') + P^-1 (m - m')),
/// with the same for the whole final state and for the likelihood of the record, in which the narrow prior must not
/// count: exact where the constants enter linearly over the narrow prior. The motion in between stays as it is.
void put_back(const Gaussian& stated, const AugmentedModel& augmented_model, EstimationResult& result);

}  // namespace kalfem
