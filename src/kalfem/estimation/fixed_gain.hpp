// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "kalfem/estimation/augmented_model.hpp"
#include "kalfem/system/sensors/output_map.hpp"

namespace kalfem {

struct FilterInput;

/// Gains of a filter over a record in physical coordinates, K_k [state/output], n x l, one a sample; 0 for a channel
/// that was missing. None is left out: the gain of an unknown parameter is about P_theta (dy/dtheta)^T R^-1, in
/// proportion to the sensitivity of the outputs to it at that instant. It changes its sign with the motion, so that a
/// gain that is held over even a part of a period moves the parameter in a wrong direction.
using Gains = std::vector<Eigen::MatrixXd>;

/// Means of a fixed-gain run.
struct FixedGainMeans {
  Eigen::MatrixXd monitored;       ///< rows x samples
  Eigen::MatrixXd innovation;      ///< y_k - h(x-), channels x samples; 0 where a channel was missing
  Eigen::MatrixXd unknowns;        ///< unknown parameters in the filter's state, unknowns x samples
  Eigen::VectorXd state = {};      ///< augmented state at the requested sample
  Eigen::MatrixXd predicted = {};  ///< h(x-), channels x samples
  Eigen::VectorXd largest = {};    ///< of the process model's nonlinear arguments along the run, |w|
};

/// Runs the mean of an augmented model over a record with gains that are given, one a sample,
///     x- = f(x+),   x+ = x- + K_k (y_k - h(x-)),
/// with the maps at the mean in the place of their means over sigma points: no covariance, so a step costs a seventh of
/// a filter's with 24 states. It tells how estimates move with the model when the gains are held: the difference of two
/// such runs with the same gains. `augmented model` is in physical coordinates. Nothing where a connector force cannot
/// be evaluated.
std::optional<FixedGainMeans> run_with_gains(const AugmentedModel& augmented_model, const FilterInput& input,
                                             const Gains& gains, const OutputMap& monitored, Eigen::Index state_at);

}  // namespace kalfem
