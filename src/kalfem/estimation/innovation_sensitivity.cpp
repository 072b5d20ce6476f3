#include "kalfem/estimation/innovation_sensitivity.hpp"

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double known = 1e-4;  ///< deviation of an unknown that counts as known, of the estimate's
constexpr double beside = 0.2;  ///< step of the differences, of the estimate's deviation: small beside its range
constexpr double most_values = 1e8;

/// Runs a filter with constants that are known.
class KnownUnknowns {
public:
  KnownUnknowns(const AugmentedModel& augmented_model, const FilterInput& input, EstimationOptions options,
                const UnknownsHistory& history)
      : augmented_model_(augmented_model),
        input_(input),
        options_(std::move(options)),
        history_(history),
        deviation_(history.covariance.back().diagonal().cwiseSqrt()) {
    options_.passes = 1;
    options_.monitored = {};
    options_.progress = {};
    options_.keep_unknowns = options_.keep_gains = options_.state_deviations = false;
  }

  [[nodiscard]] const VectorXd& deviation() const { return deviation_; }

  /// At these values of the constants, in the filter's state.
  [[nodiscard]] std::optional<EstimationResult> run_at(const VectorXd& state) const {
    const auto& unknowns = augmented_model_.options().unknowns;
    VectorXd values(std::ssize(unknowns)), deviations(values.size());
    for (Index i = 0; i < values.size(); ++i) {
      values[i] = unknowns[static_cast<std::size_t>(i)].initial;
      deviations[i] = unknowns[static_cast<std::size_t>(i)].deviation;
    }
    for (std::size_t i = 0; i < history_.unknowns.size(); ++i) {
      const Index unknown = history_.unknowns[i], place = static_cast<Index>(i);
      const auto& transform = unknowns[static_cast<std::size_t>(unknown)].transform;
      values[unknown] = transform.to_parameter(state[place]);
      deviations[unknown] = known * deviation_[place] * transform.slope(state[place]);
    }
    try {
      auto result = estimate(augmented_model_.with_priors(values, deviations), input_, options_);
      if (!result.failure) return result;
    } catch (const InvalidInput&) {  // a value that the model does not admit
    }
    return std::nullopt;
  }

private:
  const AugmentedModel& augmented_model_;
  const FilterInput& input_;
  EstimationOptions options_;
  const UnknownsHistory& history_;
  VectorXd deviation_;
};

}  // namespace

std::optional<SensitiveInnovations> innovation_sensitivity(const AugmentedModel& augmented_model,
                                                           const FilterInput& input, EstimationOptions options,
                                                           const UnknownsHistory& history, Index first) {
  const VectorXd& at = history.mean.back();
  if (static_cast<double>((at.size() + 1) * input.measured.values.size()) > most_values) return std::nullopt;
  const KnownUnknowns runs(augmented_model, input, std::move(options), history);
  const auto base = runs.run_at(at);
  if (!base) return std::nullopt;
  const Index count = base->innovation.cols() - first;
  const MatrixXd deviation = base->innovation_deviation.rightCols(count);
  SensitiveInnovations found{base->innovation.rightCols(count).cwiseQuotient(deviation), {}};
  for (Index i = 0; i < at.size(); ++i) {
    const double step = beside * runs.deviation()[i];
    const auto moved = runs.run_at(at + step * VectorXd::Unit(at.size(), i));
    if (!moved) return std::nullopt;
    found.derivative.emplace_back((moved->innovation - base->innovation).rightCols(count).cwiseQuotient(deviation) /
                                  step);
  }
  return found;
}

}  // namespace kalfem
