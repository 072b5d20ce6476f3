#include "kalfem/statistics/robust_covariance.hpp"

#include "kalfem/statistics/long_run_covariance.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double rank_tolerance = 1e-12;

/// A^+ with every parameter scaled so that the diagonal of A is one, in the place of a rank that depends on units.
struct Bread {
  MatrixXd inverse;
  Index rank = 0;
  double condition = 1.0;
};

Bread inverse_of(const Eigen::Ref<const MatrixXd>& information) {
  const VectorXd diagonal = information.diagonal();
  const VectorXd scale = (diagonal.array() > 0.0).select(diagonal.array().max(1e-300).rsqrt(), 0.0);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scale.asDiagonal() * information * scale.asDiagonal());
  const VectorXd& values = eigen.eigenvalues();
  const double largest = values.size() > 0 ? values.tail(1)[0] : 0.0, least = rank_tolerance * largest;
  Bread bread{MatrixXd::Zero(information.rows(), information.cols())};
  for (Index i = 0; i < values.size(); ++i) {
    if (!(values[i] > least)) continue;
    if (bread.rank++ == 0) bread.condition = largest / values[i];
    const VectorXd direction = scale.asDiagonal() * eigen.eigenvectors().col(i);
    bread.inverse += direction * direction.transpose() / values[i];
  }
  return bread;
}

}  // namespace

RobustCovariance robust_covariance(const Eigen::Ref<const MatrixXd>& information,
                                   const Eigen::Ref<const MatrixXd>& prior_information,
                                   const Eigen::Ref<const MatrixXd>& scores) {
  const Bread bread = inverse_of(information);
  const LongRunCovariance filling = long_run_covariance(scores);
  return {bread.inverse * (filling.of_sum + prior_information) * bread.inverse, filling.bandwidth, filling.batch_means,
          bread.rank, bread.condition};
}

MatrixXd white_robust_covariance(const Eigen::Ref<const MatrixXd>& information,
                                 const Eigen::Ref<const MatrixXd>& scores) {
  const MatrixXd inverse = inverse_of(information).inverse;
  return inverse * scores * scores.transpose() * inverse;
}

}  // namespace kalfem
