// SPDX-License-Identifier: Apache-2.0
#include "kalfem/modal/modal_model_fit.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "kalfem/base/interruption.hpp"

namespace kalfem {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

constexpr int most_steps = 40, most_halvings = 12;
constexpr double step_tolerance = 1e-9;  ///< of a step, to half the bandwidth
constexpr Index smooth_columns = 6;      ///< real and imaginary parts of c_0, c_1, c_2
constexpr Index correlated_lines = 3;

/// Real parts above imaginary ones, lines weighted.
MatrixXd stacked(const MatrixXcd& columns, const VectorXd& weights) {
  MatrixXd all(2 * columns.rows(), columns.cols());
  all << weights.asDiagonal() * columns.real(), weights.asDiagonal() * columns.imag();
  return all;
}

/// The linear problem at given poles: columns Phi of residues (real and imaginary part of each pole in turn) and of the
/// smooth rest, and their derivatives by the poles. Columns of a pole are in units of its peak.
class Columns {
public:
  Columns(const VectorXd& omega, const VectorXd& weights, const VectorXcd& poles) {
    const Index lines = omega.size(), count = poles.size();
    MatrixXcd all(lines, 2 * count + smooth_columns);
    slopes_.reserve(static_cast<std::size_t>(2 * count));
    unit_ = -poles.real();
    const Complex i(0.0, 1.0);
    for (Index r = 0; r < count; ++r) {
      const VectorXcd own = (i * omega.cast<Complex>().array() - poles[r]).inverse().matrix() * unit_[r],
                      mirrored =
                          (i * omega.cast<Complex>().array() - std::conj(poles[r])).inverse().matrix() * unit_[r];
      all.col(2 * r) = own + mirrored;
      all.col(2 * r + 1) = i * (own - mirrored);
      const VectorXcd own_slope = own.array().square().matrix() / unit_[r],
                      mirrored_slope = mirrored.array().square().matrix() / unit_[r];
      MatrixXcd by_real(lines, 2), by_imaginary(lines, 2);
      by_real << own_slope + mirrored_slope, i * (own_slope - mirrored_slope);
      by_imaginary << i * (own_slope - mirrored_slope), -(own_slope + mirrored_slope);
      slopes_.push_back(stacked(by_real, weights));
      slopes_.push_back(stacked(by_imaginary, weights));
    }
    const VectorXd relative = omega / omega[lines / 2];
    VectorXcd smooth[3] = {VectorXcd::Ones(lines), relative.cast<Complex>(),
                           relative.cwiseAbs2().cwiseInverse().cast<Complex>()};
    for (Index k = 0; k < 3; ++k) {
      smooth[k] /= smooth[k].cwiseAbs().maxCoeff();
      all.col(2 * count + 2 * k) = smooth[k];
      all.col(2 * count + 2 * k + 1) = i * smooth[k];
    }
    values_ = stacked(all, weights);
    factor_ = Eigen::HouseholderQR<MatrixXd>(values_);
    basis_ = factor_.householderQ() * MatrixXd::Identity(values_.rows(), values_.cols());
  }

  [[nodiscard]] const MatrixXd& values() const { return values_; }
  [[nodiscard]] const std::vector<MatrixXd>& slopes() const { return slopes_; }
  [[nodiscard]] const VectorXd& unit() const { return unit_; }
  [[nodiscard]] MatrixXd solve(const MatrixXd& right) const { return factor_.solve(right); }
  /// What the columns do not span.
  [[nodiscard]] MatrixXd beyond(const MatrixXd& columns) const {
    return columns - basis_ * (basis_.transpose() * columns);
  }
  [[nodiscard]] MatrixXd inverse_gram() const {
    const MatrixXd inverse = factor_.matrixQR()
                                 .topRows(values_.cols())
                                 .triangularView<Eigen::Upper>()
                                 .solve(MatrixXd::Identity(values_.cols(), values_.cols()));
    return inverse * inverse.transpose();
  }

private:
  MatrixXd values_, basis_;
  std::vector<MatrixXd> slopes_;
  VectorXd unit_;
  Eigen::HouseholderQR<MatrixXd> factor_;
};

/// Responses as real columns, an input's outputs after another's.
MatrixXd measured_columns(const FittedResponses& responses) {
  MatrixXd all(2 * responses.lines(), responses.outputs() * responses.inputs());
  for (Index i = 0; i < responses.inputs(); ++i)
    all.middleCols(i * responses.outputs(), responses.outputs()) =
        stacked(responses.values[static_cast<std::size_t>(i)], responses.weights);
  return all;
}

/// The fit at some poles.
struct Point {
  VectorXcd poles;
  Columns columns;
  MatrixXd linear;    ///< linear unknowns, one column an FRF
  MatrixXd residual;  ///< measured - fitted

  Point(const FittedResponses& responses, const MatrixXd& measured, const VectorXcd& at)
      : poles(at),
        columns(responses.omega, responses.weights, at),
        linear(columns.solve(measured)),
        residual(measured - columns.values() * linear) {}

  [[nodiscard]] double cost(const VectorXd& weight) const {
    return 0.5 * (residual.colwise().squaredNorm().transpose().array() * weight.array()).sum();
  }
};

/// Normal equations of the poles: G = sum_f w_f c_pf^T D_p^T P D_q c_qf, g = sum_f w_f c_pf^T D_p^T residual_f, with P
/// the projection beyond the columns and D_p the two columns that move with parameter p.
std::pair<MatrixXd, VectorXd> normal_equations(const Point& point, const VectorXd& weight) {
  const auto& slopes = point.columns.slopes();
  const auto count = static_cast<Index>(slopes.size());
  MatrixXd all(slopes.front().rows(), 2 * count);
  for (Index p = 0; p < count; ++p) all.middleCols(2 * p, 2) = slopes[static_cast<std::size_t>(p)];
  const MatrixXd beyond = point.columns.beyond(all), products = beyond.transpose() * beyond;
  const MatrixXd toward = all.transpose() * point.residual;
  MatrixXd normal(count, count);
  VectorXd gradient(count);
  const auto coefficients = [&](Index p) { return point.linear.middleRows(2 * (p / 2), 2); };
  for (Index p = 0; p < count; ++p) {
    const MatrixXd weighted = coefficients(p) * weight.asDiagonal();
    gradient[p] = weighted.cwiseProduct(toward.middleRows(2 * p, 2)).sum();
    for (Index q = 0; q <= p; ++q)
      normal(p, q) = normal(q, p) =
          products.block<2, 2>(2 * p, 2 * q).cwiseProduct(weighted * coefficients(q).transpose()).sum();
  }
  return {normal, gradient};
}

VectorXcd moved(const VectorXcd& poles, const VectorXd& step) {
  VectorXcd result = poles;
  for (Index r = 0; r < poles.size(); ++r) result[r] += Complex(step[2 * r], step[2 * r + 1]);
  return result;
}

/// Scatter of each FRF's real and imaginary parts about the fit.
VectorXd scatter_of(const Point& point) {
  const double freedom = static_cast<double>(std::max<Index>(1, point.residual.rows() - point.columns.values().cols()));
  return (point.residual.colwise().squaredNorm() / freedom).cwiseSqrt().transpose();
}

/// Weight of each FRF; one that the fit explains entirely counts no more than others a thousand times as exact as
/// usual.
VectorXd weights_of(const VectorXd& scatter) {
  const double least = std::max(1e-3 * scatter.mean(), 1e-15);
  return scatter.cwiseMax(least).cwiseAbs2().cwiseInverse();
}

/// 1 + 2 sum_k rho_k over neighbouring lines of the residuals.
double correlation_of(const MatrixXd& residual, Index lines) {
  double sum = 1.0;
  for (Index k = 1; k <= std::min(correlated_lines, lines / 4); ++k) {
    double together = 0.0, alone = 0.0;
    for (const Index first : {Index{0}, lines}) {
      const auto part = residual.middleRows(first, lines);
      together += part.topRows(lines - k).cwiseProduct(part.bottomRows(lines - k)).sum();
      alone += part.squaredNorm();
    }
    sum += 2.0 * std::max(0.0, alone > 0.0 ? together / alone : 0.0);
  }
  return sum;
}

/// One step of Gauss-Newton, shortened until it helps. Nothing where none does.
std::optional<Point> improved(const FittedResponses& responses, const MatrixXd& measured, const Point& point,
                              const VectorXd& weight, double& relative_step) {
  const auto [normal, gradient] = normal_equations(point, weight);
  VectorXd step = normal.ldlt().solve(gradient);
  const double before = point.cost(weight);
  for (int halving = 0; halving < most_halvings && step.allFinite(); ++halving, step *= 0.5) {
    const VectorXcd poles = moved(point.poles, step);
    if ((poles.real().array() >= 0.0).any()) continue;
    Point next(responses, measured, poles);
    relative_step = 0.0;
    for (Index p = 0; p < step.size(); ++p)
      relative_step = std::max(relative_step, std::abs(step[p] / point.poles[p / 2].real()));
    if (next.cost(weight) <= before * (1.0 + 1e-12)) return next;
  }
  return {};
}

}  // namespace

// Two passes: FRFs first count alike, then by the inverse of their scatter about the first fit.
ModalModelFit fit_modal_model(const FittedResponses& responses, const VectorXcd& start) {
  const MatrixXd measured = measured_columns(responses);
  Point point(responses, measured, start);
  ModalModelFit fit;
  VectorXd weight = VectorXd::Ones(measured.cols());
  for (int pass = 0; pass < 2; ++pass) {
    fit.converged = false;
    for (int step = 0; step < most_steps && !fit.converged; ++step) {
      stop_if_asked();
      double relative_step = 0.0;
      auto next = improved(responses, measured, point, weight, relative_step);
      if (next) point = std::move(*next);
      fit.converged = !next || relative_step < step_tolerance;
    }
    fit.scatter = scatter_of(point);
    weight = weights_of(fit.scatter);
  }
  const Index count = point.poles.size(), lines = responses.lines();
  fit.poles = point.poles;
  fit.residues.resize(count, measured.cols());
  const VectorXd& unit = point.columns.unit();
  for (Index r = 0; r < count; ++r) {
    fit.residues.row(r).real() = unit[r] * point.linear.row(2 * r);
    fit.residues.row(r).imag() = unit[r] * point.linear.row(2 * r + 1);
  }
  fit.correlation = correlation_of(point.residual, lines);
  fit.degrees_of_freedom =
      static_cast<double>((2 * lines - point.columns.values().cols()) * measured.cols() - 2 * count) / fit.correlation;
  fit.covariance =
      fit.correlation * normal_equations(point, weight).first.ldlt().solve(MatrixXd::Identity(2 * count, 2 * count));
  VectorXd units(2 * count);
  for (Index r = 0; r < count; ++r) units[2 * r] = units[2 * r + 1] = unit[r];
  fit.linear_covariance = fit.correlation * units.asDiagonal() *
                          point.columns.inverse_gram().topLeftCorner(2 * count, 2 * count) * units.asDiagonal();
  fit.share.resize(count);
  for (Index r = 0; r < count; ++r)
    fit.share[r] = (point.columns.values().middleCols(2 * r, 2) * point.linear.middleRows(2 * r, 2)).squaredNorm() /
                   measured.squaredNorm();
  for (Index p = 0; p < 2 * count; ++p) {
    const MatrixXd moving = -point.columns.solve(point.columns.slopes()[static_cast<std::size_t>(p)] *
                                                 point.linear.middleRows(2 * (p / 2), 2));
    fit.residue_slopes.push_back(units.asDiagonal() * moving.topRows(2 * count));
  }
  return fit;
}

}  // namespace kalfem
