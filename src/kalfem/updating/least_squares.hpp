#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/updating/gauss_newton.hpp"

namespace kalfem {

/// The search after one evaluation.
struct LeastSquaresIteration {
  int evaluation = 0;          ///< counted from 1
  bool accepted = false;       ///< the point tried is the search's new point
  Eigen::VectorXd parameters;  ///< theta accepted last
  double cost = 0.0;           ///< F there: |r|^2 / 2 and the prior's share
  double step = 0.0;           ///< greatest |change of theta_i| / scale_i of the point tried
};

struct LeastSquaresOptions {
  GaussNewtonOptions search{};
  std::optional<Eigen::VectorXd> start{};  ///< where to begin if not at the parameters' initial values
  std::function<bool(const LeastSquaresIteration&)> watch{};  ///< called after each evaluation; false ends the search
};

struct LeastSquaresOutcome {
  Eigen::VectorXd parameters;
  double residual_cost_initial = 0.0, residual_cost_final = 0.0;  ///< |r|^2 / 2
  double cost_initial = 0.0, cost_final = 0.0;                    ///< with the prior's share
  int evaluations = 0;  ///< of the residual; one more than the trace has where the last point's Jacobian was missing
  int iterations = 0;   ///< accepted steps
  int without_response = 0;
  Termination termination = Termination::no_response;
  std::vector<LeastSquaresIteration> trace;
  ResidualValue residual;  ///< r and J at `parameters`; empty with Termination::no_response, J with no_derivatives

  /// The search converged.
  [[nodiscard]] bool usable() const { return converged(termination); }
  /// Why it ended.
  [[nodiscard]] std::string reason() const { return explain(termination); }
};

/// Minimises |r|^2 / 2 and the priors' share within the bounds: the plain loop over GaussNewton. Throws InvalidInput as
/// require_startable does.
LeastSquaresOutcome minimise(const Residual& residual, const std::vector<UpdatingParameter>& parameters,
                             const LeastSquaresOptions& options = {});

}  // namespace kalfem
