// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/log_posterior_differences.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "kalfem/base/parallel.hpp"

namespace kalfem {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

Eigen::VectorXd LogPosterior::at(const Eigen::MatrixXd& theta) {
  Eigen::VectorXd values(theta.cols());
  evaluations_ += static_cast<int>(theta.cols());
  for_each_index(static_cast<std::size_t>(theta.cols()), threads_, [&](std::size_t k) {
    stop_if_asked();
    const auto i = static_cast<Eigen::Index>(k);
    const double log_prior = prior().log_density(theta.col(i));
    values[i] = std::isfinite(log_prior) ? log_prior + posterior_.log_likelihood_at(theta.col(i)) : -infinity;
  });
  return values;
}

Eigen::VectorXd LogPosterior::of(const Eigen::MatrixXd& z) {
  Eigen::MatrixXd theta(z.rows(), z.cols());
  for (Eigen::Index k = 0; k < z.cols(); ++k) theta.col(k) = prior().from_standard_normal(z.col(k));
  return at(theta);
}

Eigen::VectorXd LogPosterior::over_normals(const Eigen::MatrixXd& z) {
  Eigen::VectorXd values(z.cols());
  evaluations_ += static_cast<int>(z.cols());
  const double constant = 0.5 * static_cast<double>(z.rows()) * std::log(2.0 * std::numbers::pi);
  for_each_index(static_cast<std::size_t>(z.cols()), threads_, [&](std::size_t k) {
    stop_if_asked();
    const auto i = static_cast<Eigen::Index>(k);
    values[i] = posterior_.log_likelihood_of(z.col(i)) - 0.5 * z.col(i).squaredNorm() - constant;
  });
  return values;
}

Eigen::MatrixXd cross_points(const Eigen::VectorXd& x, const Eigen::VectorXd& steps) {
  Eigen::MatrixXd points = x.replicate(1, 2 * x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    points(i, 2 * i) += steps[i];
    points(i, 2 * i + 1) -= steps[i];
  }
  return points;
}

Differences::Differences(const Eigen::VectorXd& values, double centre, const Eigen::VectorXd& steps)
    : gradient(Eigen::VectorXd::Zero(steps.size())), curvature(Eigen::VectorXd::Zero(steps.size())) {
  for (Eigen::Index i = 0; i < steps.size(); ++i) {
    const double up = values[2 * i], down = values[2 * i + 1], h = steps[i];
    if (std::isfinite(up) && std::isfinite(down)) {
      gradient[i] = (up - down) / (2.0 * h);
      curvature[i] = (up - 2.0 * centre + down) / (h * h);
    } else if (std::isfinite(up) || std::isfinite(down)) {
      gradient[i] = std::isfinite(up) ? (up - centre) / h : (centre - down) / h;
    }
  }
}

LocalDifferences::LocalDifferences(LogDensity log_density, const Eigen::VectorXd& point,
                                   const Eigen::VectorXd& first_steps, const Eigen::VectorXd& lower,
                                   const Eigen::VectorXd& upper)
    : log_density_(std::move(log_density)),
      point_(point),
      value_(log_density_(point)[0]),
      steps_(first_steps),
      lower_(lower),
      upper_(upper) {
  constexpr double wanted_fall = 0.01;
  for (int k = 0; k < 4; ++k) {
    keep_inside();
    const Eigen::VectorXd values = log_density_(cross_points(point_, steps_));
    for (Eigen::Index i = 0; i < steps_.size(); ++i) {
      const double fall = value_ - 0.5 * (values[2 * i] + values[2 * i + 1]);
      steps_[i] *= std::clamp(std::sqrt(wanted_fall / std::max(fall, 1e-300)), 0.1, 10.0);
    }
  }
  keep_inside();
}

Eigen::VectorXd LocalDifferences::gradient() {
  return Differences(log_density_(cross_points(point_, steps_)), value_, steps_).gradient;
}

Eigen::MatrixXd LocalDifferences::hessian() {
  const Eigen::Index size = point_.size();
  Eigen::MatrixXd hessian =
      Differences(log_density_(cross_points(point_, steps_)), value_, steps_).curvature.asDiagonal();
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index j = 0; j < i; ++j) {
      Eigen::MatrixXd points = point_.replicate(1, 4);
      points.row(i) += steps_[i] * Eigen::RowVector4d(1, 1, -1, -1);
      points.row(j) += steps_[j] * Eigen::RowVector4d(1, -1, 1, -1);
      const Eigen::VectorXd values = log_density_(points);
      hessian(i, j) = (values[0] - values[1] - values[2] + values[3]) / (4.0 * steps_[i] * steps_[j]);
      hessian(j, i) = hessian(i, j);
    }
  return hessian;
}

bool LocalDifferences::go(Eigen::VectorXd step) {
  for (int k = 0; k < 4; ++k, step *= 0.5) {
    const double value = log_density_(point_ + step)[0];
    if (!(value >= value_)) continue;
    point_ += step;
    value_ = value;
    return true;
  }
  return false;
}

void LocalDifferences::keep_inside() {
  for (Eigen::Index i = 0; i < steps_.size(); ++i) {
    const double room = std::min(point_[i] - lower_[i], upper_[i] - point_[i]);
    steps_[i] = std::max(std::min(steps_[i], 0.5 * room), 1e-13 * std::max(std::abs(point_[i]), 1e-280));
  }
}

}  // namespace kalfem
