// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/correlation/shape_expansion.hpp"

namespace kalfem {

/// A measured shape and those of a model at the same entries, both in deviations of the entries (see ShapeErrors).
struct MatchedShape {
  Eigen::VectorXd measured;  ///< L^-1 y
  Eigen::MatrixXd model;     ///< L^-1 P Phi, entries x modes
  Eigen::Index mode = 0;     ///< column of the mode that it is
};

/// tau / sqrt(tau^2 + g_j^2) with g_j = (lambda_i - lambda_j) / sqrt(lambda_i lambda_j): of two close modes almost 1,
/// as they may turn into any two directions of their plane; 1 of the mode itself.
Eigen::VectorXd mixing_deviations(const Eigen::VectorXd& frequencies, Eigen::Index mode, double stiffness_error);

/// The most likely tau and noise of all shapes, whose scales a are free, with priors that are wide: tau about 3 %
/// within a factor of 4.5, the noise about what is stated within a factor of 2.7. Needs a shape.
ModalMixing fit_modal_mixing(const std::vector<MatchedShape>& shapes, const Eigen::VectorXd& frequencies);

}  // namespace kalfem
