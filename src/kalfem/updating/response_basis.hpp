#pragma once

#include <vector>

#include "kalfem/model/parameterised_model.hpp"

namespace kalfem {

/// Which modes carry a response.
struct ResponseBasisOptions {
  Eigen::Index exact_up_to = 200;  ///< degrees of freedom; up to these all modes are taken and nothing is neglected
  double multiple = 3.0;           ///< of the highest line: larger models keep their modes below that frequency
};

/// Shapes V between which neither K nor M couples, V^T K V = diag(stiffness), V^T M V = diag(mass): normal modes, then
/// static shapes less their part in the modes, scaled to unit mass; shapes without mass have unit stiffness.
struct ResponseBasis {
  Eigen::MatrixXd shapes;     ///< n x r
  Eigen::VectorXd stiffness;  ///< r; 0: rigid body
  Eigen::VectorXd mass;       ///< r; 1 or 0
  Eigen::Index modes = 0;     ///< so many columns are modes, ascending

  [[nodiscard]] Eigen::Index size() const { return mass.size(); }
  /// Square root of stiffness over mass [rad/s]; 0 where a shape has no mass and so no rate of its own.
  [[nodiscard]] Eigen::VectorXd circular_frequencies() const;
};

/// Basis for the response up to `highest` [Hz] to loads, and at outputs, that are the columns of `places`, n x k. The
/// modes are completed by the static answers U = K^-1 places, by their inertia's K^-1 M U, so that an answer's error is
/// of the order of (highest / cut-off)^4, and by K^-1 C Phi for dashpots, which act where modes hardly strain. That
/// error is squared in H, not so in its derivatives, which are products of an answer to a load and one to an output at
/// the places of the parameters. Where K is singular, K + s M stands for it, see factor_stiffness().
/// Throws InvalidInput where K is indefinite.
ResponseBasis response_basis(const LinearModel& model, const Eigen::MatrixXd& places, double highest,
                             const ResponseBasisOptions& options);

/// V^T C_m V of damping by ratios, the static shapes taken as modes: diag(g_j) with the rates g_j = 2 zeta_j omega_j
/// [1/s]. Shapes above the ratios' limit have the rate of the last mode below it, see add_modal_damping(); where no
/// mode lies below it, nothing is damped.
Eigen::VectorXd modal_damping_rates(const ResponseBasis& basis, const ModalRatios& ratios);

/// Derivative of V^T C_m V, V held, when K, M and the ratios change; C_m = M Phi diag(g) Phi^T M follows with its modes
/// and their frequencies. With A = V^T dK V, B = V^T dM V and lambda = omega^2,
///     dC_jk = A_jk (g_j - g_k) / (lambda_j - lambda_k) + B_jk (g_k lambda_j - g_j lambda_k) / (lambda_j - lambda_k),
/// from the first-order change of eigenvectors [FK68]; where ratios are equal, and so also for repeated modes,
///     dC_jk = 2 zeta (A_jk + omega_j omega_k B_jk) / (omega_j + omega_k),
/// and dC_jk = g B_jk where both have the same rate g because they lie above the ratios' limit. To this come
/// diag(2 omega_j dzeta_j) and, above the limit, the change of the rate of the last mode below it,
/// dg_c = 2 omega_c dzeta_c + zeta_c (A_cc - lambda_c B_cc) / omega_c.
/// Exact where the basis holds all modes. Neglected: in a truncated basis the shares of modes beyond the static shapes;
/// modes with one frequency and different ratios, taken with the mean of these; and mass that a parameter gives to a
/// shape without mass.
Eigen::MatrixXd modal_damping_derivative(const ResponseBasis& basis, const ModalRatios& ratios,
                                         const std::vector<double>& ratio_derivatives,
                                         const Eigen::MatrixXd& stiffness_derivative,
                                         const Eigen::MatrixXd& mass_derivative);

}  // namespace kalfem
