// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/unknowns_history.hpp"

#include "kalfem/linalg/scaled_inverse.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Scores scores_of(const UnknownsHistory& history) {
  const VectorXd last = history.mean.col(history.last());
  const MatrixXd covariance = history.covariance_at(history.last());
  Scores scores{MatrixXd(last.size(), history.last()), MatrixXd(last.size(), history.last())};
  ScaledInverse inverse;
  VectorXd weighed, known, weighed_before, known_before;
  for (Index k = 0; k < history.points(); ++k) {
    const MatrixXd& information = inverse(history.covariance_at(k));
    weighed = information * (history.mean.col(k) - last);
    known = (covariance * information).cwiseProduct(covariance).rowwise().sum();
    if (k > 0) {
      scores.value.col(k - 1) = weighed - weighed_before;
      scores.share.col(k - 1) = (known - known_before).cwiseQuotient(covariance.diagonal());
    }
    weighed_before.swap(weighed);
    known_before.swap(known);
  }
  return scores;
}

SensitiveInnovations sensitive_innovations(const UnknownsHistory& history, Index first) {
  SensitiveInnovations found;
  const Index count = history.samples_with_slopes() - first;
  if (count < 1) return found;
  const VectorXd moved = history.mean.col(history.last()) - history.mean.col(0);
  const MatrixXd deviation = history.deviation.middleCols(first, count);
  found.value = history.at_prior.middleCols(first, count);
  found.derivative.assign(history.unknowns.size(), MatrixXd(deviation.rows(), count));
  for (Index k = 0; k < count; ++k) {
    const auto slope = history.slope_at(first + k);
    found.value.col(k) -= slope.transpose() * moved;
    for (std::size_t i = 0; i < found.derivative.size(); ++i)
      found.derivative[i].col(k) = -slope.row(static_cast<Index>(i)).transpose().cwiseQuotient(deviation.col(k));
  }
  found.value = found.value.cwiseQuotient(deviation);
  return found;
}

ScoreCluster prior_score(const UnknownsHistory& history) {
  const MatrixXd information = scaled_inverse(history.covariance_at(0));
  return {information * (history.mean.col(0) - history.mean.col(history.last())), information};
}

RobustCovariance robust_covariance(const UnknownsHistory& history) {
  const Scores scores = scores_of(history);
  return robust_covariance(scaled_inverse(history.covariance_at(history.last())),
                           scaled_inverse(history.covariance_at(0)), scores.value, scores.share);
}

}  // namespace kalfem
