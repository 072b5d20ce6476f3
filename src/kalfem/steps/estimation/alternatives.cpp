// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include "kalfem/identification/runs_beside.hpp"
#include "kalfem/statistics/mixture.hpp"
#include "kalfem/steps/estimation/compute.hpp"

namespace kalfem {

using Eigen::VectorXd;

namespace {

/// ln p(y) of the record as it was measured, whatever gains and delays were found for it.
double evidence_of(const EstimationOutcome& outcome) {
  if (!outcome.failure().empty()) return -std::numeric_limits<double>::infinity();
  const double jacobian = outcome.likelihood ? outcome.likelihood->corrected.log_jacobian.sum() : 0.0;
  return log_likelihood_from(outcome.result, 0) + jacobian;
}

struct WeightedOutcome {
  double weight = 0.0;
  const EstimationOutcome* outcome = nullptr;
};
using PointsOf = std::vector<PointQuantity> EstimationOutcome::*;

/// That quantity by all outcomes that have it.
PointQuantity mixture(const PointQuantity& own, const std::vector<WeightedOutcome>& outcomes, PointsOf points) {
  std::vector<MixedModel> models;
  double sum = 0.0;
  for (const auto& [weight, outcome] : outcomes)
    if (const auto* found = find_quantity(outcome->*points, own.point, own.quantity)) {
      models.push_back({weight, found->mean, found->deviation});
      sum += weight;
    }
  PointQuantity mixed = own;
  if (!(sum > 0.0)) return mixed;
  for (auto& each : models) each.weight /= sum;
  auto [mean, deviation] = mixture_of(models);
  mixed.mean = std::move(mean);
  mixed.deviation = std::move(deviation);
  return mixed;
}

std::vector<PointQuantity> mixtures(const std::vector<WeightedOutcome>& outcomes, PointsOf points,
                                    const EstimationOutcome& own, TruthComparison& comparison) {
  std::vector<PointQuantity> mixed;
  for (const auto& each : own.*points) {
    mixed.push_back(mixture(each, outcomes, points));
    if (each.truth.size() > 0) comparison.compare(mixed.back(), each.truth);
  }
  return mixed;
}

}  // namespace

void run_alternatives(const Study& study, const StudyResults& results, const Progress& progress,
                      EstimationOutcome& outcome) {
  std::vector<std::shared_ptr<EstimationOutcome>> others;
  for (const auto& alternative : study.alternatives) {
    AugmentedModelSetup setup = *alternative.study->augmented_model;
    others.push_back(
        std::make_shared<EstimationOutcome>(run_estimation(*alternative.study, setup, results, {}, progress, {})));
  }
  VectorXd evidences(1 + std::ssize(others));
  evidences[0] = outcome.log_evidence = evidence_of(outcome);
  for (Eigen::Index i = 1; i < evidences.size(); ++i) {
    auto& other = *others[static_cast<std::size_t>(i) - 1];
    evidences[i] = other.log_evidence = evidence_of(other);
  }
  const VectorXd weights = weights_of(evidences);
  outcome.weight = weights[0];
  std::vector<WeightedOutcome> all{{outcome.weight, &outcome}};
  for (std::size_t i = 0; i < others.size(); ++i) {
    others[i]->weight = weights[static_cast<Eigen::Index>(i) + 1];
    if (others[i]->weight > 0.0) all.push_back({others[i]->weight, others[i].get()});
  }
  TruthComparison comparison(outcome.settled, study.sample_rate(), outcome.band);
  auto points = mixtures(all, &EstimationOutcome::points, outcome, comparison);
  auto smoothed = mixtures(all, &EstimationOutcome::smoothed_points, outcome, comparison);
  outcome.points = std::move(points);
  outcome.smoothed_points = std::move(smoothed);
  for (auto& each : others) {
    each->points.clear();
    each->smoothed_points.clear();
    outcome.alternatives.push_back(std::move(each));
  }
}

}  // namespace kalfem
