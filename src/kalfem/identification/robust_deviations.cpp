// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/robust_deviations.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/base/random.hpp"
#include "kalfem/linalg/scaled_inverse.hpp"
#include "kalfem/statistics/robust_covariance.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

double widening_of(const RecordEstimate& estimate, Index place) {
  const auto& history = estimate.result.unknowns_history;
  const double stated = history.covariance_at(history.last())(place, place);
  return stated > 0.0 ? std::sqrt(estimate.robust.covariance(place, place) / stated) : 1.0;
}

/// Whether the scores widen a deviation by what matters.
bool widens(const RecordEstimate& estimate) {
  for (Index i = 0; i < estimate.robust.covariance.rows(); ++i)
    if (widening_of(estimate, i) > suspicious_widening) return true;
  return false;
}

constexpr int records = 299;

/// The derivatives of the innovations that are there, p x sensors a sample.
std::vector<MatrixXd> slopes_of(const SensitiveInnovations& innovations) {
  const Index count = std::ssize(innovations.derivative), samples = innovations.value.cols();
  std::vector<MatrixXd> slopes(static_cast<std::size_t>(samples), MatrixXd::Zero(count, innovations.value.rows()));
  for (Index k = 0; k < samples; ++k)
    for (Index j = 0; j < innovations.value.rows(); ++j)
      for (Index i = 0; i < count && std::isfinite(innovations.value(j, k)); ++i)
        slopes[static_cast<std::size_t>(k)](i, j) = innovations.derivative[static_cast<std::size_t>(i)](j, k);
  return slopes;
}

/// How far robust_covariance() widens the deviations of a right model by chance: the largest factor of each parameter
/// over 299 records in which the innovations are white and of size one, with the derivatives of this record, so that it
/// is exceeded once in three hundred times; or over as many as it takes until every factor that matters of those that
/// were `found` is exceeded. Where a record says little of a parameter, its score is a small difference of
/// large ones, and the scatter of these along time is itself hardly known. The numbers are drawn from one seed: the
/// same record gives the same factors. `prior`: the information of the prior, p x p.
VectorXd widening_by_chance(const SensitiveInnovations& innovations, const Eigen::Ref<const MatrixXd>& prior,
                            const VectorXd& found) {
  const auto slopes = slopes_of(innovations);
  const Index count = prior.rows(), samples = std::ssize(slopes), sensors = innovations.value.rows();
  MatrixXd information = prior;
  for (const auto& slope : slopes) information += slope * slope.transpose();
  const MatrixXd covariance = scaled_inverse(information);
  MatrixXd shares(count, samples), scores(count, samples);
  for (Index k = 0; k < samples; ++k)
    shares.col(k) =
        (covariance * slopes[static_cast<std::size_t>(k)]).rowwise().squaredNorm().cwiseQuotient(covariance.diagonal());
  RandomStream random(1, "widening by chance");
  VectorXd largest = VectorXd::Ones(count), innovation(sensors);
  const auto exceeds_all = [&] {
    return (found.array() < suspicious_widening || largest.array() >= found.array()).all();
  };
  for (int record = 0; record < records && !exceeds_all(); ++record) {
    for (Index k = 0; k < samples; ++k) {
      for (double& value : innovation) value = random.normal();
      scores.col(k) = -slopes[static_cast<std::size_t>(k)] * innovation;
    }
    const MatrixXd robust = robust_covariance(information, prior, scores, shares).covariance;
    largest = largest.cwiseMax(robust.diagonal().cwiseQuotient(covariance.diagonal()).cwiseMax(0.0).cwiseSqrt());
  }
  return largest;
}

/// Of a run whose innovations agree with the model, the stated deviation holds where chance widens it as far.
void forgive_chance(RecordEstimate& estimate) {
  if (!widens(estimate) || innovations_contradict(estimate, estimate.settled)) return;
  const auto& history = estimate.result.unknowns_history;
  const auto innovations = sensitive_innovations(history, estimate.settled);
  if (innovations.derivative.empty()) return;
  VectorXd found(estimate.robust.covariance.rows());
  for (Index i = 0; i < found.size(); ++i) found[i] = widening_of(estimate, i);
  const VectorXd chance = widening_by_chance(innovations, prior_score(history).information, found);
  for (Index i = 0; i < found.size(); ++i) {
    if (found[i] < suspicious_widening || found[i] > chance[i]) continue;
    estimate.robust.covariance.row(i) /= found[i];
    estimate.robust.covariance.col(i) /= found[i];
  }
}

/// Frequency bands of a run whose numbers agree with its model contradict each other by chance only.
void widen_by_bands(RecordEstimate& estimate) {
  if (!contradicts_itself(estimate)) return;
  const auto& history = estimate.result.unknowns_history;
  const auto innovations = sensitive_innovations(history, estimate.settled);
  if (!innovations.derivative.empty()) widen(estimate.robust, band_variances(innovations, prior_score(history)));
}

/// Whether a robust deviation that is stated is larger than the filter's by what matters.
bool states_more(const RecordEstimate& estimate) {
  const auto& deviation = estimate.result.unknowns.deviation;
  const auto stated = deviation.col(deviation.cols() - 1).array();
  return (estimate.robust_deviation.array() > suspicious_widening * stated).any();
}

}  // namespace

bool innovations_contradict(const RecordEstimate& estimate, Index first) {
  return std::ranges::any_of(
      innovation_reasons(innovations_of(estimate.measurements, estimate.result, first)),
      [](const Reason& reason) { return reason.code.starts_with("innovation_") || reason.code.starts_with("nis_"); });
}

bool contradicts_itself(const RecordEstimate& estimate) {
  return widens(estimate) || innovations_contradict(estimate, estimate.settled);
}

InnovationRecord innovations_of(const Record& measured, const EstimationResult& result, Index first) {
  InnovationRecord record{.noise = measured.noise(),
                          .innovation = result.innovation,
                          .deviation = result.innovation_deviation,
                          .sample_rate = measured.sample_rate,
                          .start = measured.start,
                          .first = first,
                          .nis = result.nis,
                          .measured = result.measured};
  if (result.noise && result.noise->sensors_adapt) {
    const Index count = result.noise->sensors.cols() - first;
    record.noise = result.noise->sensors.rightCols(count).cwiseAbs2().rowwise().mean().cwiseSqrt();
    record.adapted_noise = true;
  }
  for (const auto& channel : measured.channels) {
    record.sensors.push_back(channel.name);
    record.units.push_back(channel.unit);
  }
  return record;
}

InnovationRecord innovations_of(const RecordEstimate& estimate) {
  return innovations_of(estimate.measurements, estimate.result, estimate.settled);
}

/// In coordinates in which the filter's covariance is I, an eigenvalue of the robust one less 1 is its excess.
MatrixXd excess_of(const RecordEstimate& estimate) {
  const auto& history = estimate.result.unknowns_history;
  if (estimate.result.failure || history.empty() || !states_more(estimate)) return {};
  const MatrixXd stated = history.covariance_at(history.last());
  const VectorXd scale = stated.diagonal().cwiseSqrt();
  if (!(scale.array() > 0.0).all()) return {};
  const auto correlated = [&](const MatrixXd& covariance) {
    return MatrixXd(scale.cwiseInverse().asDiagonal() * covariance * scale.cwiseInverse().asDiagonal());
  };
  const Eigen::LLT<MatrixXd> root(correlated(stated));
  if (root.info() != Eigen::Success) return {};
  const MatrixXd half = root.matrixL().solve(correlated(estimate.robust.covariance));
  const Eigen::SelfAdjointEigenSolver<MatrixXd> robust(root.matrixL().solve(half.transpose()));
  const VectorXd excess = (robust.eigenvalues().array() - 1.0).cwiseMax(0.0).sqrt();
  return scale.asDiagonal() * (root.matrixL() * (robust.eigenvectors() * excess.asDiagonal()));
}

void set_robust_deviations(RecordEstimate& estimate) {
  const auto& history = estimate.result.unknowns_history;
  const auto& unknowns = estimate.augmented_model->options().unknowns;
  estimate.robust_deviation.setConstant(static_cast<Index>(unknowns.size()), std::numeric_limits<double>::quiet_NaN());
  if (estimate.result.failure || history.empty()) return;
  estimate.robust = robust_covariance(history);
  forgive_chance(estimate);
  widen_by_bands(estimate);
  for (std::size_t i = 0; i < history.unknowns.size(); ++i) {
    const Index unknown = history.unknowns[i], place = static_cast<Index>(i);
    const auto& transform = unknowns[static_cast<std::size_t>(unknown)].transform;
    estimate.robust_deviation[unknown] =
        transform.slope(history.mean(place, history.last())) * std::sqrt(estimate.robust.covariance(place, place));
  }
}

}  // namespace kalfem
