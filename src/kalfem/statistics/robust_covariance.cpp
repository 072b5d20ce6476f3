// SPDX-License-Identifier: Apache-2.0
#include "kalfem/statistics/robust_covariance.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

namespace {

/// Autocorrelations beyond this belong to series that do not settle within the record.
constexpr double largest_autocorrelation = 0.9999;
/// Bandwidth in sums of neighbouring samples from which these are added up further.
constexpr double fine_bandwidth = 100.0;
constexpr Index batches = 25;
/// 99 % quantile of chi-squared with 24 degrees of freedom, per degree.
constexpr double batch_excess = 42.98 / 24.0;
/// Sums over neighbours tell a slow part if there are so many, and if neighbours are correlated beyond chance.
constexpr Index fewest_sums = 32;
constexpr double significant = 2.33;  ///< 99 % quantile of a normal variable
/// Share of the variance that the centring of the scores may have taken away.
constexpr double largest_loss = 0.8;

double parzen(double x) {
  if (x <= 0.5) return 1.0 - 6.0 * x * x * (1.0 - x);
  return x < 1.0 ? 2.0 * (1.0 - x) * (1.0 - x) * (1.0 - x) : 0.0;
}

/// First-order autocorrelation, within the range of series that settle.
double autocorrelation_of(const Eigen::Ref<const RowVectorXd>& series) {
  const Index pairs = series.size() - 1;
  const double power = series.head(pairs).squaredNorm();
  if (power == 0.0) return 0.0;
  const double rho = series.head(pairs).dot(series.tail(pairs)) / power;
  return std::clamp(rho, -largest_autocorrelation, largest_autocorrelation);
}

/// Andrews' plug-in bandwidth. Every series has the same weight, whatever its unit.
double plug_in_bandwidth(const MatrixXd& series) {
  const auto samples = static_cast<double>(series.cols());
  double above = 0.0, below = 0.0;
  for (Index i = 0; i < series.rows(); ++i) {
    if (series.row(i).isZero(0.0)) continue;
    const double rho = autocorrelation_of(series.row(i));
    const double scale = std::pow((1.0 - rho * rho) / ((1.0 - rho) * (1.0 - rho)), 2);
    above += scale * 4.0 * rho * rho / std::pow(1.0 - rho, 4);
    below += scale;
  }
  if (below == 0.0) return 1.0;
  const double bandwidth = 2.6614 * std::pow(above / below * samples, 0.2);
  return std::clamp(bandwidth, 1.0, std::max(1.0, samples / 2.0));
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

/// Whether neighbours are positively correlated beyond chance; a burst counts as the few samples that it is.
bool neighbours_agree(const Eigen::Ref<const RowVectorXd>& series) {
  const Index pairs = series.size() - 1;
  const Eigen::ArrayXd products = series.head(pairs).array() * series.tail(pairs).array();
  return products.sum() > significant * std::sqrt(products.square().sum());
}

/// The longest plug-in bandwidth of the series and of its sums over 2, 4, 8 ... neighbours. In the sums, the fast
/// part of a series averages out, and the first-order model sees the slow one.
double bandwidth_of(const MatrixXd& series) {
  double longest = plug_in_bandwidth(series);
  MatrixXd sums = series;
  for (double neighbours = 2.0; sums.cols() >= 2 * fewest_sums; neighbours *= 2.0) {
    sums = added_up(sums, 2);
    for (Index i = 0; i < sums.rows(); ++i)
      if (neighbours_agree(sums.row(i))) longest = std::max(longest, neighbours * plug_in_bandwidth(sums.row(i)));
  }
  return std::min(longest, std::max(1.0, static_cast<double>(series.cols()) / 2.0));
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

/// Share of each variance that is lost because the scores sum to zero at the estimate, sum_kl w(k - l) p_k p_l: the
/// score of a sample with the share p_k of the information is smaller by p_k times the sum.
VectorXd lost_to_centring(const MatrixXd& shares, double bandwidth) {
  VectorXd lost = kernel_sum(shares, bandwidth).diagonal();
  return lost.cwiseMin(largest_loss);
}

/// Shares of the information, each row of sum one; equal ones where none are given.
MatrixXd shares_of(const MatrixXd& series, const Eigen::Ref<const MatrixXd>& given) {
  MatrixXd shares = given.size() == 0 ? MatrixXd::Ones(series.rows(), series.cols()) : MatrixXd(given.cwiseMax(0.0));
  for (Index i = 0; i < shares.rows(); ++i) {
    const double sum = shares.row(i).sum();
    shares.row(i) = sum > 0.0 ? RowVectorXd(shares.row(i) / sum)
                              : RowVectorXd::Constant(shares.cols(), 1.0 / static_cast<double>(shares.cols()));
  }
  return shares;
}

}  // namespace

LongRunCovariance long_run_covariance(const Eigen::Ref<const MatrixXd>& series,
                                      const Eigen::Ref<const MatrixXd>& information) {
  if (series.cols() < 2) return {MatrixXd::Zero(series.rows(), series.rows())};
  // Series of very different sizes: each by its own root mean square until the end.
  const VectorXd size = series.rowwise().norm().cwiseMax(1e-300);
  const MatrixXd scaled = size.cwiseInverse().asDiagonal() * series, shares = shares_of(series, information);
  LongRunCovariance found;
  found.bandwidth = bandwidth_of(scaled);
  const auto neighbours = std::max<Index>(1, static_cast<Index>(found.bandwidth / fine_bandwidth));
  const double bandwidth = found.bandwidth / static_cast<double>(neighbours);
  found.of_sum = kernel_sum(added_up(scaled, neighbours), bandwidth);
  VectorXd widening = (1.0 - lost_to_centring(added_up(shares, neighbours), bandwidth).array()).rsqrt();
  if (series.cols() >= 4 * batches) {
    const VectorXd of_batches = batch_variances(scaled);
    for (Index i = 0; i < series.rows(); ++i) {
      const double variance = widening[i] * widening[i] * found.of_sum(i, i);
      if (!(of_batches[i] > batch_excess * variance) || variance <= 0.0) continue;
      widening[i] *= std::sqrt(of_batches[i] / variance);
      found.batch_means = true;
    }
  }
  widening = widening.cwiseProduct(size);
  found.of_sum = widening.asDiagonal() * found.of_sum * widening.asDiagonal();
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
                                   const Eigen::Ref<const MatrixXd>& scores, const Eigen::Ref<const MatrixXd>& shares) {
  const Bread bread = inverse_of(information);
  // What each sample moved every parameter by: a parameter may be slow where its score, which others share, is not.
  const LongRunCovariance moved = long_run_covariance(bread.inverse * scores, shares);
  return {.covariance = moved.of_sum + bread.inverse * prior_information * bread.inverse,
          .bandwidth = moved.bandwidth,
          .batch_means = moved.batch_means,
          .rank = bread.rank,
          .condition = bread.condition};
}

void widen(RobustCovariance& robust, const Eigen::Ref<const VectorXd>& variances) {
  VectorXd& widening = robust.widening_by_bands;
  widening.setOnes(variances.size());
  for (Index i = 0; i < variances.size(); ++i) {
    const double own = robust.covariance(i, i);
    if (own > 0.0 && variances[i] > own) widening[i] = std::sqrt(variances[i] / own);
  }
  robust.covariance = widening.asDiagonal() * robust.covariance * widening.asDiagonal();
}

MatrixXd white_robust_covariance(const Eigen::Ref<const MatrixXd>& information,
                                 const Eigen::Ref<const MatrixXd>& scores) {
  const MatrixXd inverse = inverse_of(information).inverse;
  return inverse * scores * scores.transpose() * inverse;
}

}  // namespace kalfem
