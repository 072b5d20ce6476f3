// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/student_mixture.hpp"

#include <cmath>
#include <numbers>

#include "kalfem/sampling/evidence.hpp"

namespace kalfem {
namespace {

Eigen::MatrixXd factor_of(Eigen::MatrixXd covariance) {
  if (const Eigen::LLT<Eigen::MatrixXd> factor(covariance); factor.info() == Eigen::Success) return factor.matrixL();
  covariance.diagonal().array() += 1e-10 * covariance.diagonal().maxCoeff() + 1e-300;
  return covariance.llt().matrixL();
}

}  // namespace

StudentDistribution::StudentDistribution(const NormalApproximation& scale, int degrees)
    : mean_(scale.mean), factor_(factor_of(scale.covariance)), degrees_(degrees) {
  const auto size = static_cast<double>(mean_.size());
  log_constant_ = -factor_.diagonal().array().log().sum();
  if (degrees == 0)
    log_constant_ -= 0.5 * size * std::log(2.0 * std::numbers::pi);
  else
    log_constant_ += std::lgamma(0.5 * (degrees + size)) - std::lgamma(0.5 * degrees) -
                     0.5 * size * std::log(degrees * std::numbers::pi);
}

double StudentDistribution::log_density(const Eigen::VectorXd& z) const {
  const double square = factor_.triangularView<Eigen::Lower>().solve(z - mean_).squaredNorm();
  if (degrees_ == 0) return log_constant_ - 0.5 * square;
  return log_constant_ - 0.5 * static_cast<double>(degrees_ + mean_.size()) * std::log1p(square / degrees_);
}

Eigen::VectorXd StudentDistribution::draw(RandomStream& random) const {
  Eigen::VectorXd step(mean_.size());
  for (auto& value : step) value = random.normal();
  double chi_square = 0.0;
  for (int k = 0; k < degrees_; ++k) chi_square += std::pow(random.normal(), 2);
  if (degrees_ > 0) step *= std::sqrt(degrees_ / chi_square);
  return mean_ + factor_ * step;
}

double StudentMixture::log_density(const Eigen::VectorXd& z) const {
  Eigen::VectorXd terms(static_cast<Eigen::Index>(components.size()));
  for (std::size_t d = 0; d < components.size(); ++d)
    terms[static_cast<Eigen::Index>(d)] = std::log(shares[d]) + components[d].log_density(z);
  return log_sum_exp(terms);
}

Eigen::VectorXd StudentMixture::draw(double place, RandomStream& random) const {
  std::size_t d = 0;
  for (double reached = shares[0]; d + 1 < components.size() && place >= reached;) reached += shares[++d];
  return components[d].draw(random);
}

}  // namespace kalfem
