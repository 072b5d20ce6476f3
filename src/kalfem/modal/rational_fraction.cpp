// SPDX-License-Identifier: Apache-2.0
#include "kalfem/modal/rational_fraction.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

namespace kalfem {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::VectorXcd;

/// The part of the unit circle that the band covers: FRFs are not periodic, which the rest takes up.
constexpr double covered = 0.9;
constexpr double nominal_error = 0.05;
constexpr double ridge = 1e-12;  ///< of the mean of a diagonal: high powers hardly differ on the part that is covered

double angle_at(double place) { return std::numbers::pi * ((1.0 - covered) + 2.0 * covered * place); }

/// Angle of a complex number in [0, 2 pi).
double full_angle(Complex z) {
  const double angle = std::arg(z);
  return angle < 0.0 ? angle + 2.0 * std::numbers::pi : angle;
}

}  // namespace

RationalFraction::RationalFraction(const FittedResponses& responses, Index max_degree)
    : outputs_(responses.outputs()),
      inputs_(responses.inputs()),
      max_degree_(max_degree),
      first_(responses.omega[0]),
      last_(responses.omega[responses.lines() - 1]),
      angle_per_omega_((angle_at(1.0) - angle_at(0.0)) / (last_ - first_)) {
  const Index lines = responses.lines(), powers = 2 * max_degree + 1;
  MatrixXcd z(lines, powers);
  for (Index k = 0; k < lines; ++k) {
    const double angle = angle_at(0.0) + angle_per_omega_ * (responses.omega[k] - first_);
    for (Index d = 0; d < powers; ++d) z(k, d) = std::polar(1.0, angle * static_cast<double>(d - max_degree));
  }
  const Eigen::VectorXd squares = responses.weights.cwiseAbs2();
  const MatrixXcd weighted = z.transpose() * squares.asDiagonal();
  basis_sums_ = weighted.rowwise().sum();
  cross_sums_.resize(powers, outputs_ * inputs_);
  power_sums_.resize(powers, inputs_ * inputs_);
  for (Index i = 0; i < inputs_; ++i) {
    const auto& of_input = responses.values[static_cast<std::size_t>(i)];
    cross_sums_.middleCols(i * outputs_, outputs_) = weighted * of_input;
    for (Index j = 0; j < inputs_; ++j)
      power_sums_.col(i * inputs_ + j) =
          weighted * of_input.conjugate().cwiseProduct(responses.values[static_cast<std::size_t>(j)]).rowwise().sum();
  }
}

/// R of the powers 0 ... n: R_rs = sum w^2 conj(z^r) z^s.
MatrixXcd RationalFraction::basis_gram(Index degree) const {
  MatrixXcd gram(degree + 1, degree + 1);
  for (Index r = 0; r <= degree; ++r)
    for (Index s = 0; s <= degree; ++s) gram(r, s) = basis_sums_[max_degree_ + s - r];
  gram.diagonal().array() += ridge * basis_sums_[max_degree_];
  return gram;
}

/// S_o = sum w^2 conj(z^r) z^s H_oi: rows r, columns (s, i).
MatrixXcd RationalFraction::cross(Index degree, Index output) const {
  MatrixXcd sums(degree + 1, (degree + 1) * inputs_);
  for (Index s = 0; s <= degree; ++s)
    for (Index i = 0; i < inputs_; ++i)
      for (Index r = 0; r <= degree; ++r)
        sums(r, s * inputs_ + i) = cross_sums_(max_degree_ + s - r, i * outputs_ + output);
  return sums;
}

/// sum_o T_o.
MatrixXcd RationalFraction::gram(Index degree) const {
  MatrixXcd sums((degree + 1) * inputs_, (degree + 1) * inputs_);
  for (Index s = 0; s <= degree; ++s)
    for (Index r = 0; r <= degree; ++r)
      for (Index i = 0; i < inputs_; ++i)
        for (Index j = 0; j < inputs_; ++j)
          sums(r * inputs_ + i, s * inputs_ + j) = power_sums_(max_degree_ + s - r, i * inputs_ + j);
  return sums;
}

std::vector<StatePole> RationalFraction::poles(Index degree) const {
  const Index rest = degree * inputs_;
  const Eigen::LLT<MatrixXcd> basis(basis_gram(degree));
  MatrixXcd reduced = gram(degree);
  std::vector<MatrixXcd> solved;  // L^-1 S_o
  for (Index o = 0; o < outputs_; ++o) {
    solved.push_back(basis.matrixL().solve(cross(degree, o)));
    reduced.selfadjointView<Eigen::Lower>().rankUpdate(solved.back().adjoint(), -1.0);
  }
  reduced.triangularView<Eigen::StrictlyUpper>() = reduced.adjoint();
  const MatrixXcd coefficients =
      reduced.bottomRightCorner(rest, rest).ldlt().solve(MatrixXcd(-reduced.bottomLeftCorner(rest, inputs_)));
  MatrixXcd all(rest + inputs_, inputs_);  // A_0 = 1, then A_1 ... A_n
  all << MatrixXcd::Identity(inputs_, inputs_), coefficients;
  MatrixXcd numerators(outputs_ * (degree + 1), inputs_);  // B_o one below the other
  for (Index o = 0; o < outputs_; ++o)
    numerators.middleRows(o * (degree + 1), degree + 1) =
        basis.matrixU().solve(solved[static_cast<std::size_t>(o)] * all);

  // 1 + sum z^r A_r = 0 in y = 1 / z: y^n + sum y^(n - r) A_r, a block companion matrix whose eigenvectors end with x.
  MatrixXcd companion = MatrixXcd::Zero(rest, rest);
  for (Index r = 0; r < degree; ++r)
    companion.block(0, r * inputs_, inputs_, inputs_) = -coefficients.middleRows(r * inputs_, inputs_);
  if (degree > 1)
    companion.bottomLeftCorner(rest - inputs_, rest - inputs_) = MatrixXcd::Identity(rest - inputs_, rest - inputs_);
  const Eigen::ComplexEigenSolver<MatrixXcd> eigen(companion);
  std::vector<StatePole> found;
  for (Index j = 0; j < rest; ++j) {
    const Complex z = 1.0 / eigen.eigenvalues()[j];
    if (!(std::abs(z) < 1.0) || !(std::abs(z) > 0.0)) continue;
    StatePole pole = pole_at(z, numerators, degree, eigen.eigenvectors().col(j).tail(inputs_));
    if (pole.value.imag() >= first_ && pole.value.imag() <= last_ && pole.shape.allFinite())
      found.push_back(std::move(pole));
  }
  return found;
}

StatePole RationalFraction::pole_at(Complex z, const MatrixXcd& numerators, Index degree,
                                    const VectorXcd& null_vector) const {
  StatePole pole{.order = degree * inputs_};
  const double angle = full_angle(z) - angle_at(0.0);
  pole.value = {std::log(std::abs(z)) / angle_per_omega_, first_ + angle / angle_per_omega_};
  pole.frequency = std::abs(pole.value) / (2.0 * std::numbers::pi);
  pole.damping = -pole.value.real() / std::abs(pole.value);
  VectorXcd powers(degree + 1);
  for (Index r = 0; r <= degree; ++r) powers[r] = std::pow(z, static_cast<double>(r));
  const VectorXcd moving = numerators * null_vector;
  pole.shape.resize(outputs_);
  for (Index o = 0; o < outputs_; ++o)
    pole.shape[o] = powers.cwiseProduct(moving.segment(o * (degree + 1), degree + 1)).sum();
  Index top = 0;
  pole.shape.cwiseAbs().maxCoeff(&top);
  pole.shape /= Complex(pole.shape[top]);
  pole.frequency_std = nominal_error * pole.damping * pole.frequency;
  pole.damping_std = nominal_error * pole.damping;
  return pole;
}

}  // namespace kalfem
