#pragma once

#include <complex>
#include <memory>
#include <string>
#include <vector>

#include "kalfem/model/parameterised_model.hpp"
#include "kalfem/updating/response_basis.hpp"

namespace kalfem {

enum class ResponseQuantity { displacement, velocity, acceleration };
enum class FrfInput { force, ground_displacement, ground_acceleration };

/// FRFs of one input: absolute motion of points per force at a point [N], or per displacement or acceleration of a
/// ground.
struct FrfSet {
  FrfInput input = FrfInput::force;
  std::string place;                 ///< where the input acts: a degree of freedom, a point, or a ground
  std::vector<std::string> outputs;  ///< degrees of freedom or points
  ResponseQuantity quantity = ResponseQuantity::acceleration;
};

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

  /// Line of a set, with derivatives where they are at hand.
  [[nodiscard]] FrfLine at(std::size_t set, std::complex<double> s) const;
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
  std::vector<Eigen::VectorXd> forces_;   ///< unit force of each set, n; empty for a ground
  std::vector<Eigen::MatrixXd> outputs_;  ///< S^T of each set, n x outputs
  double highest_;
  ResponseBasisOptions options_;
};

}  // namespace kalfem
