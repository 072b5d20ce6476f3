#include "kalfem/updating/least_squares.hpp"

namespace kalfem {
namespace {

using Eigen::VectorXd;

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
    while (!search_.finished() && proceeds_) evaluate();
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
