// SPDX-License-Identifier: Apache-2.0
#include "kalfem/correlation/modal_mixing.hpp"

#include <cmath>

#include "kalfem/statistics/maximum_likelihood.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double usual_error = 0.03, error_spread = 1.5, noise_spread = 1.0;  // spreads: of logarithms
constexpr double least_error = 1e-4, largest_error = 1.0, least_noise = 1e-3, largest_noise = 1e3;
constexpr int starts = 7;  ///< along either parameter

/// A shape in coordinates of the space that the model's shapes span, and how much of it lies outside.
struct SpannedShape {
  explicit SpannedShape(const MatchedShape& shape) : mode(shape.mode) {
    const Index entries = shape.model.rows(), spanned = std::min(entries, shape.model.cols());
    const Eigen::HouseholderQR<MatrixXd> factor(shape.model);
    modes = factor.matrixQR().topRows(spanned).triangularView<Eigen::Upper>();
    const VectorXd turned = factor.householderQ().adjoint() * shape.measured;
    measured = turned.head(spanned);
    outside = turned.tail(entries - spanned).squaredNorm();
    others = static_cast<double>(entries - spanned);
    scale = modes.col(mode).dot(measured) / modes.col(mode).squaredNorm();
  }

  Index mode;
  MatrixXd modes;
  VectorXd measured;
  double outside = 0.0, others = 0.0;  ///< sum of squares and number of the coordinates without motion of the model
  double scale = 1.0;                  ///< a, by least squares
};

/// ln p of the shape, its scale being free, less a constant.
double log_density(const SpannedShape& shape, VectorXd deviations, double noise) {
  deviations *= std::abs(shape.scale);
  deviations[shape.mode] = 0.0;
  const MatrixXd mixed = shape.modes * deviations.asDiagonal();
  MatrixXd covariance = mixed * mixed.transpose();
  covariance.diagonal().array() += noise * noise;
  const Eigen::LLT<MatrixXd> factor(covariance);
  const VectorXd mode = factor.matrixL().solve(shape.modes.col(shape.mode)),
                 measured = factor.matrixL().solve(shape.measured);
  const double size = mode.squaredNorm(), along = mode.dot(measured);
  return -factor.matrixLLT().diagonal().array().log().sum() - 0.5 * std::log(size) -
         0.5 * (measured.squaredNorm() - along * along / size) - shape.others * std::log(noise) -
         0.5 * shape.outside / (noise * noise);
}

}  // namespace

VectorXd mixing_deviations(const VectorXd& frequencies, Index mode, double stiffness_error) {
  const Eigen::ArrayXd ratio = frequencies.array() / frequencies[mode];  // of frequencies: omega_j / omega_i
  const Eigen::ArrayXd gap = 1.0 / ratio - ratio;
  VectorXd deviations = stiffness_error / (stiffness_error * stiffness_error + gap.square()).sqrt();
  deviations[mode] = 1.0;
  return deviations;
}

ModalMixing fit_modal_mixing(const std::vector<MatchedShape>& shapes, const VectorXd& frequencies) {
  const std::vector<SpannedShape> spanned(shapes.begin(), shapes.end());
  const auto densities = [&](const VectorXd& logarithms) -> std::optional<VectorXd> {
    VectorXd values(std::ssize(spanned));
    for (Index i = 0; i < values.size(); ++i) {
      const auto& shape = spanned[static_cast<std::size_t>(i)];
      const VectorXd deviations = mixing_deviations(frequencies, shape.mode, std::exp(logarithms[0]));
      values[i] = log_density(shape, deviations, std::exp(logarithms[1]));
    }
    return values;
  };
  std::vector<LikelihoodParameter> parameters = {
      {.prior_mean = std::log(usual_error),
       .prior_deviation = error_spread,
       .lower = std::log(least_error),
       .upper = std::log(largest_error)},
      {.prior_deviation = noise_spread, .lower = std::log(least_noise), .upper = std::log(largest_noise)}};
  double best = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < starts; ++i)
    for (int j = 0; j < starts; ++j) {
      Vector2d at;
      double value = 0.0;
      for (int k = 0; k < 2; ++k) {
        const auto& each = parameters[static_cast<std::size_t>(k)];
        at[k] = each.lower + (k == 0 ? i + 0.5 : j + 0.5) / starts * (each.upper - each.lower);
        value -= 0.5 * std::pow((at[k] - each.prior_mean) / each.prior_deviation, 2);
      }
      value += densities(at)->sum();
      if (!(value > best)) continue;
      best = value;
      for (int k = 0; k < 2; ++k) parameters[static_cast<std::size_t>(k)].start = at[k];
    }
  const auto found = maximise_likelihood(densities, parameters);
  return {std::exp(found->estimate[0]), std::exp(found->estimate[1])};
}

}  // namespace kalfem
