// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/modal/rational_fraction.hpp"

namespace kalfem {

/// Poles and residues that fit FRFs best, with their covariance.
struct ModalModelFit {
  Eigen::VectorXcd poles;      ///< lambda [rad/s]
  Eigen::MatrixXcd residues;   ///< R of each pole in each FRF (an input's outputs after another's), in scaled units
  Eigen::MatrixXd covariance;  ///< of Re and Im of each pole in turn [(rad/s)^2]
  Eigen::VectorXd scatter;     ///< of the real and the imaginary part of each FRF about the fit where the weight is 1
  double correlation = 1.0;    ///< by which scatter that neighbouring lines share widens variances
  double degrees_of_freedom = 0.0;
  Eigen::VectorXd share;  ///< of the FRFs' power by each pole
  bool converged = false;
  /// (Phi^T Phi)^-1 of the linear unknowns, and their change by each pole's Re and Im: as rows of residues with real
  /// parts and imaginary ones in turn.
  Eigen::MatrixXd linear_covariance;
  std::vector<Eigen::MatrixXd> residue_slopes;
};

/// Least-squares fit of the modal model with a smooth rest
///     H_oi(omega) = sum_r [R_r / (i omega - lambda_r) + conj(R_r) / (i omega - conj(lambda_r))]
///                   + c_0 + c_1 omega + c_2 / omega^2
/// to all FRFs at once: residues and the complex rest of each FRF are linear, and the poles that all share are found by
/// variable projection with Kaufman's derivative [GP73, Kau75], Gauss-Newton steps that are shortened where they do not
/// help. FRFs count by the inverse of their scatter about the fit, lines by the given weights. Where errors of FRFs are
/// normal this is the maximum-likelihood estimate; it has no bias of the first order, unlike that of the fraction.
/// Covariances are those of least squares, times 1 + 2 sum_k rho_k with the correlations of residuals of neighbouring
/// lines (windows spread noise over a few).
ModalModelFit fit_modal_model(const FittedResponses& responses, const Eigen::VectorXcd& start);

}  // namespace kalfem
