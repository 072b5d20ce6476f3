// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/local_polynomial.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

MatrixXd powers(const VectorXd& abscissae, int degree) {
  MatrixXd matrix = MatrixXd::Ones(abscissae.size(), degree + 1);
  for (int j = 1; j <= degree; ++j) matrix.col(j) = matrix.col(j - 1).cwiseProduct(abscissae);
  return matrix;
}

void check(const Record& record, Index sample, const LocalPolynomialOptions& options) {
  IssueList issues;
  if (sample < 0 || sample >= record.samples())
    issues.add({}, "sample " + std::to_string(sample) + " is outside the record",
               "it has " + std::to_string(record.samples()) + " samples");
  if (!(record.sample_rate > 0.0) || !std::isfinite(record.sample_rate))
    issues.add({}, "the sampling rate is " + std::to_string(record.sample_rate), "it must be positive and finite");
  if (!(options.half_window > 0.0) || !std::isfinite(options.half_window))
    issues.add({}, "half_window is " + std::to_string(options.half_window), "it must be positive and finite");
  if (options.degree < 1 || options.degree > 6)
    issues.add({}, "the polynomial's degree is " + std::to_string(options.degree), "it must be from 1 to 6");
  issues.raise();
}

/// Samples k of a channel as a polynomial in (k - sample) / scale.
struct Window {
  VectorXd offset;
  VectorXd values;
};

Window finite_samples(const MatrixXd& values, Index channel, Index sample, Index reach, double scale) {
  Window window{VectorXd(2 * reach + 1), VectorXd(2 * reach + 1)};
  Index count = 0;
  for (Index k = std::max<Index>(0, sample - reach); k <= std::min(values.cols() - 1, sample + reach); ++k) {
    if (!std::isfinite(values(channel, k))) continue;
    window.offset[count] = static_cast<double>(k - sample) / scale;
    window.values[count++] = values(channel, k);
  }
  window.offset.conservativeResize(count);
  window.values.conservativeResize(count);
  return window;
}

/// Coefficients of the least-squares polynomial and their covariance from the scatter about it.
struct Fit {
  VectorXd coefficients;
  MatrixXd covariance;
};

// Ordinary least squares by QR. With n samples and m coefficients the noise variance is s^2 = |y - A c|^2 / (n - m),
// and cov(c) = s^2 (A^T A)^-1. The scaled abscissae lie in [-1, 1], which keeps A^T A well conditioned up to degree
// 6.
Fit fit(const Window& window, int degree) {
  const MatrixXd matrix = powers(window.offset, degree);
  const VectorXd coefficients = matrix.householderQr().solve(window.values);
  const auto freedom = static_cast<double>(window.values.size() - coefficients.size());
  const double variance = (window.values - matrix * coefficients).squaredNorm() / freedom;
  return {coefficients, variance * (matrix.transpose() * matrix).inverse()};
}

}  // namespace

MatrixXd polynomial_basis(const VectorXd& abscissae, int degree) {
  const double scale = std::max(abscissae.cwiseAbs().maxCoeff(), 1e-300);
  const Eigen::HouseholderQR<MatrixXd> qr(powers(abscissae / scale, degree));
  return qr.householderQ() * MatrixXd::Identity(abscissae.size(), degree + 1);
}

// Fits y = sum_i c_i x^i with x = (k - sample) / scale to each channel. At the sample itself x = 0, so c_0 is the
// position and c_1 the slope per unit of x, which the sampling rate and the scale turn into a velocity. A window at
// the end of the record has fewer samples on one side.
LocalMotion local_motion(const Record& record, Index sample, const LocalPolynomialOptions& options) {
  check(record, sample, options);
  const double widest = static_cast<double>(record.samples());
  const auto reach = static_cast<Index>(std::min(options.half_window * record.sample_rate + 1e-9, widest));
  const double scale = std::max(1.0, static_cast<double>(reach));
  const Index channels = record.values.rows();
  const VectorXd none(channels);
  LocalMotion motion{record.time(sample), none, none, none, none};
  IssueList issues;
  for (Index c = 0; c < channels; ++c) {
    const auto window = finite_samples(record.values, c, sample, reach, scale);
    if (window.values.size() < options.degree + 2) {
      issues.add({},
                 "channel " + std::to_string(c + 1) + " has " + std::to_string(window.values.size()) +
                     " samples near " + std::to_string(record.time(sample)) + " s",
                 "a polynomial of degree " + std::to_string(options.degree) + " and its residual variance need " +
                     std::to_string(options.degree + 2),
                 "increase half_window");
      continue;
    }
    const auto [coefficients, covariance] = fit(window, options.degree);
    motion.position[c] = coefficients[0];
    motion.velocity[c] = coefficients[1] / scale * record.sample_rate;
    motion.position_deviation[c] = std::sqrt(covariance(0, 0));
    motion.velocity_deviation[c] = std::sqrt(covariance(1, 1)) / scale * record.sample_rate;
  }
  issues.raise();
  return motion;
}

}  // namespace kalfem
