// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/global_search.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/base/worker_pool.hpp"

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

  // The nearest point of the cube is evaluated, and its cost raised by the squared distance.
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

// The evolution strategy finds the valley, not its floor: near the minimum Gauss-Newton converges quadratically.
/// Least squares from the best point; kept where it lowers the cost.
void polish(EvolutionOutcome& outcome, const Residual& residual, const std::vector<UpdatingParameter>& parameters,
            LeastSquaresOptions options) {
  options.start = outcome.parameters;
  outcome.polished = minimise(residual, parameters, options);
  if (!(outcome.polished->cost_final < outcome.cost_final)) return;
  outcome.parameters = outcome.polished->parameters;
  outcome.cost_final = outcome.polished->cost_final;
}

std::string explain(CmaEsEnd end) {
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
  const std::string search = found() ? explain(end) : "the model has no response at any point tried";
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

namespace {

struct Range {
  double lower, upper;
};

/// Where the starting values of a parameter lie.
Range range_of(const UpdatingParameter& p) {
  const double reach = std::isfinite(p.deviation) ? 2.0 * p.deviation : 0.5 * p.scale();
  return {std::isfinite(p.lower) ? p.lower : std::min(p.initial - reach, p.upper),
          std::isfinite(p.upper) ? p.upper : std::max(p.initial + reach, p.lower)};
}

/// 0 ... count - 1 in random order (Fisher and Yates).
std::vector<int> shuffled(int count, RandomStream& random) {
  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  for (int i = count - 1; i > 0; --i)
    std::swap(order[static_cast<std::size_t>(i)], order[static_cast<std::size_t>(random.uniform() * (i + 1))]);
  return order;
}

/// The prime that follows.
int prime_after(int number) {
  const auto is_prime = [](int candidate) {
    for (int divisor = 2; divisor * divisor <= candidate; ++divisor)
      if (candidate % divisor == 0) return false;
    return true;
  };
  do ++number;
  while (!is_prime(number));
  return number;
}

/// Numbers 0, 1, ... mirrored at the point in a base, each digit permuted at random: in [0, 1).
class PermutedDigits {
public:
  PermutedDigits(int base, RandomStream& random) : base_(base) {
    for (double rest = 1.0; rest > smallest; rest /= base) permutations_.push_back(shuffled(base, random));
  }

  [[nodiscard]] double operator()(int number) const {
    double value = 0.0, weight = 1.0;
    for (const auto& permutation : permutations_) {
      weight /= base_;
      value += weight * permutation[static_cast<std::size_t>(number % base_)];
      number /= base_;
    }
    return value;
  }

private:
  static constexpr double smallest = 1e-12;

  int base_;
  std::vector<std::vector<int>> permutations_;  ///< of each digit
};

/// Runs the searches; what one throws is thrown once all have ended.
std::vector<LeastSquaresOutcome> run_searches(const Residual& residual,
                                              const std::vector<UpdatingParameter>& parameters,
                                              const MultiStartOptions& options, const std::vector<VectorXd>& starts) {
  std::vector<LeastSquaresOutcome> outcomes(starts.size());
  std::vector<std::exception_ptr> thrown(starts.size());
  WorkerPool pool(std::clamp(options.threads, 1, static_cast<int>(starts.size())));
  pool.run(static_cast<int>(starts.size()), [&, asked = StopScope::question()](int task) {
    const StopScope scope(asked);
    const auto i = static_cast<std::size_t>(task);
    auto search = options.search;
    search.start = starts[i];
    try {
      int earlier = 0;
      for (const Residual* smoothed : options.continuation) {
        const auto outcome = minimise(*smoothed, parameters, search);
        search.start = outcome.parameters;
        earlier += outcome.evaluations;
      }
      outcomes[i] = minimise(residual, parameters, search);
      outcomes[i].evaluations += earlier;
    } catch (...) {
      thrown[i] = std::current_exception();
    }
  });
  for (const auto& error : thrown)
    if (error) std::rethrow_exception(error);
  return outcomes;
}

bool is_same(const VectorXd& a, const VectorXd& b, const std::vector<UpdatingParameter>& parameters, double within) {
  for (Index i = 0; i < a.size(); ++i)
    if (std::abs(a[i] - b[i]) > within * parameters[static_cast<std::size_t>(i)].scale()) return false;
  return true;
}

/// By cost, whatever ended the search: a limit reached at a lower cost is nearer to the answer than convergence at
/// a higher one. One that found no response comes last.
bool is_better(const LeastSquaresOutcome& a, const LeastSquaresOutcome& b) {
  const auto has_response = [](const LeastSquaresOutcome& o) { return o.termination != Termination::no_response; };
  return has_response(a) != has_response(b) ? has_response(a) : a.cost_final < b.cost_final;
}

void add_minimum(std::vector<Minimum>& minima, const LeastSquaresOutcome& outcome,
                 const std::vector<UpdatingParameter>& parameters, double within) {
  auto known = std::find_if(minima.begin(), minima.end(), [&](const Minimum& minimum) {
    return is_same(minimum.parameters, outcome.parameters, parameters, within);
  });
  if (known == minima.end())
    known = minima.insert(known, {outcome.parameters, outcome.cost_final, outcome.residual_cost_final});
  ++known->reached;
  known->converged = known->converged || outcome.usable();
}

}  // namespace

std::vector<VectorXd> spread_starts(const std::vector<UpdatingParameter>& parameters, int count, std::uint64_t seed) {
  std::vector<VectorXd> starts(static_cast<std::size_t>(std::max(count, 1)), initial_values(parameters));
  int base = 1;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    RandomStream random(seed, "start of " + parameters[i].name);
    const auto [lower, upper] = range_of(parameters[i]);
    base = prime_after(base);
    const PermutedDigits digits(base, random);
    for (std::size_t k = 1; k < starts.size(); ++k)
      starts[k][static_cast<Index>(i)] = lower + (upper - lower) * digits(static_cast<int>(k) - 1);
  }
  return starts;
}

MultiStartOutcome minimise_from_many(const Residual& residual, const std::vector<UpdatingParameter>& parameters,
                                     const MultiStartOptions& options) {
  require_startable(parameters);
  MultiStartOutcome outcome;
  outcome.starts = spread_starts(parameters, options.starts, options.seed);
  auto searches = run_searches(residual, parameters, options, outcome.starts);
  std::stable_sort(searches.begin(), searches.end(), is_better);
  for (const auto& search : searches) {
    outcome.evaluations += search.evaluations;
    if (search.usable()) ++outcome.converged;
    if (search.termination != Termination::no_response)
      add_minimum(outcome.minima, search, parameters, options.same_within);
  }
  outcome.best = std::move(searches.front());
  return outcome;
}

}  // namespace kalfem
