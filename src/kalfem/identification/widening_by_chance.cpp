// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/widening_by_chance.hpp"

#include <cmath>

#include "kalfem/base/random.hpp"
#include "kalfem/linalg/scaled_inverse.hpp"
#include "kalfem/statistics/robust_covariance.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int records = 99;

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

}  // namespace

VectorXd widening_by_chance(const SensitiveInnovations& innovations, const Eigen::Ref<const MatrixXd>& prior) {
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
  for (int record = 0; record < records; ++record) {
    for (Index k = 0; k < samples; ++k) {
      for (double& value : innovation) value = random.normal();
      scores.col(k) = -slopes[static_cast<std::size_t>(k)] * innovation;
    }
    const MatrixXd robust = robust_covariance(information, prior, scores, shares).covariance;
    largest = largest.cwiseMax(robust.diagonal().cwiseQuotient(covariance.diagonal()).cwiseMax(0.0).cwiseSqrt());
  }
  return largest;
}

}  // namespace kalfem
