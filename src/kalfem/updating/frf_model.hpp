// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <complex>
#include <memory>
#include <vector>

#include "kalfem/model/parameterised_model.hpp"
#include "kalfem/updating/frf_set.hpp"

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

/// One line of a set's FRFs.
struct FrfLine {
  Eigen::VectorXcd values;       ///< H, one an output
  Eigen::MatrixXcd derivatives;  ///< dH/dtheta, outputs x parameters; 0 x 0 where not asked for
};

/// The FRFs of a model at one value of its parameters, in a basis V of response_basis():
///     H(s) = s^(q - p) S V Z^-1 V^T (f_0 + s f_1),  Z = V^T (K + s (C + C_m) + s^2 M) V,
/// for s = i omega; s = sigma + i omega is the FRF of the response times exp(-sigma t), smoother by that. q is the
/// order of the output's time derivative, p of the ground motion's; f = f_0 + s f_1 a unit force at a point, or
/// k_g + s c_g of a ground, with C_m acting on the motion relative to it. The damping is not made diagonal.
///
/// Derivatives are those of the exact H, evaluated in the basis:
///     dH = s^(q - p) (Z^-1 V^T S^T)^T (V^T df - V^T dZ V Z^-1 V^T f),
/// where C_m follows K, M and the ratios (modal_damping_derivative()). Derivatives of ground loads, which a model does
/// not give, are central differences over 1e-4 of the parameter: exact where K is quadratic in it, else to 1e-8.
struct FrfEvaluation {
  /// V^T f_0 and V^T f_1 of a set's unit input.
  struct Load {
    Eigen::VectorXd constant, per_s;
  };
  struct Set {
    Load load;
    std::vector<Load> load_derivatives;  ///< one a parameter; empty: none depends on it
    Eigen::MatrixXd outputs;             ///< S V
    int order = 0;                       ///< q - p
  };
  /// V^T d. V for a parameter; 0 x 0: none.
  struct Derivative {
    Eigen::MatrixXd stiffness, mass, damping;
    Eigen::MatrixXd modal_damping;  ///< of C_m alone; part of `damping`
  };

  ResponseBasis basis;
  Eigen::MatrixXd damping;  ///< V^T (C + C_m) V
  bool diagonal = false;    ///< so is the damping
  std::vector<Set> sets;
  std::vector<Derivative> derivatives;  ///< one a parameter; empty where not asked for

  /// Whether an undamped shape has no impedance k + s c + s^2 m, but for rounding: an answer would be infinite.
  [[nodiscard]] bool is_singular(std::complex<double> s) const;
  /// Line of a set, with derivatives where they are at hand.
  [[nodiscard]] FrfLine at(std::size_t set, std::complex<double> s) const;
  /// s^(q - p) S V Z^-1: what unit forces on the shapes give at the outputs of a set, outputs x r.
  [[nodiscard]] Eigen::MatrixXcd transfer(std::size_t set, std::complex<double> s) const;
  /// V^T (f_0 + s f_1) of a set's unit input.
  [[nodiscard]] Eigen::VectorXcd load(std::size_t set, std::complex<double> s) const;
  /// Derivatives of transfer(set, s) (input load(set, s) + held), where `held` is a load on the shapes that no
  /// parameter changes; outputs x parameters.
  [[nodiscard]] Eigen::MatrixXcd derivatives_under(std::size_t set, std::complex<double> s, std::complex<double> input,
                                                   const Eigen::VectorXcd& held) const;

private:
  /// Z^-1 of some columns.
  [[nodiscard]] Eigen::MatrixXcd solved(std::complex<double> s, Eigen::MatrixXcd columns) const;
  /// Z^-1 of a load, first column, and of V^T S^T of the set, the others.
  [[nodiscard]] Eigen::MatrixXcd answers_to(std::size_t set, std::complex<double> s,
                                            const Eigen::VectorXcd& load) const;
  /// The derivatives from these answers, `input` times the unit input in the load.
  [[nodiscard]] Eigen::MatrixXcd derivatives_from(std::size_t set, std::complex<double> s, std::complex<double> input,
                                                  const Eigen::MatrixXcd& answers) const;
};

/// FRFs of a model as a function of its parameters. Immutable.
class FrfModel {
public:
  /// Lines up to `highest` [Hz] will be asked for; `parameters` is any point at which the model exists. Throws
  /// InvalidInput with every unknown point or ground.
  FrfModel(std::shared_ptr<const ParameterisedModel> model, std::vector<FrfSet> sets, double highest,
           const Eigen::VectorXd& parameters, const ResponseBasisOptions& options = {});

  /// Throws InvalidInput where there is no model at these parameters or its stiffness is indefinite.
  [[nodiscard]] FrfEvaluation evaluate(const Eigen::VectorXd& parameters, bool with_derivatives) const;

  [[nodiscard]] const std::vector<FrfSet>& sets() const { return sets_; }

private:
  [[nodiscard]] Eigen::MatrixXd places(const LinearModel& model) const;
  [[nodiscard]] FrfEvaluation::Set reduced_set(std::size_t index, const LinearModel& model, const ResponseBasis& basis,
                                               const Eigen::VectorXd& rates) const;
  /// Derivatives of the ground loads by the parameters, moved one after the other.
  void add_load_derivatives(FrfEvaluation& evaluation, const Eigen::VectorXd& parameters,
                            const Eigen::VectorXd& rates) const;

  std::shared_ptr<const ParameterisedModel> model_;
  std::vector<FrfSet> sets_;
  std::vector<FrfPlaces> places_;  ///< of each set
  double highest_;
  ResponseBasisOptions options_;
};

}  // namespace kalfem
