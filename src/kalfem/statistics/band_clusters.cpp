// SPDX-License-Identifier: Apache-2.0
#include "kalfem/statistics/band_clusters.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include <unsupported/Eigen/FFT>

#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

constexpr double rank_tolerance = 1e-12;
/// Share of a direction's information that other clusters must have to contradict this one.
constexpr double least_share = 1e-4;
constexpr int thirds = 3;  ///< of an octave
constexpr double chance = 0.01;

/// W with A^+ = W W^T, p x rank: coordinates in which the information is one.
MatrixXd whitening(const MatrixXd& information) {
  const VectorXd diagonal = information.diagonal();
  const VectorXd scale = (diagonal.array() > 0.0).select(diagonal.array().max(1e-300).rsqrt(), 0.0);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scale.asDiagonal() * information * scale.asDiagonal());
  const VectorXd& values = eigen.eigenvalues();
  const Index rank = (values.array() > rank_tolerance * values.maxCoeff()).count();
  const VectorXd root = values.tail(rank).cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * eigen.eigenvectors().rightCols(rank) * root.asDiagonal();
}

/// (I - M)^(-1/2) without the directions that M decides alone.
MatrixXd adjustment(const MatrixXd& M) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(MatrixXd::Identity(M.rows(), M.cols()) - M);
  const VectorXd& left = eigen.eigenvalues();
  const VectorXd root = (left.array() > least_share).select(left.array().max(least_share).rsqrt(), 0.0);
  return eigen.eigenvectors() * root.asDiagonal() * eigen.eigenvectors().transpose();
}

/// A cluster in coordinates in which the information is one.
struct WhiteCluster {
  MatrixXd information, adjustment;
  VectorXd contribution;  ///< f_b r_b
};

/// Sets trace and degrees of freedom of one variance: Cov(f_g r_g, f_h r_h) = f_g (delta_gh M_g - M_g M_h) f_h.
void set_expectation(const std::vector<WhiteCluster>& clusters, const VectorXd& direction, double& trace,
                     double& freedom) {
  const auto count = static_cast<Index>(clusters.size());
  MatrixXd adjusted(direction.size(), count), seen(direction.size(), count);
  trace = 0.0;
  VectorXd own(count);
  for (Index g = 0; g < count; ++g) {
    const auto& cluster = clusters[static_cast<std::size_t>(g)];
    adjusted.col(g) = cluster.adjustment * direction;
    seen.col(g) = cluster.information * adjusted.col(g);
    own[g] = adjusted.col(g).dot(seen.col(g));
  }
  MatrixXd covariance = -seen.transpose() * seen;
  covariance.diagonal() += own;
  trace = covariance.trace();
  const double square = covariance.squaredNorm();
  freedom = square > 0.0 ? trace * trace / square : 0.0;
}

}  // namespace

ClusterCovariance cluster_covariance(const std::vector<ScoreCluster>& clusters, const ScoreCluster& prior) {
  MatrixXd information = prior.information;
  VectorXd left = prior.score;
  for (const auto& cluster : clusters) {
    information += cluster.information;
    left += cluster.score;
  }
  const MatrixXd W = whitening(information);
  const VectorXd move = W.transpose() * left;
  MatrixXd of_sum = MatrixXd::Zero(W.cols(), W.cols());
  std::vector<WhiteCluster> white;
  for (const auto& cluster : clusters) {
    const MatrixXd M = W.transpose() * cluster.information * W;
    if (M.trace() <= 0.0) continue;
    const MatrixXd f = adjustment(M);
    white.push_back({M, f, f * (W.transpose() * cluster.score - M * move)});
    of_sum += white.back().contribution * white.back().contribution.transpose();
  }
  ClusterCovariance found{W * of_sum * W.transpose(), VectorXd(W.rows()), VectorXd(W.rows())};
  for (Index i = 0; i < W.rows(); ++i)
    set_expectation(white, W.row(i).transpose(), found.expected[i], found.freedom[i]);
  return found;
}

namespace {

/// Of a power of two of samples, with zeros behind; missing samples count as zero, as the filter learnt nothing there.
VectorXcd spectrum_of(const Eigen::Ref<const Eigen::RowVectorXd>& series, const Eigen::ArrayXd& there, Index length) {
  Eigen::VectorXd padded = VectorXd::Zero(length);
  padded.head(series.size()) = (there > 0.0).select(series.transpose().array(), 0.0).matrix();
  VectorXcd spectrum(length);
  Eigen::FFT<double> fourier;
  fourier.fwd(spectrum, padded);
  return spectrum.head(length / 2 + 1);
}

Index power_of_two(Index samples) {
  Index length = 2;
  while (length < samples) length *= 2;
  return length;
}

/// Thirds of octaves below half the sample rate, at line f of `half`; the constant goes with the lowest line.
Index third_of(Index f, Index half) {
  const double octaves = std::log2(static_cast<double>(half) / static_cast<double>(std::max<Index>(1, f)));
  return static_cast<Index>(std::floor(thirds * octaves + 1e-9));
}

}  // namespace

BandScores::BandScores(const SensitiveInnovations& innovations) {
  for (Index sensor = 0; sensor < innovations.value.rows(); ++sensor) add_sensor(innovations, sensor);
}

void BandScores::add_sensor(const SensitiveInnovations& innovations, Index sensor) {
  const auto parameters = static_cast<Index>(innovations.derivative.size());
  const Index length = power_of_two(innovations.value.cols()), half = length / 2;
  Eigen::ArrayXd there = innovations.value.row(sensor).transpose().array().isFinite().cast<double>();
  for (const auto& derivative : innovations.derivative)
    there *= derivative.row(sensor).transpose().array().isFinite().cast<double>();
  const VectorXcd e = spectrum_of(innovations.value.row(sensor), there, length);
  MatrixXcd d(half + 1, parameters);
  for (Index i = 0; i < parameters; ++i)
    d.col(i) = spectrum_of(innovations.derivative[static_cast<std::size_t>(i)].row(sensor), there, length);
  auto& bands = thirds_.emplace_back(static_cast<std::size_t>(third_of(0, half) + 1),
                                     ScoreCluster{VectorXd::Zero(parameters), MatrixXd::Zero(parameters, parameters)});
  for (Index f = 0; f <= half;) {
    const Index third = third_of(f, half), first = f;
    while (f <= half && third_of(f, half) == third) ++f;
    // Every line stands for its conjugate too, but for the first and the last.
    VectorXd weight = VectorXd::Constant(f - first, 2.0 / static_cast<double>(length));
    if (first == 0) weight[0] *= 0.5;
    if (f == half + 1) weight[f - first - 1] *= 0.5;
    const MatrixXcd lines = d.middleRows(first, f - first);
    const MatrixXcd weighed = weight.cast<std::complex<double>>().asDiagonal() * lines;
    auto& band = bands[static_cast<std::size_t>(third)];
    band.score -= (weighed.adjoint() * e.segment(first, f - first)).real();
    band.information += (weighed.adjoint() * lines).real();
  }
}

std::vector<ScoreCluster> BandScores::octaves(int shift, bool by_sensor) const {
  std::vector<ScoreCluster> clusters;
  if (thirds_.empty()) return clusters;
  const std::size_t bands = thirds_.front().size(), count = (bands - 1 + static_cast<std::size_t>(shift)) / thirds + 1;
  for (std::size_t sensor = 0; sensor < thirds_.size(); ++sensor) {
    if (sensor == 0 || by_sensor) {
      const auto& any = thirds_.front().front();
      clusters.insert(clusters.end(), count, {0.0 * any.score, 0.0 * any.information});
    }
    for (std::size_t band = 0; band < bands; ++band) {
      auto& cluster = clusters[clusters.size() - count + (band + static_cast<std::size_t>(shift)) / thirds];
      cluster.score += thirds_[sensor][band].score;
      cluster.information += thirds_[sensor][band].information;
    }
  }
  return clusters;
}

VectorXd band_variances(const SensitiveInnovations& innovations, const ScoreCluster& prior) {
  const BandScores scores(innovations);
  VectorXd largest = VectorXd::Zero(prior.score.size());
  for (const bool by_sensor : {false, true}) {
    VectorXd variance = VectorXd::Zero(largest.size()), expected = variance, freedom = variance, of_prior = variance;
    for (int shift = 0; shift < thirds; ++shift) {
      const auto clusters = scores.octaves(shift, by_sensor);
      const auto found = cluster_covariance(clusters, prior);
      variance += found.covariance.diagonal() / thirds;
      expected += found.expected / thirds;
      freedom = shift == 0 ? found.freedom : VectorXd(freedom.cwiseMin(found.freedom));
    }
    MatrixXd information = prior.information;
    for (const auto& cluster : scores.octaves(0, false)) information += cluster.information;
    const MatrixXd W = whitening(information), inverse = W * W.transpose();
    of_prior = (inverse * prior.information * inverse).diagonal();
    for (Index i = 0; i < largest.size(); ++i) {
      if (!(freedom[i] > 0.0) || !(expected[i] > 0.0)) continue;
      const double excess = chi_squared_quantile(1.0 - chance, freedom[i]) / freedom[i];
      if (variance[i] > excess * expected[i]) largest[i] = std::max(largest[i], variance[i] + of_prior[i]);
    }
  }
  return largest;
}

}  // namespace kalfem
