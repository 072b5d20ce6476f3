#include "kalfem/statistics/robust_covariance.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Autocorrelations beyond this belong to series that do not settle within the record.
constexpr double largest_autocorrelation = 0.9999;
/// Bandwidth in sums of neighbouring samples from which these are added up further.
constexpr double fine_bandwidth = 100.0;
constexpr Index batches = 25;
/// 99 % quantile of chi-squared with 24 degrees of freedom, per degree.
constexpr double batch_excess = 42.98 / 24.0;

double parzen(double x) {
  if (x <= 0.5) return 1.0 - 6.0 * x * x * (1.0 - x);
  return x < 1.0 ? 2.0 * (1.0 - x) * (1.0 - x) * (1.0 - x) : 0.0;
}

/// Andrews' plug-in bandwidth. Every series has the same weight, whatever its unit.
double plug_in_bandwidth(const MatrixXd& series) {
  const Index samples = series.cols();
  double above = 0.0, below = 0.0;
  for (Index i = 0; i < series.rows(); ++i) {
    const auto before = series.row(i).head(samples - 1), after = series.row(i).tail(samples - 1);
    const double power = series.row(i).squaredNorm();
    if (power == 0.0) continue;
    const double rho =
        std::clamp(before.dot(after) / before.squaredNorm(), -largest_autocorrelation, largest_autocorrelation);
    const double residual = (1.0 - rho * rho) * power;
    const double scale = residual * residual / (power * power) / std::pow(1.0 - rho, 4);
    above += scale * 4.0 * rho * rho / std::pow(1.0 - rho, 4);
    below += scale;
  }
  if (below == 0.0) return 1.0;
  const double bandwidth = 2.6614 * std::pow(above / below * static_cast<double>(samples), 0.2);
  return std::clamp(bandwidth, 1.0, static_cast<double>(samples) / 2.0);
}

MatrixXd kernel_sum(const MatrixXd& series, double bandwidth) {
  MatrixXd sum = series * series.transpose();
  for (Index lag = 1; static_cast<double>(lag) < bandwidth; ++lag) {
    const Index pairs = series.cols() - lag;
    const MatrixXd product = series.leftCols(pairs) * series.rightCols(pairs).transpose();
    sum += parzen(static_cast<double>(lag) / bandwidth) * (product + product.transpose());
  }
  return sum;
}

/// Sums over so many neighbouring samples; the last one may have fewer.
MatrixXd added_up(const MatrixXd& series, Index neighbours) {
  MatrixXd sums((series.rows()), (series.cols() + neighbours - 1) / neighbours);
  for (Index j = 0; j < sums.cols(); ++j)
    sums.col(j) =
        series.middleCols(j * neighbours, std::min(neighbours, series.cols() - j * neighbours)).rowwise().sum();
  return sums;
}

/// Variance of each series' sum from the scatter of its sums over batches.
VectorXd batch_variances(const MatrixXd& series) {
  const Index length = series.cols() / batches, used = length * batches;
  const MatrixXd sums = added_up(series.leftCols(used), length);
  const VectorXd mean = sums.rowwise().mean();
  const double scale = static_cast<double>(series.cols()) / static_cast<double>(used);
  return scale * static_cast<double>(batches) / static_cast<double>(batches - 1) *
         (sums.colwise() - mean).rowwise().squaredNorm();
}

}  // namespace

LongRunCovariance long_run_covariance(const Eigen::Ref<const MatrixXd>& series) {
  if (series.cols() < 2) return {MatrixXd::Zero(series.rows(), series.rows())};
  // Series of very different sizes: each by its own root mean square until the end.
  const VectorXd size = series.rowwise().norm().cwiseMax(1e-300);
  const MatrixXd scaled = size.cwiseInverse().asDiagonal() * series;
  LongRunCovariance found;
  found.bandwidth = plug_in_bandwidth(scaled);
  const auto neighbours = std::max<Index>(1, static_cast<Index>(found.bandwidth / fine_bandwidth));
  const MatrixXd sums = added_up(scaled, neighbours);
  found.of_sum = kernel_sum(sums, found.bandwidth / static_cast<double>(neighbours));
  if (series.cols() >= 4 * batches) {
    const VectorXd of_batches = batch_variances(scaled);
    VectorXd widening = VectorXd::Ones(series.rows());
    for (Index i = 0; i < series.rows(); ++i) {
      const double variance = found.of_sum(i, i);
      if (!(of_batches[i] > batch_excess * variance) || variance <= 0.0) continue;
      widening[i] = std::sqrt(of_batches[i] / variance);
      found.batch_means = true;
    }
    found.of_sum = widening.asDiagonal() * found.of_sum * widening.asDiagonal();
  }
  found.of_sum = size.asDiagonal() * found.of_sum * size.asDiagonal();
  return found;
}

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

RobustCovariance sandwich(const Eigen::Ref<const MatrixXd>& information, const Eigen::Ref<const MatrixXd>& of_sum) {
  const Bread bread = inverse_of(information);
  return {.covariance = bread.inverse * of_sum * bread.inverse, .rank = bread.rank, .condition = bread.condition};
}

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
