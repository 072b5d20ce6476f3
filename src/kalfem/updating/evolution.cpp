#include "kalfem/updating/evolution.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Cost of a point without response: above that of any model, and far from overflow.
constexpr double cost_without_response = 1e100;
/// A point a tenth of the bounds' width outside costs twice as much as the nearest one inside.
constexpr double penalty_outside = 100.0;

void require_searchable(const std::vector<UpdatingParameter>& parameters, const CmaEsOptions& options) {
  require_startable(parameters);
  IssueList issues;
  bool any_free = false;
  for (const auto& p : parameters) {
    any_free = any_free || p.lower < p.upper;
    if (std::isfinite(p.lower) && std::isfinite(p.upper)) continue;
    issues.add(
        {}, fmt::format("{}: bounds from {} to {}", p.name, p.lower, p.upper),
        "an evolution strategy needs finite bounds",
        fmt::format("give both, for example {:g} and {:g}", p.initial - 0.5 * p.scale(), p.initial + 0.5 * p.scale()));
  }
  if (!any_free)
    issues.add({}, "no parameter is free", "an evolution strategy needs at least one",
               "widen the bounds of the parameters that may change");
  if (options.population < 5)
    issues.add({}, fmt::format("a population of {}", options.population),
               "CMA-ES needs at least 5 points per generation", "use 4 + 3 ln(parameters) or more");
  issues.raise();
}

// CMA-ES [Han06] searches the unit cube of the free parameters without derivatives; its points may leave the cube. A
// point outside costs what the nearest point inside does, times a factor that grows with the distance, so the search is
// led back and the model is never asked for values beyond its bounds. Least squares then ends the search where
// derivatives exist.
/// The cost over the unit cube of the free parameters, and the best point seen.
class Landscape {
public:
  Landscape(const Residual& residual, const std::vector<UpdatingParameter>& parameters)
      : residual_(residual), parameters_(parameters), best_(initial_values(parameters)) {
    for (std::size_t i = 0; i < parameters.size(); ++i)
      if (parameters[i].lower < parameters[i].upper) free_.push_back(i);
  }

  /// The initial values in the cube.
  [[nodiscard]] std::vector<double> start() const {
    std::vector<double> point;
    for (const auto i : free_) point.push_back((parameters_[i].initial - parameters_[i].lower) / width(i));
    return point;
  }

  double operator()(const std::vector<double>& point) {
    VectorXd values = initial_values(parameters_);
    double outside = 0.0;
    for (std::size_t k = 0; k < free_.size(); ++k) {
      const double inside = std::clamp(point[k], 0.0, 1.0);
      outside += (point[k] - inside) * (point[k] - inside);
      values[static_cast<Index>(free_[k])] = parameters_[free_[k]].lower + inside * width(free_[k]);
    }
    return cost_at(values) * (1.0 + penalty_outside * outside);
  }

  double cost_at(const VectorXd& values) {
    ++evaluations_;
    const auto value = residual_.evaluate(values, false);
    if (!value || !value->values.allFinite()) {
      ++without_response_;
      return cost_without_response;
    }
    const double cost = 0.5 * value->values.squaredNorm() + prior_cost(parameters_, values);
    if (cost < best_cost_) best_cost_ = cost, best_ = values;
    return std::min(cost, cost_without_response);
  }

  [[nodiscard]] const VectorXd& best() const { return best_; }
  [[nodiscard]] double best_cost() const { return best_cost_; }
  [[nodiscard]] int evaluations() const { return evaluations_; }
  [[nodiscard]] int without_response() const { return without_response_; }

private:
  [[nodiscard]] double width(std::size_t i) const { return parameters_[i].upper - parameters_[i].lower; }

  const Residual& residual_;
  const std::vector<UpdatingParameter>& parameters_;
  std::vector<std::size_t> free_;
  VectorXd best_;
  double best_cost_ = std::numeric_limits<double>::infinity();
  int evaluations_ = 0, without_response_ = 0;
};

/// Least squares from the best point; kept where it lowers the cost.
void polish(EvolutionOutcome& outcome, const Residual& residual, const std::vector<UpdatingParameter>& parameters,
            LeastSquaresOptions options) {
  options.start = outcome.parameters;
  outcome.polished = minimise(residual, parameters, options);
  if (!(outcome.polished->cost_final < outcome.cost_final)) return;
  outcome.parameters = outcome.polished->parameters;
  outcome.cost_final = outcome.polished->cost_final;
}

std::string words(CmaEsEnd end) {
  switch (end) {
    case CmaEsEnd::settled:
      return "the generations converged to one point";
    case CmaEsEnd::generations:
      return "the limit on generations was reached";
    case CmaEsEnd::stopped:
      return "stopped on request";
  }
  return {};
}

}  // namespace

std::string EvolutionOutcome::reason() const {
  const std::string search = found() ? words(end) : "the model has no response at any point tried";
  return polished ? search + "; then least squares " + polished->reason() : search;
}

EvolutionOutcome evolve(const Residual& residual, const std::vector<UpdatingParameter>& parameters,
                        const EvolutionOptions& options) {
  require_searchable(parameters, options.search);
  Landscape landscape(residual, parameters);
  EvolutionOutcome outcome;
  landscape.cost_at(initial_values(parameters));
  outcome.cost_initial = landscape.best_cost();
  outcome.end = cma_es([&](const auto& point) { return landscape(point); }, landscape.start(), options.search,
                       [&](unsigned generation) {
                         outcome.trace.push_back({generation, landscape.best(), landscape.best_cost()});
                         return !options.watch || options.watch(outcome.trace.back());
                       });
  outcome.parameters = landscape.best();
  outcome.cost_evolved = outcome.cost_final = landscape.best_cost();
  outcome.evaluations = landscape.evaluations();
  outcome.without_response = landscape.without_response();
  if (options.polishing && outcome.found() && outcome.end != CmaEsEnd::stopped)
    polish(outcome, residual, parameters, *options.polishing);
  return outcome;
}

}  // namespace kalfem
