// SPDX-License-Identifier: Apache-2.0
#include "kalfem/modal/response_modes.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/modal/shape_measures.hpp"
#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

/// The least MAC of a singular vector with the shape of its mode.
constexpr double least_agreement = 0.8;

/// d(frequency [Hz], damping) / d(Re lambda, Im lambda).
Eigen::Matrix2d slopes_of_mode(Complex pole) {
  const double size = std::abs(pole), a = pole.real(), b = pole.imag();
  Eigen::Matrix2d slopes;
  slopes << a, b, -b * b / (size * size), a * b / (size * size);
  slopes.row(0) /= 2.0 * std::numbers::pi * size;
  slopes.row(1) /= size;
  return slopes;
}

/// A complex vector as its real parts above its imaginary ones.
VectorXd in_parts(const VectorXcd& values) {
  VectorXd parts(2 * values.size());
  parts << values.real(), values.imag();
  return parts;
}

/// What the residues of one pole say of its shape.
struct ShapeOfPole {
  VectorXcd values;     ///< R v, one an output
  MatrixXd covariance;  ///< of its parts
};

ShapeOfPole shape_of_pole(const ModalModelFit& fit, Index pole, Index inputs, Index outputs) {
  const VectorXcd row = fit.residues.row(pole).transpose();
  const MatrixXcd residues = Eigen::Map<const MatrixXcd>(row.data(), outputs, inputs);
  const Eigen::JacobiSVD<MatrixXcd> svd(residues, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorXcd v = svd.matrixV().col(0);
  ShapeOfPole shape{residues * v, MatrixXd::Zero(2 * outputs, 2 * outputs)};
  const Eigen::Matrix2d own = fit.linear_covariance.block<2, 2>(2 * pole, 2 * pole);
  for (Index i = 0; i < inputs; ++i) {
    Eigen::Matrix2d turn;
    turn << v[i].real(), -v[i].imag(), v[i].imag(), v[i].real();
    const Eigen::Matrix2d turned = turn * own * turn.transpose();
    for (Index o = 0; o < outputs; ++o) {
      const double variance = fit.scatter[i * outputs + o] * fit.scatter[i * outputs + o];
      shape.covariance(o, o) += variance * turned(0, 0);
      shape.covariance(o, outputs + o) += variance * turned(0, 1);
      shape.covariance(outputs + o, o) += variance * turned(1, 0);
      shape.covariance(outputs + o, outputs + o) += variance * turned(1, 1);
    }
  }
  MatrixXd slopes(2 * outputs, std::ssize(fit.residue_slopes));
  for (Index p = 0; p < slopes.cols(); ++p) {
    const auto& all = fit.residue_slopes[static_cast<std::size_t>(p)];
    VectorXcd change(all.cols());
    change.real() = all.row(2 * pole).transpose();
    change.imag() = all.row(2 * pole + 1).transpose();
    slopes.col(p) = in_parts(Eigen::Map<const MatrixXcd>(change.data(), outputs, inputs) * v);
  }
  shape.covariance += slopes * fit.covariance * slopes.transpose();
  return shape;
}

/// The shape in the outputs' units with its largest entry 1: d(s / s_top) = (ds - (s / s_top) ds_top) / s_top.
void normalise(ShapeOfPole& shape, const VectorXd& scale) {
  const Index outputs = scale.size();
  VectorXcd physical = scale.cwiseProduct(shape.values);
  Index top = 0;
  physical.cwiseAbs().maxCoeff(&top);
  const Complex largest = physical[top];
  shape.values = physical / largest;
  MatrixXcd change = MatrixXcd::Zero(outputs, outputs);
  change.diagonal() = scale.cast<Complex>() / largest;
  change.col(top) -= shape.values * (scale[top] / largest);
  MatrixXd in_real(2 * outputs, 2 * outputs);
  in_real << change.real(), -change.imag(), change.imag(), change.real();
  shape.covariance = in_real * shape.covariance * in_real.transpose();
}

}  // namespace

IdentifiedMode mode_of_fit(const ModalModelFit& fit, Index pole, Index inputs, const VectorXd& scale) {
  const Complex value = fit.poles[pole];
  IdentifiedMode mode{.frequency = std::abs(value) / (2.0 * std::numbers::pi),
                      .damping = -value.real() / std::abs(value),
                      .covariance = {},
                      .degrees_of_freedom = fit.degrees_of_freedom,
                      .shape = {},
                      .shape_covariance = {},
                      .participation = fit.share[pole]};
  const Eigen::Matrix2d slopes = slopes_of_mode(value);
  mode.covariance = slopes * fit.covariance.block<2, 2>(2 * pole, 2 * pole) * slopes.transpose();
  ShapeOfPole shape = shape_of_pole(fit, pole, inputs, scale.size());
  normalise(shape, scale);
  mode.shape = shape.values;
  mode.shape_covariance = shape.covariance;
  mode.phase_collinearity = phase_collinearity(mode.shape);
  return mode;
}

bool stands_out(const ModalModelFit& fit, Index pole, Index lines) {
  constexpr double by_chance = 1e-3;
  const Eigen::Matrix2d precision = fit.linear_covariance.block<2, 2>(2 * pole, 2 * pole).inverse();
  double squares = 0.0;
  for (Index f = 0; f < fit.residues.cols(); ++f) {
    const Eigen::Vector2d parts(fit.residues(pole, f).real(), fit.residues(pole, f).imag());
    squares += parts.dot(precision * parts) / (fit.scatter[f] * fit.scatter[f]);
  }
  const auto freedom = static_cast<double>(2 * fit.residues.cols());
  return squares > chi_squared_quantile(1.0 - by_chance / static_cast<double>(lines), freedom);
}

std::optional<SpectralMode> indicated_mode(const FittedResponses& responses, const IdentifiedMode& mode,
                                           const VectorXcd& shape) {
  const VectorXd hertz = responses.omega / (2.0 * std::numbers::pi);
  Index nearest = 0;
  (hertz.array() - mode.frequency).abs().minCoeff(&nearest);
  const double spacing = (hertz[hertz.size() - 1] - hertz[0]) / static_cast<double>(hertz.size() - 1);
  const auto reach = static_cast<Index>(std::max(3.0, std::ceil(mode.damping * mode.frequency / spacing)));
  const Index first = std::max<Index>(1, nearest - reach), last = std::min(hertz.size() - 2, nearest + reach);
  const auto at = [&](Index line) {
    MatrixXcd values(responses.outputs(), responses.inputs());
    for (Index i = 0; i < responses.inputs(); ++i)
      values.col(i) = responses.values[static_cast<std::size_t>(i)].row(line).transpose();
    return Eigen::JacobiSVD<MatrixXcd>(values, Eigen::ComputeThinU);
  };
  std::optional<SpectralMode> best;
  double before = first <= last ? at(first - 1).singularValues()[0] : 0.0;
  for (Index line = first; line <= last; ++line) {
    const auto here = at(line);
    const double value = here.singularValues()[0], after = at(line + 1).singularValues()[0];
    const double agreement = mac(here.matrixU().col(0), shape);
    const bool is_peak = value > before && value >= after && agreement >= least_agreement;
    if (is_peak && (!best || std::abs(hertz[line] - mode.frequency) < std::abs(best->frequency - mode.frequency)))
      best = SpectralMode{hertz[line], agreement};
    before = value;
  }
  return best;
}

}  // namespace kalfem
