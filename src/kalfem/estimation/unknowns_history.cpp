#include "kalfem/estimation/unknowns_history.hpp"

#include "kalfem/linalg/scaled_inverse.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Scores scores_of(const UnknownsHistory& history) {
  const VectorXd& last = history.mean.back();
  const MatrixXd& covariance = history.covariance.back();
  const Index samples = static_cast<Index>(history.mean.size()) - 1;
  Scores scores{MatrixXd(last.size(), samples), MatrixXd(last.size(), samples)};
  ScaledInverse inverse;
  VectorXd weighed, known, weighed_before, known_before;
  for (std::size_t k = 0; k < history.mean.size(); ++k) {
    const MatrixXd& information = inverse(history.covariance[k]);
    weighed = information * (history.mean[k] - last);
    known = (covariance * information).cwiseProduct(covariance).rowwise().sum();
    if (k > 0) {
      scores.value.col(static_cast<Index>(k) - 1) = weighed - weighed_before;
      scores.share.col(static_cast<Index>(k) - 1) = (known - known_before).cwiseQuotient(covariance.diagonal());
    }
    weighed_before.swap(weighed);
    known_before.swap(known);
  }
  return scores;
}

SensitiveInnovations sensitive_innovations(const UnknownsHistory& history, Index first) {
  SensitiveInnovations found;
  const Index count = static_cast<Index>(history.slope.size()) - first;
  if (count < 1) return found;
  const VectorXd moved = history.mean.back() - history.mean.front();
  const MatrixXd deviation = history.deviation.middleCols(first, count);
  found.value = history.at_prior.middleCols(first, count);
  found.derivative.assign(history.unknowns.size(), MatrixXd(deviation.rows(), count));
  for (Index k = 0; k < count; ++k) {
    const MatrixXd& slope = history.slope[static_cast<std::size_t>(first + k)];
    found.value.col(k) -= slope.transpose() * moved;
    for (std::size_t i = 0; i < found.derivative.size(); ++i)
      found.derivative[i].col(k) = -slope.row(static_cast<Index>(i)).transpose().cwiseQuotient(deviation.col(k));
  }
  found.value = found.value.cwiseQuotient(deviation);
  return found;
}

ScoreCluster prior_score(const UnknownsHistory& history) {
  const MatrixXd information = scaled_inverse(history.covariance.front());
  return {information * (history.mean.front() - history.mean.back()), information};
}

RobustCovariance robust_covariance(const UnknownsHistory& history) {
  const Scores scores = scores_of(history);
  return robust_covariance(scaled_inverse(history.covariance.back()), scaled_inverse(history.covariance.front()),
                           scores.value, scores.share);
}

}  // namespace kalfem
