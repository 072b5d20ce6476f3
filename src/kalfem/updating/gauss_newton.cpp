// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/gauss_newton.hpp"

#include <fmt/format.h>
#include <cassert>
#include <cmath>

#include "kalfem/base/interruption.hpp"
#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Known = GaussNewtonState::Known;

constexpr double least_ratio = 1e-4;     // of true to promised reduction, for a step to be taken
constexpr double cost_rounding = 1e-13;  // a smaller relative reduction cannot be told from rounding
constexpr double poor_ratio = 0.25, good_ratio = 0.75;
constexpr double shrinking = 0.25, growth = 2.0;  // of the trust region
/// Of a sum of squares in units of the noise: a tenth of a standard deviation from the minimum.
constexpr double negligible_reduction = 1e-2;
constexpr int enough_refusals = 2;  // in a row, of steps that promise no more than that

template <class Get>
VectorXd collected(const std::vector<UpdatingParameter>& parameters, Get get) {
  VectorXd values(static_cast<Index>(parameters.size()));
  for (Index i = 0; i < values.size(); ++i) values[i] = get(parameters[static_cast<std::size_t>(i)]);
  return values;
}

bool is_response(const std::optional<ResidualValue>& value) {
  return value && value->values.allFinite() && value->jacobian.allFinite();
}

bool has_jacobian(const ResidualValue& value) { return value.jacobian.cols() > 0; }

}  // namespace

bool converged(Termination termination) {
  return termination == Termination::converged_step || termination == Termination::converged_cost ||
         termination == Termination::converged_gradient;
}

std::string explain(Termination termination) {
  switch (termination) {
    case Termination::converged_step:
      return "converged: the next step would change every parameter by less than the tolerance";
    case Termination::converged_cost:
      return "converged: the next step would lower the cost by less than the tolerance";
    case Termination::converged_gradient:
      return "converged: no parameter change within the bounds lowers the cost to first order";
    case Termination::no_progress:
      return "not converged: no step lowers the cost; its derivatives are wrong or it is not smooth";
    case Termination::no_response:
      return "not started: the model has no response at the initial values";
    case Termination::no_derivatives:
      return "not converged: the model has no derivatives at the point reached";
    case Termination::budget:
      return "not converged: the limit on evaluations was reached";
    case Termination::stopped:
      return "not converged: stopped on request";
  }
  return {};
}

GaussNewtonState starting_at(const VectorXd& start, const GaussNewtonOptions& options) {
  GaussNewtonState state;
  state.parameters = start;
  state.radius = options.initial_radius;
  return state;
}

double prior_cost(const std::vector<UpdatingParameter>& parameters, const VectorXd& values) {
  const VectorXd deviation = collected(parameters, [](const auto& p) { return p.deviation; });
  return 0.5 * (values - initial_values(parameters)).cwiseQuotient(deviation).squaredNorm();
}

void require_startable(const std::vector<UpdatingParameter>& parameters) {
  IssueList issues;
  for (const auto& [name, unit, initial, lower, upper, deviation] : parameters) {
    if (!(lower <= upper))
      issues.add({}, fmt::format("{}: bounds from {} to {}", name, lower, upper),
                 "the lower bound exceeds the upper one", "exchange them");
    else if (!std::isfinite(initial) || initial < lower || initial > upper)
      issues.add({}, fmt::format("{}: initial value {} with bounds from {} to {}", name, initial, lower, upper),
                 "the initial value must lie within the bounds", "widen the bounds or change the initial value");
    if (!(deviation > 0.0))
      issues.add({}, fmt::format("{}: prior standard deviation {}", name, deviation),
                 "a standard deviation must be > 0",
                 "give a positive one, or equal bounds to hold the parameter fixed");
  }
  issues.raise();
}

GaussNewton::GaussNewton(std::vector<UpdatingParameter> parameters, GaussNewtonOptions options,
                         std::optional<GaussNewtonState> resumed)
    : parameters_(std::move(parameters)),
      options_(options),
      scale_(collected(parameters_, [](const auto& p) { return p.scale(); })),
      lower_(collected(parameters_, [](const auto& p) { return p.lower; })),
      upper_(collected(parameters_, [](const auto& p) { return p.upper; })) {
  require_startable(parameters_);
  state_ = resumed ? std::move(*resumed) : starting_at(initial_values(parameters_), options_);
  assert(state_.parameters.size() == scale_.size());
  state_.parameters = state_.parameters.cwiseMax(lower_).cwiseMin(upper_);
  if (state_.known == Known::derivatives) plan();
}

double GaussNewton::cost() const { return state_.residual_cost + prior_cost(parameters_, state_.parameters); }

bool GaussNewton::needs_jacobian() const { return state_.known != Known::derivatives || state_.refused < 2; }

VectorXd GaussNewton::proposal() const {
  if (state_.known != Known::derivatives) return state_.parameters;
  VectorXd point = state_.parameters + scale_.cwiseProduct(step_.change);
  for (Index i = 0; i < point.size(); ++i) {  // a step onto a bound ends there, not a rounding beside it
    if (step_.change[i] == (lower_[i] - state_.parameters[i]) / scale_[i]) point[i] = lower_[i];
    if (step_.change[i] == (upper_[i] - state_.parameters[i]) / scale_[i]) point[i] = upper_[i];
  }
  return point.cwiseMax(lower_).cwiseMin(upper_);
}

bool GaussNewton::tell(const std::optional<ResidualValue>& value) {
  ++state_.evaluations;
  if (!is_response(value)) ++state_.without_response;
  if (state_.known == Known::derivatives) return try_step(value);
  if (!is_response(value)) {
    state_.known = state_.known == Known::cost ? Known::no_derivatives : Known::no_response;
    return false;
  }
  accept(state_.parameters, *value);
  return true;
}

// The search is a machine that asks and is told: proposal() names a point, tell() takes the residual there. In between
// its whole state is GaussNewtonState, so a search can be stopped, written to a file and resumed. A turn:
//   1. linearise(): J diag(scale) = Q R. R and Q^T r replace J and r, whatever their number of rows. Their change since
//      the last point updates S, the second-order part of the Hessian [DGW81].
//   2. plan(): minimise |R d + Q^T r|^2 with the prior's rows, plus d^T S d if S predicted better at the last trial,
//      within the bounds and the trust region [SP95]; the minimum without S and region serves the tests of convergence.
//   3. try_step(): rho = true reduction of the cost / reduction that the model promises ([NW06], section 4.1).
//      A poor rho shrinks the region to a part of the step, a good one of a step that the region limited doubles it.
//   4. A trial with rho above a small threshold is accepted; a refused one is planned again with the smaller radius.
/// Judges the trial at proposal().
bool GaussNewton::try_step(const std::optional<ResidualValue>& value) {
  const VectorXd trial = proposal();
  double ratio = -1.0;
  if (is_response(value) && step_.reduction > 0.0) {
    const double trial_cost = 0.5 * value->values.squaredNorm() + prior_cost(parameters_, trial);
    ratio = (cost() - trial_cost) / step_.reduction;
    choose_model(cost() - trial_cost);
  }
  adapt_radius(ratio);
  if (!(ratio > least_ratio)) {
    ++state_.refused;
    plan();
    return false;
  }
  ++state_.iterations;
  state_.refused = 0;
  accept(trial, *value);
  return true;
}

/// The next step follows the model that would have predicted the trial's cost better.
void GaussNewton::choose_model(double actual_reduction) {
  if (state_.second_order.size() == 0) return;
  const VectorXd& change = step_.change;
  const double without = linearised_.reduction(change), with = without - 0.5 * change.dot(state_.second_order * change);
  state_.with_second_order = std::abs(with - actual_reduction) < std::abs(without - actual_reduction);
}

/// |J_i| / max_j |J_j|, the prior's rows counted in.
VectorXd GaussNewton::sensitivities() const {
  const VectorXd lengths = linearised_.matrix.colwise().norm().transpose();
  const double longest = lengths.size() > 0 ? lengths.maxCoeff() : 0.0;
  return longest > 0.0 ? VectorXd(lengths / longest) : VectorXd(VectorXd::Ones(lengths.size()));
}

/// Half the widths of the trust region, in parts of the scales.
VectorXd GaussNewton::widths() const {
  const double most = std::max(state_.radius, options_.initial_radius);
  VectorXd widths = most * state_.parameters.cwiseAbs().cwiseQuotient(scale_).cwiseMax(1.0);
  const VectorXd sensitivity = sensitivities();
  for (Index i = 0; i < widths.size(); ++i)
    if (sensitivity[i] * widths[i] > state_.radius) widths[i] = state_.radius / sensitivity[i];
  return widths;
}

void GaussNewton::adapt_radius(double ratio) {
  if (!(ratio >= poor_ratio))
    state_.radius = shrinking * step_.change.cwiseProduct(sensitivities()).lpNorm<Eigen::Infinity>();
  else if (ratio > good_ratio && limited_)
    state_.radius *= growth;
}

void GaussNewton::accept(const VectorXd& parameters, const ResidualValue& value) {
  state_.parameters = parameters;
  state_.residual_cost = 0.5 * value.values.squaredNorm();
  state_.known = has_jacobian(value) ? Known::derivatives : Known::cost;
  if (!has_jacobian(value)) return;
  linearise(value);
  plan();
}

/// Keeps of the residual and its Jacobian what the linearised problem needs: R and Q^T r. What they are more than at
/// the point before goes into S.
void GaussNewton::linearise(const ResidualValue& value) {
  const Index count = scale_.size(), rows = std::min(count, value.values.size());
  const SecantEnd before{state_.jacobian_factor, state_.projected_residual};
  const VectorXd step = state_.factored_at.size() > 0
                            ? (state_.parameters - state_.factored_at).cwiseQuotient(scale_).eval()
                            : VectorXd();
  Eigen::HouseholderQR<MatrixXd> qr(value.jacobian * scale_.asDiagonal());
  state_.jacobian_factor = MatrixXd::Zero(count, count);
  state_.jacobian_factor.topRows(rows) = qr.matrixQR().topRows(rows).triangularView<Eigen::Upper>();
  const VectorXd rotated = qr.householderQ().adjoint() * value.values;
  state_.projected_residual = VectorXd::Zero(count);
  state_.projected_residual.head(rows) = rotated.head(rows);
  state_.factored_at = state_.parameters;
  if (step.size() > 0)
    state_.second_order =
        updated_second_order(state_.second_order, step, before, {state_.jacobian_factor, state_.projected_residual});
}

/// Poses the linearised problem at the accepted point and solves it within the bounds; then, with S if that is the
/// better model, within the trust region too.
void GaussNewton::plan() {
  const Index count = scale_.size();
  const VectorXd deviation = collected(parameters_, [](const auto& p) { return p.deviation; });
  linearised_.matrix.resize(2 * count, count);
  linearised_.offset.resize(2 * count);
  linearised_.matrix << state_.jacobian_factor, MatrixXd(scale_.cwiseQuotient(deviation).asDiagonal());
  linearised_.offset << state_.projected_residual,
      (state_.parameters - initial_values(parameters_)).cwiseQuotient(deviation);
  const VectorXd lower = (lower_ - state_.parameters).cwiseQuotient(scale_);
  const VectorXd upper = (upper_ - state_.parameters).cwiseQuotient(scale_);
  whole_ = step_within(linearised_, lower, upper);
  const auto augmented = state_.with_second_order ? with_second_order(linearised_, state_.second_order) : std::nullopt;
  const QuadraticModel& model = augmented ? *augmented : linearised_;
  const VectorXd width = widths();
  step_ = augmented ? step_within(model, lower, upper) : whole_;
  limited_ = (step_.change.array().abs() > width.array()).any();
  if (limited_) step_ = step_within(model, lower.cwiseMax(-width), upper.cwiseMin(width));
}

GaussNewton::Step GaussNewton::step_within(const QuadraticModel& model, const VectorXd& lower,
                                           const VectorXd& upper) const {
  Step step{bounded_least_squares(model.matrix, model.offset, lower, upper, options_.rank_tolerance)};
  step.reduction = model.reduction(step.change);
  step.size = step.change.size() > 0 ? step.change.lpNorm<Eigen::Infinity>() : 0.0;
  return step;
}

/// First-order condition: of each parameter that can move downhill, the cosine between its column of the Jacobian and
/// the residual, both with the prior, is small.
bool GaussNewton::is_stationary() const {
  const double length = std::sqrt(2.0 * cost());
  const VectorXd gradient = linearised_.gradient();
  for (Index i = 0; i < gradient.size(); ++i) {
    const bool blocked = gradient[i] > 0.0 ? state_.parameters[i] == lower_[i] : state_.parameters[i] == upper_[i];
    if (!blocked && std::abs(gradient[i]) > options_.gradient_tolerance * linearised_.matrix.col(i).norm() * length)
      return false;
  }
  return true;
}

/// The tests of convergence use the step of the linearised problem without the trust region: a small region or a large
/// S must not pass for convergence, and a region that has shrunk to nothing after refusals is a failure.
std::optional<Termination> GaussNewton::judge_point() const {
  if (is_stationary()) return Termination::converged_gradient;
  if (whole_.size <= options_.step_tolerance) return Termination::converged_step;
  const double least = std::max(options_.cost_floor, std::max(options_.cost_tolerance, cost_rounding) * cost());
  if (whole_.reduction <= least) return Termination::converged_cost;
  if (limited_ && step_.size <= options_.step_tolerance)
    return state_.refused > 0 ? Termination::no_progress : Termination::converged_step;
  return std::nullopt;
}

// A residual in units of the noise (`cost_floor` > 0) may be rough at a scale far below the noise: that of a filter
// pass is, as its derivatives are differences. Where no progress is made any more, the search has converged if the next
// Gauss-Newton step would lower |r|^2 by less than `negligible_reduction`: the end is then as good as the minimum.
std::optional<Termination> GaussNewton::finished() const {
  if (state_.known == Known::no_response) return Termination::no_response;
  if (state_.known == Known::no_derivatives) return Termination::no_derivatives;
  const bool has_derivatives = state_.known == Known::derivatives;
  const bool negligible = has_derivatives && options_.cost_floor > 0.0 && 2.0 * whole_.reduction < negligible_reduction;
  if (has_derivatives)
    if (const auto verdict = judge_point())
      return verdict == Termination::no_progress && negligible ? Termination::converged_cost : verdict;
  if (negligible && state_.refused >= enough_refusals) return Termination::converged_cost;
  if (state_.evaluations >= options_.max_evaluations)
    return negligible ? Termination::converged_cost : Termination::budget;
  return std::nullopt;
}

namespace {

// Ask the Gauss-Newton search for a point, evaluate the residual there, tell it the answer, note the turn; until it has
// finished or the caller stops it.
/// The loop with what it records.
class Search {
public:
  Search(const Residual& residual, const std::vector<UpdatingParameter>& parameters, const LeastSquaresOptions& options)
      : residual_(residual),
        parameters_(parameters),
        options_(options),
        search_(parameters, options.search,
                options.start ? std::optional(starting_at(*options.start, options.search)) : std::nullopt) {}

  LeastSquaresOutcome run() {
    while (!search_.finished() && proceeds_) {
      stop_if_asked();
      evaluate();
    }
    outcome_.termination = search_.finished().value_or(Termination::stopped);
    complete_jacobian();
    const auto& state = search_.state();
    outcome_.parameters = state.parameters;
    outcome_.residual_cost_final = state.residual_cost;
    outcome_.cost_final = search_.cost();
    outcome_.evaluations = state.evaluations;
    outcome_.iterations = state.iterations;
    outcome_.without_response = state.without_response;
    return std::move(outcome_);
  }

private:
  void evaluate() {
    const VectorXd point = search_.proposal(), before = search_.state().parameters;
    auto value = residual_.evaluate(point, search_.needs_jacobian());
    const int iterations = search_.state().iterations;
    const bool taken = search_.tell(value);  // a new point, or the Jacobian of the last one
    if (outcome_.trace.empty()) {
      outcome_.residual_cost_initial = search_.state().residual_cost;
      outcome_.cost_initial = search_.cost();
    }
    if (taken) outcome_.residual = std::move(*value);
    const bool accepted = search_.state().iterations > iterations || (taken && outcome_.trace.empty());
    double step = 0.0;
    for (std::size_t i = 0; i < parameters_.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      step = std::max(step, std::abs(point[at] - before[at]) / parameters_[i].scale());
    }
    outcome_.trace.push_back({search_.state().evaluations, accepted, search_.state().parameters, search_.cost(), step});
    proceeds_ = !options_.watch || options_.watch(outcome_.trace.back());
  }

  /// A search may end on a point that was tried without its Jacobian; statistics need it.
  void complete_jacobian() {
    if (search_.state().known != GaussNewtonState::Known::cost) return;
    auto value = residual_.evaluate(search_.proposal(), true);
    if (search_.tell(value)) outcome_.residual = std::move(*value);
  }

  const Residual& residual_;
  const std::vector<UpdatingParameter>& parameters_;
  const LeastSquaresOptions& options_;
  GaussNewton search_;
  LeastSquaresOutcome outcome_;
  bool proceeds_ = true;
};

}  // namespace

LeastSquaresOutcome minimise(const Residual& residual, const std::vector<UpdatingParameter>& parameters,
                             const LeastSquaresOptions& options) {
  return Search(residual, parameters, options).run();
}

}  // namespace kalfem
