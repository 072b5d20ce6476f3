#include "kalfem/estimation/unknowns_history.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// P^-1 by parts of each unknown's own deviation: their units differ by many orders.
MatrixXd inverse_of(const MatrixXd& covariance) {
  const VectorXd scale = covariance.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatrixXd correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  const MatrixXd inverse = correlation.ldlt().solve(MatrixXd::Identity(covariance.rows(), covariance.cols()));
  return scale.asDiagonal() * (0.5 * (inverse + inverse.transpose())) * scale.asDiagonal();
}

}  // namespace

MatrixXd scores_of(const UnknownsHistory& history) {
  const VectorXd& last = history.mean.back();
  MatrixXd scores(last.size(), static_cast<Index>(history.mean.size()) - 1);
  VectorXd before;
  for (std::size_t k = 0; k < history.mean.size(); ++k) {
    VectorXd weighed = inverse_of(history.covariance[k]) * (history.mean[k] - last);
    if (k > 0) scores.col(static_cast<Index>(k) - 1) = weighed - before;
    before = std::move(weighed);
  }
  return scores;
}

RobustCovariance robust_covariance(const UnknownsHistory& history) {
  return robust_covariance(inverse_of(history.covariance.back()), inverse_of(history.covariance.front()),
                           scores_of(history));
}

}  // namespace kalfem
