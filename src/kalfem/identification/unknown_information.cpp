// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/unknown_information.hpp"

#include <cmath>

#include "kalfem/identification/named_unknowns.hpp"
#include "kalfem/identification/runs_beside.hpp"
#include "kalfem/identification/white_innovations.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double far_away = 2.0;     ///< deviations of the filter
constexpr double most_memory = 1e9;  ///< of gains and derivatives [byte]

VectorXd last_of(const MatrixXd& series, const std::vector<Index>& rows) { return series.rightCols(1)(rows, 0); }

/// The constant unknowns of a filter, in the coordinates x of its state.
class ConstantUnknowns {
public:
  ConstantUnknowns(const EstimationProblem& problem, const RecordEstimate& estimate)
      : given_(problem.settings.unknowns) {
    for (Index i = 0; i < std::ssize(given_); ++i)
      if (given_[static_cast<std::size_t>(i)].random_walk == 0.0) places.push_back(i);
    std::vector<Index> rows;
    for (const Index i : places) rows.push_back(estimate.augmented_model->layout().unknown() + i);
    estimated = last_of(estimate.result.state.mean, rows);
    deviation = last_of(estimate.result.state.deviation, rows);
    prior = prior_deviation = VectorXd(size());
    for (Index i = 0; i < size(); ++i) {
      prior[i] = unknown(i).transform.to_state(unknown(i).initial);
      prior_deviation[i] = unknown(i).deviation / unknown(i).transform.slope(prior[i]);
    }
  }

  [[nodiscard]] Index size() const { return std::ssize(places); }
  [[nodiscard]] const Unknown& unknown(Index i) const {
    return given_[static_cast<std::size_t>(places[static_cast<std::size_t>(i)])];
  }
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (Index i = 0; i < size(); ++i) all.push_back(unknown(i).name);
    return all;
  }
  /// Their values at x, each in its unit.
  [[nodiscard]] VectorXd values(const VectorXd& x) const {
    VectorXd theta(size());
    for (Index i = 0; i < size(); ++i) theta[i] = unknown(i).transform.to_parameter(x[i]);
    return theta;
  }
  /// d theta / d x.
  [[nodiscard]] double slope(Index i, double x) const { return unknown(i).transform.slope(x); }

  std::vector<Index> places;
  VectorXd estimated, deviation;    ///< by the filter
  VectorXd prior, prior_deviation;  ///< x_0

private:
  const std::vector<Unknown>& given_;
};

/// The parameters that the unknowns set, and the unknown of each.
struct Targets {
  ChangedNumbers numbers;
  std::vector<Index> unknown;
};

Targets targets_of(const ConstantUnknowns& constant, const VectorXd& theta) {
  Targets targets;
  for (Index i = 0; i < constant.size(); ++i)
    for (const auto& parameter : constant.unknown(i).targets) {
      const double scale = theta[i] != 0.0 ? std::abs(theta[i]) : constant.unknown(i).deviation;
      targets.numbers.numbers.push_back(
          {.name = parameter.name, .unit = parameter.unit, .value = theta[i], .scale = scale, .parameter = parameter});
      targets.unknown.push_back(i);
    }
  targets.numbers.changes = VectorXd::Zero(std::ssize(targets.unknown));
  return targets;
}

/// The filter of the motion alone, with the unknowns held.
struct HeldUnknowns {
  EstimationProblemPtr problem;
  AugmentedModelSetup setup;
};

HeldUnknowns hold(const EstimationProblemPtr& problem, const ConstantUnknowns& constant, const VectorXd& theta,
                  int substeps) {
  const NamedUnknowns named(problem, constant.names(), theta);
  auto held = std::make_shared<EstimationProblem>(*named.problem_at(theta));
  held->settings.substeps = substeps;
  held->settings.passes = 1;
  held->settings.likelihood_unknowns.clear();
  IssueList issues;
  auto setup = make_augmented_model_setup(*held, held->structure->parts, {}, issues);
  issues.raise();
  return {std::move(held), std::move(setup)};
}

/// S_k^-1/2 d nu_k / d x, channels and then samples, one column an unknown.
std::optional<MatrixXd> white_derivatives(const RunsBeside& runs, const WhiteInnovations& whiten,
                                          const ConstantUnknowns& constant, const Targets& targets) {
  MatrixXd moved;
  for (const auto& group : runs.groups()) {
    const auto derivatives = runs.derivatives(group);
    for (std::size_t n = 0; n < group.size(); ++n) {
      const auto& means = derivatives[n].means;
      if (!means || !means->innovation.allFinite()) return std::nullopt;
      if (moved.size() == 0) moved.setZero(means->innovation.size(), constant.size());
      const Index i = targets.unknown[group[n]];
      const double in_state = constant.slope(i, constant.estimated[i]) / targets.numbers.numbers[group[n]].scale;
      moved.col(i) += in_state * whiten(means->innovation).reshaped();
    }
  }
  return moved;
}

/// Nothing where rounding decides: where small differences of a motion grow exponentially, as on a strong spring they
/// can, its derivatives by all numbers become parallel.
std::optional<MatrixXd> inverse_of(const MatrixXd& information) {
  constexpr double rounding = 1e-11;  // of tangents, whose error is 1e-6
  const VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(scale.asDiagonal() * information * scale.asDiagonal());
  if (!(modes.eigenvalues().minCoeff() > rounding)) return std::nullopt;
  const VectorXd root = modes.eigenvalues().cwiseSqrt().cwiseInverse();
  const MatrixXd half = scale.asDiagonal() * modes.eigenvectors() * root.asDiagonal();
  return half * half.transpose();
}

}  // namespace

std::optional<UnknownInformation> information_at_estimates(const EstimationProblemPtr& problem, const Record& record,
                                                           const RecordEstimate& estimate, StepBudget& budget) try {
  const ConstantUnknowns constant(*problem, estimate);
  if (constant.size() == 0) return std::nullopt;
  const VectorXd& x = constant.estimated;
  const VectorXd theta = constant.values(x);
  const Targets targets = targets_of(constant, theta);
  const auto [held, setup] = hold(problem, constant, theta, estimate.augmented_model->options().substeps);
  RunsBeside runs(held, setup, record, estimate, {}, targets.numbers);
  if (runs.memory() > most_memory) return std::nullopt;
  if (!budget.take(runs.steps())) return std::nullopt;

  EstimationOptions options = rerun_options(runs.filter().choice.filter, held->settings, estimate);
  options.keep_gains = true;
  EstimationResult result = kalfem::estimate(*runs.filter().choice.augmented_model, runs.filter().input, options);
  if (result.failure || !runs.run_base(std::move(result.gains))) return std::nullopt;
  const WhiteInnovations whiten(result);
  const auto moved = white_derivatives(runs, whiten, constant, targets);
  if (!moved) return std::nullopt;
  const VectorXd precision = constant.prior_deviation.cwiseAbs2().cwiseInverse();
  MatrixXd information = moved->transpose() * *moved;
  information.diagonal() += precision;
  const VectorXd gradient =
      -moved->transpose() * whiten(result.innovation).reshaped() - precision.cwiseProduct(x - constant.prior);
  const auto covariance = inverse_of(information);
  if (!covariance) return std::nullopt;
  UnknownInformation found{constant.places, *covariance, *covariance * gradient};
  const VectorXd about = found.about_the_estimates().diagonal().cwiseSqrt().cwiseQuotient(constant.deviation);
  const VectorXd left = covariance->diagonal().cwiseSqrt().cwiseQuotient(constant.deviation);
  const VectorXd away = found.step.cwiseAbs().cwiseQuotient(constant.deviation);
  found.widening = (left.array() > suspicious_widening || away.array() > far_away).select(about, 0.0);
  return found;
} catch (const InvalidInput&) {
  return std::nullopt;  // at the estimates there is no structure
}

}  // namespace kalfem
