#include "kalfem/updating/multi_start.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <numeric>

#include "kalfem/base/random.hpp"
#include "kalfem/base/worker_pool.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Starts are a Latin hypercube [MBC79]: the range of each parameter is cut into as many strips as there are starts, and
// every strip is used once, in an order drawn for each parameter by its name; the first start is the initial values.
// Searches run side by side and are then sorted, so the outcome does not depend on which ends first.
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

/// Runs the searches; what one throws is thrown once all have ended.
std::vector<LeastSquaresOutcome> run_searches(const Residual& residual,
                                              const std::vector<UpdatingParameter>& parameters,
                                              const MultiStartOptions& options, const std::vector<VectorXd>& starts) {
  std::vector<LeastSquaresOutcome> outcomes(starts.size());
  std::vector<std::exception_ptr> thrown(starts.size());
  WorkerPool pool(std::clamp(options.threads, 1, static_cast<int>(starts.size())));
  pool.run(static_cast<int>(starts.size()), [&](int task) {
    const auto i = static_cast<std::size_t>(task);
    auto search = options.search;
    search.start = starts[i];
    try {
      outcomes[i] = minimise(residual, parameters, search);
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

/// Usable outcomes first, then by cost; one that found no response comes last.
bool is_better(const LeastSquaresOutcome& a, const LeastSquaresOutcome& b) {
  const auto rank = [](const LeastSquaresOutcome& o) {
    return o.usable() ? 0 : o.termination != Termination::no_response ? 1 : 2;
  };
  return rank(a) != rank(b) ? rank(a) < rank(b) : a.cost_final < b.cost_final;
}

void add_minimum(std::vector<Minimum>& minima, const LeastSquaresOutcome& outcome,
                 const std::vector<UpdatingParameter>& parameters, double within) {
  const auto known = std::find_if(minima.begin(), minima.end(), [&](const Minimum& minimum) {
    return is_same(minimum.parameters, outcome.parameters, parameters, within);
  });
  if (known != minima.end())
    ++known->reached;
  else
    minima.push_back({outcome.parameters, outcome.cost_final, 1});
}

}  // namespace

std::vector<VectorXd> spread_starts(const std::vector<UpdatingParameter>& parameters, int count, std::uint64_t seed) {
  const int others = std::max(count - 1, 0);
  std::vector<VectorXd> starts(static_cast<std::size_t>(others) + 1, initial_values(parameters));
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    RandomStream random(seed, "start of " + parameters[i].name);
    const auto [lower, upper] = range_of(parameters[i]);
    const auto strips = shuffled(others, random);
    for (std::size_t k = 0; k < strips.size(); ++k)
      starts[k + 1][static_cast<Index>(i)] = lower + (upper - lower) * (strips[k] + random.uniform()) / others;
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
    if (!search.usable()) continue;
    ++outcome.converged;
    add_minimum(outcome.minima, search, parameters, options.same_within);
  }
  outcome.best = std::move(searches.front());
  return outcome;
}

}  // namespace kalfem
