// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/updating/residual.hpp"
#include "kalfem/updating/second_order_term.hpp"

namespace kalfem {

/// d = argmin |A d + b|^2 with lower <= d <= upper, where A may be rank deficient: what A does not determine stays as
/// near to zero as the bounds let it. An active-set method in the manner of [SP95], for a few columns: held unknowns
/// are joined by those that a step runs into and released where the residual pulls inwards. The free ones follow from a
/// singular value decomposition with columns scaled to length one, in which singular values below `rank_tolerance`
/// times the largest count as zero. A is rows x n with rows >= n, lower <= 0 <= upper.
Eigen::VectorXd bounded_least_squares(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& offset,
                                      const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                                      double rank_tolerance);

struct GaussNewtonOptions {
  int max_evaluations = 100;  ///< of the residual
  /// Converged: the step d to the minimum of the linearised problem has |d_i| <= step_tolerance scale_i for all i, ...
  double step_tolerance = 1e-6;
  /// ... or would lower the cost by no more than cost_tolerance cost, ...
  double cost_tolerance = 1e-8;
  /// ... or |J_i^T r| <= gradient_tolerance |J_i| |r| for all i that no bound holds, the prior's rows counted in.
  double cost_floor = 0.0;  ///< or <= this: 1e-6 is a step of 1/700 standard deviation
  double gradient_tolerance = 1e-8;
  /// The first step changes no parameter by more than initial_radius scale_i.
  double initial_radius = 0.5;
  double rank_tolerance = 1e-7;  ///< singular values of J below this part of the largest count as zero
};

/// Why an optimisation ended.
enum class Termination {
  converged_step,
  converged_cost,
  converged_gradient,
  no_progress,     ///< no shorter step lowers the cost: wrong derivatives or a rough cost
  no_response,     ///< the model has no response at the start
  no_derivatives,  ///< the model has a response but no derivatives at the point reached
  budget,          ///< all evaluations are used up
  stopped          ///< the caller asked for it
};
[[nodiscard]] bool converged(Termination termination);
/// "the next step would change every parameter by less than the tolerance"
[[nodiscard]] std::string explain(Termination termination);

/// Everything that the course of the search depends on: small, so that it can be written to a file and read back.
struct GaussNewtonState {
  enum class Known { nothing, cost, derivatives, no_response, no_derivatives };

  Eigen::VectorXd parameters;          ///< theta accepted last; before the first evaluation the start
  double radius = 0.0;                 ///< of the trust region, in parts of the scale of the most sensitive parameter
  Known known = Known::nothing;        ///< about the residual at `parameters`
  double residual_cost = 0.0;          ///< |r|^2 / 2, without the prior
  Eigen::MatrixXd jacobian_factor;     ///< R of J diag(scale) = Q R, p x p; R^T R is the normal matrix
  Eigen::VectorXd projected_residual;  ///< Q^T r, p; R^T Q^T r is the gradient
  Eigen::VectorXd factored_at;         ///< theta that both belong to; `parameters` may be one step ahead
  Eigen::MatrixXd second_order;        ///< S, p x p, in parts of the scales; 0 x 0 before the second Jacobian
  bool with_second_order = false;      ///< S predicted the last trial's cost better than Gauss-Newton did
  int evaluations = 0;
  int iterations = 0;        ///< accepted steps
  int without_response = 0;  ///< evaluations at which the model had none
  int refused = 0;           ///< trials since the last accepted one
};

/// State of a search that begins at `start` instead of the parameters' initial values.
[[nodiscard]] GaussNewtonState starting_at(const Eigen::VectorXd& start, const GaussNewtonOptions& options);

/// (theta - initial)^2 / deviation^2 / 2, summed over the parameters with a prior.
[[nodiscard]] double prior_cost(const std::vector<UpdatingParameter>& parameters, const Eigen::VectorXd& values);

/// Throws InvalidInput with every parameter that no search can begin with: initial value not finite or outside the
/// bounds, bounds in the wrong order, a deviation that is not positive.
void require_startable(const std::vector<UpdatingParameter>& parameters);

/// Bounded Gauss-Newton method with a trust region: minimises
///   F(theta) = |r(theta)|^2 / 2 + sum_i (theta_i - initial_i)^2 / (2 deviation_i^2),   lower <= theta <= upper,
/// in the variables theta_i / scale_i. Each step minimises the linearised problem
///   |r + J d|^2 + |prior + its derivative d|^2   over the bounds and |d_i| <= width_i
/// exactly (`bounded_least_squares`), so a bound redirects a step instead of cutting it, and combinations of parameters
/// that neither r nor a prior determines stay unchanged. The radius follows the ratio of actual to predicted reduction,
/// algorithm 4.1 of [NW06]. The region is a box, as in [CGT00, ch. 13]: an engineer can judge "no parameter changes by
/// more than half", and its intersection with the bounds is again a box. Its widths are
///   width_i = min(radius max_j |J_j| / |J_i|, max(radius, initial_radius) max(1, |theta_i| / scale_i)),
/// so that refused steps shorten those of sensitive parameters first [Mor78].
///
/// Where the model leaves a large residual, J^T J alone is far from the Hessian. A secant approximation S of the rest,
/// sum_k r_k d2 r_k, is then added as in NL2SOL [DGW81] (`updated_second_order()`): wherever it predicted the cost of
/// the last trial better than the linearised problem did, and leaves the Hessian positive definite.
///
/// The caller owns the loop: the search proposes points and is told their residuals. In updating with records, one
/// evaluation is a reduction and a whole filter pass, and a killed run must continue from a file after each iteration.
/// So this is not a solver that owns the loop, as Ceres is. `state()` holds everything it knows; continued from a copy
/// of it, the search proposes the same points to the last bit.
///
///   while (!search.finished()) search.tell(residual.evaluate(search.proposal(), search.needs_jacobian()));
class GaussNewton {
public:
  /// Throws InvalidInput as require_startable does.
  GaussNewton(std::vector<UpdatingParameter> parameters, GaussNewtonOptions options,
              std::optional<GaussNewtonState> resumed = std::nullopt);

  /// The point to evaluate next: the start, a trial, or the point accepted last where its Jacobian is still missing.
  [[nodiscard]] Eigen::VectorXd proposal() const;
  /// False after two failed trials in a row: a Jacobian may cost as much as many residuals, and is lost with a trial
  /// that fails. If a trial without it is accepted, the next proposal is the same point again, with its Jacobian.
  /// (After one failure the next, shorter step is mostly accepted, and not to ask at once would cost a residual more.)
  [[nodiscard]] bool needs_jacobian() const;
  /// Takes the residual at proposal(), with its Jacobian or without one (0 x 0; not where proposal() is the accepted
  /// point). Nothing, or numbers that are not finite: no response there, the next step is shorter. True where the point
  /// was accepted.
  bool tell(const std::optional<ResidualValue>& value);

  [[nodiscard]] std::optional<Termination> finished() const;
  [[nodiscard]] const GaussNewtonState& state() const { return state_; }
  /// F at the accepted parameters.
  [[nodiscard]] double cost() const;

private:
  /// Solution d_i = (change of theta_i) / scale_i of the linearised problem within some bounds.
  struct Step {
    Eigen::VectorXd change;
    double reduction = 0.0;  ///< of the cost, promised by the linearised problem
    double size = 0.0;       ///< max |d_i|
  };

  bool try_step(const std::optional<ResidualValue>& value);
  void accept(const Eigen::VectorXd& parameters, const ResidualValue& value);
  void linearise(const ResidualValue& value);
  void plan();
  void choose_model(double actual_reduction);
  void adapt_radius(double ratio);
  [[nodiscard]] Eigen::VectorXd sensitivities() const;
  [[nodiscard]] Eigen::VectorXd widths() const;
  [[nodiscard]] Step step_within(const QuadraticModel& model, const Eigen::VectorXd& lower,
                                 const Eigen::VectorXd& upper) const;
  [[nodiscard]] bool is_stationary() const;
  [[nodiscard]] std::optional<Termination> judge_point() const;

  std::vector<UpdatingParameter> parameters_;
  GaussNewtonOptions options_;
  Eigen::VectorXd scale_, lower_, upper_;
  GaussNewtonState state_;
  // What follows from the state, once derivatives are known: the linearised problem, its solution within the bounds
  // alone, by which convergence is judged, and the step proposed, with S or without, within the trust region too.
  QuadraticModel linearised_;
  Step whole_, step_;
  bool limited_ = false;  ///< the trust region cuts the step
};

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
