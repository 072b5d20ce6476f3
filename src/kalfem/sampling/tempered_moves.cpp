// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/tempered_moves.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/base/parallel.hpp"

namespace kalfem {

TemperedMover::TemperedMover(const Posterior& posterior, const TemperedOptions& options, double exponent,
                             const Population& archive, const Eigen::VectorXd& probability, double scale)
    : posterior_(posterior), options_(options), exponent_(exponent), archive_(archive.z), scale_(scale) {
  const Eigen::MatrixXd centred = archive_.colwise() - Eigen::VectorXd(archive_ * probability);
  Eigen::MatrixXd covariance = centred * probability.asDiagonal() * centred.transpose();
  covariance.diagonal().array() += 1e-12 * covariance.diagonal().maxCoeff() + 1e-300;
  factor_ = covariance.llt().matrixL();
  double reached = 0.0;
  for (const double value : probability) cumulative_.push_back(reached += value);
}

double TemperedMover::acceptance() const {
  return static_cast<double>(accepted_) / static_cast<double>(std::max(1LL, evaluations_));
}

void TemperedMover::round(Population& now, std::vector<RandomStream>& random, int number) {
  std::vector<char> accepted(static_cast<std::size_t>(now.z.cols()), 0);
  const Kind kind = number % 2 == 0 ? Kind::walk : number % 8 == 7 ? Kind::jump : Kind::difference;
  for_each_index(accepted.size(), options_.threads, [&](std::size_t i) {
    stop_if_asked();
    accepted[i] = move(now, static_cast<Eigen::Index>(i), random[i], kind) ? 1 : 0;
  });
  const auto count = std::count(accepted.begin(), accepted.end(), 1);
  accepted_ += count;
  evaluations_ += static_cast<long long>(accepted.size());
  if (kind == Kind::walk) adapt(static_cast<double>(count) / static_cast<double>(accepted.size()));
}

void TemperedMover::adapt(double rate) {
  scale_ = std::clamp(scale_ * std::exp(2.0 * (rate - options_.acceptance)), 1e-4, 4.0);
}

Eigen::Index TemperedMover::draw(RandomStream& random) const {
  const auto found = std::lower_bound(cumulative_.begin(), cumulative_.end(), random.uniform() * cumulative_.back());
  return std::min<Eigen::Index>(found - cumulative_.begin(), archive_.cols() - 1);
}

Eigen::VectorXd TemperedMover::proposal(const Eigen::VectorXd& z, RandomStream& random, Kind kind) const {
  Eigen::VectorXd step(z.size());
  for (auto& value : step) value = random.normal();
  const double size = 2.38 / std::sqrt(static_cast<double>(z.size()));
  if (kind == Kind::walk) return z + scale_ * size * (factor_ * step);
  const Eigen::Index first = draw(random), second = draw(random);
  const double gain = kind == Kind::jump ? 1.0 : size / std::numbers::sqrt2 * random.uniform();
  return z + gain * (archive_.col(first) - archive_.col(second)) + 0.05 * scale_ * size * (factor_ * step);
}

bool TemperedMover::move(Population& now, Eigen::Index i, RandomStream& random, Kind kind) const {
  const Eigen::VectorXd z = now.z.col(i);
  const Eigen::VectorXd proposed = proposal(z, random, kind);
  const double log_uniform = std::log(random.uniform());
  const double value = posterior_.log_likelihood_of(proposed);
  if (!std::isfinite(value)) return false;
  const double ratio = exponent_ * (value - now.log_likelihood[i]) + 0.5 * (z.squaredNorm() - proposed.squaredNorm());
  if (log_uniform >= ratio) return false;
  now.z.col(i) = proposed;
  now.log_likelihood[i] = value;
  return true;
}

}  // namespace kalfem
