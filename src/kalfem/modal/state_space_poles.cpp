// SPDX-License-Identifier: Apache-2.0
#include "kalfem/modal/state_space_poles.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/modal/block_covariance.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Complex = std::complex<double>;

/// The model of one order in its eigenvectors.
struct StateModel {
  Index order, rows_up;  ///< rows of O_up
  MatrixXd U;            ///< O, m x order
  MatrixXd complement;   ///< U_2, m x (m - order)
  MatrixXd A;
  Eigen::LDLT<MatrixXd> gram;  ///< of O_up^T O_up
  VectorXcd lambda;
  MatrixXcd phi;  ///< right eigenvectors, by columns
  MatrixXcd chi;  ///< left eigenvectors, by rows: chi phi = 1

  StateModel(const Subspace& subspace, Index order)
      : order(order),
        rows_up(subspace.rows() - subspace.channels),
        U(subspace.left.leftCols(order)),
        complement(subspace.left.rightCols(subspace.rows() - order)),
        gram(U.topRows(rows_up).transpose() * U.topRows(rows_up)) {
    A = gram.solve(U.topRows(rows_up).transpose() * U.bottomRows(rows_up));
    const Eigen::EigenSolver<MatrixXd> eigen(A);
    if (eigen.info() != Eigen::Success) return;
    lambda = eigen.eigenvalues();
    phi = eigen.eigenvectors();
    chi = phi.inverse();
  }

  /// (O_down - O_up A) phi, what the least squares leave.
  [[nodiscard]] VectorXcd residual(Index i) const {
    return U.bottomRows(rows_up) * phi.col(i) - lambda[i] * (U.topRows(rows_up) * phi.col(i));
  }
  /// U_2^T S_up^T v: rows of O_up back in all rows.
  [[nodiscard]] VectorXcd up(const VectorXcd& v) const { return complement.topRows(rows_up).transpose() * v; }
  [[nodiscard]] VectorXcd down(const VectorXcd& v) const { return complement.bottomRows(rows_up).transpose() * v; }
};

/// [df; dzeta] of dmu.
void put_deviation(Complex mu, Complex change, Eigen::Ref<Eigen::MatrixXd> column) {
  const double size = std::abs(mu), radial = (std::conj(mu) * change).real() / size;
  column(0, 0) = radial / (2.0 * std::numbers::pi);
  column(1, 0) = -change.real() / size + mu.real() * radial / (size * size);
}

Index largest(const VectorXcd& shape) {
  Index row = 0;
  shape.cwiseAbs().maxCoeff(&row);
  return row;
}

/// Those of the eigenvalues that are modes or steady vibrations, in the upper half of the plane. The latter lie on the
/// unit circle but for the record's length.
std::vector<Index> vibrating(const StateModel& model, const PoleOptions& options) {
  constexpr double beyond = 1e-3;
  std::vector<Index> chosen;
  for (Index i = 0; i < model.lambda.size(); ++i) {
    const Complex lambda = model.lambda[i];
    if (lambda.imag() <= 0.0 || std::abs(lambda) >= 1.0 + beyond) continue;
    const Complex mu = std::log(lambda);
    if (-mu.real() <= options.largest_damping * std::abs(mu)) chosen.push_back(i);
  }
  return chosen;
}

/// chi^T dA phi = x^T F phi + z^T F b of the modes in `chosen`, blocks x modes.
MatrixXcd eigenvalue_deviations(const Subspace& subspace, const StateModel& model, const std::vector<Index>& chosen) {
  const auto count = static_cast<Index>(chosen.size());
  const Index rest = model.complement.cols();
  const MatrixXd F = subspace.deviations(model.order);
  MatrixXcd x(rest, count), z(rest, count);
  MatrixXd factors(model.order, 4 * count);  // real and imaginary parts of phi and b
  const auto up = model.U.topRows(model.rows_up);
  for (Index c = 0; c < count; ++c) {
    const Index i = chosen[static_cast<std::size_t>(c)];
    const VectorXcd chi = model.chi.row(i).transpose(),
                    b = model.gram.solve(chi.real()) + Complex(0.0, 1.0) * model.gram.solve(chi.imag());
    const VectorXcd a = up * b;
    x.col(c) = model.down(a) - model.lambda[i] * model.up(a);
    z.col(c) = model.up(model.residual(i));
    factors.col(4 * c) = model.phi.col(i).real();
    factors.col(4 * c + 1) = model.phi.col(i).imag();
    factors.col(4 * c + 2) = b.real();
    factors.col(4 * c + 3) = b.imag();
  }
  const MatrixXd moved = F * factors;
  MatrixXcd change(subspace.blocks, count);
  for (Index block = 0; block < subspace.blocks; ++block)
    for (Index c = 0; c < count; ++c) {
      const auto part = moved.block(block * rest, 4 * c, rest, 4);
      const Complex along = Complex(x.col(c).real().dot(part.col(0)) - x.col(c).imag().dot(part.col(1)),
                                    x.col(c).real().dot(part.col(1)) + x.col(c).imag().dot(part.col(0)));
      const Complex across = Complex(z.col(c).real().dot(part.col(2)) - z.col(c).imag().dot(part.col(3)),
                                     z.col(c).real().dot(part.col(3)) + z.col(c).imag().dot(part.col(2)));
      change(block, c) = along + across;
    }
  return change;
}

}  // namespace

Index memory_in_blocks(const StatePole& pole, const PoleOptions& options, Index blocks) {
  const double decay = options.sample_rate / (2.0 * std::abs(pole.value.real()));  // [samples]
  const double wanted = std::ceil(2.5 * decay / static_cast<double>(options.block_length));
  return std::clamp<Index>(static_cast<Index>(std::min(wanted, 1e6)), 1, std::max<Index>(1, blocks / 10));
}

std::vector<StatePole> poles_of_order(const Subspace& subspace, Index order, const PoleOptions& options) {
  const StateModel model(subspace, order);
  const auto chosen = vibrating(model, options);
  if (chosen.empty()) return {};
  const MatrixXcd changes = eigenvalue_deviations(subspace, model, chosen);
  const MatrixXcd G = subspace.first_lags.topRows(order).cast<Complex>();
  std::vector<StatePole> poles;
  for (std::size_t c = 0; c < chosen.size(); ++c) {
    const Index i = chosen[c];
    StatePole pole{.order = order, .value = std::log(model.lambda[i]) * options.sample_rate};
    pole.frequency = std::abs(pole.value) / (2.0 * std::numbers::pi);
    pole.damping = -pole.value.real() / std::abs(pole.value);
    const VectorXcd shape = model.U.topRows(subspace.channels) * model.phi.col(i);
    const Complex scale = shape[largest(shape)];
    pole.shape = shape / scale;
    const Eigen::RowVectorXcd g = model.chi.row(i) * G;
    pole.participation = (shape(subspace.reference_rows).cwiseProduct(g.transpose()) / model.lambda[i]).sum().real() *
                         2.0 / static_cast<double>(subspace.references());
    pole.deviations.resize(2, subspace.blocks);
    for (Index block = 0; block < subspace.blocks; ++block)
      put_deviation(pole.value, changes(block, static_cast<Index>(c)) / model.lambda[i] * options.sample_rate,
                    pole.deviations.col(block));
    const auto covariance = block_covariance(pole.deviations, memory_in_blocks(pole, options, subspace.blocks));
    pole.frequency_std = std::sqrt(covariance.of_mean(0, 0));
    pole.damping_std = std::sqrt(covariance.of_mean(1, 1));
    pole.degrees_of_freedom = covariance.degrees_of_freedom;
    poles.push_back(std::move(pole));
  }
  std::ranges::sort(poles, {}, &StatePole::frequency);
  return poles;
}

MatrixXd shape_deviations(const Subspace& subspace, const StatePole& pole, const PoleOptions& options) {
  const StateModel model(subspace, pole.order);
  Index i = 0;
  (model.lambda.array() - std::exp(pole.value / options.sample_rate)).abs().minCoeff(&i);
  const Index rest = model.complement.cols(), channels = subspace.channels;
  const MatrixXd F = subspace.deviations(pole.order);
  const VectorXcd z = model.up(model.residual(i)), phi = model.phi.col(i);
  const MatrixXd up = model.U.topRows(model.rows_up).transpose() * model.complement.topRows(model.rows_up),
                 down = model.U.topRows(model.rows_up).transpose() * model.complement.bottomRows(model.rows_up);
  const auto C = model.U.topRows(channels);
  const VectorXcd shape = C * phi;
  const Index top = largest(shape);
  MatrixXd found(2 * channels, subspace.blocks);
  for (Index block = 0; block < subspace.blocks; ++block) {
    const auto own = F.middleRows(block * rest, rest);
    const VectorXcd moved = own * phi;
    const VectorXcd right = down * moved - model.lambda[i] * (up * moved) + own.transpose() * z;
    VectorXcd part = model.chi * (model.gram.solve(right.real()) + Complex(0.0, 1.0) * model.gram.solve(right.imag()));
    for (Index j = 0; j < part.size(); ++j) part[j] = j == i ? 0.0 : part[j] / (model.lambda[i] - model.lambda[j]);
    const VectorXcd change = model.complement.topRows(channels) * moved + C * (model.phi * part);
    const VectorXcd relative = (change - pole.shape * change[top]) / shape[top];
    found.col(block) << relative.real(), relative.imag();
  }
  return found;
}

}  // namespace kalfem
