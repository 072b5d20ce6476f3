// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/frf_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "kalfem/linalg/lowest_modes.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double least_remainder = 1e-12;  ///< of a static shape's energy beside the modes, for it to count
constexpr double least_part = 1e-8;        ///< of unit energy that is left beside the other static shapes
constexpr double massless = 1e-14;         ///< mass times the square of the highest line over stiffness
constexpr double same_frequency = 1e-9;

/// What is left of vectors without their part in the modes.
MatrixXd without_modes(MatrixXd vectors, const MatrixXd& modes, const SparseMatrix& mass) {
  for (int pass = 0; pass < 2; ++pass) vectors -= modes * (modes.transpose() * (mass * vectors));
  return vectors;
}

/// Answers to the places, to the inertia of these, and to the dashpots when the modes move.
MatrixXd static_answers(const LinearModel& model, const MatrixXd& places, const MatrixXd& modes,
                        const SparseFactor& factor) {
  const bool dashpots = model.damping.nonZeros() > 0;
  MatrixXd answers(places.rows(), 2 * places.cols() + (dashpots ? modes.cols() : 0));
  answers.leftCols(places.cols()) = factor.solve(places);
  const MatrixXd slow = without_modes(answers.leftCols(places.cols()), modes, model.mass);
  answers.middleCols(places.cols(), places.cols()) = factor.solve(model.mass * slow);
  if (dashpots) answers.rightCols(modes.cols()) = factor.solve(model.damping * modes);
  return answers;
}

/// Static answers without their part in the modes, orthonormal in `energy` = K + s M.
MatrixXd static_remainders(MatrixXd shapes, const MatrixXd& modes, const SparseMatrix& energy,
                           const SparseMatrix& mass) {
  const VectorXd before = shapes.cwiseProduct(energy * shapes).colwise().sum();
  shapes = without_modes(std::move(shapes), modes, mass);
  const VectorXd after = shapes.cwiseProduct(energy * shapes).colwise().sum();
  std::vector<Index> kept;
  for (Index j = 0; j < after.size(); ++j)
    if (after[j] > least_remainder * before[j]) kept.push_back(j);
  const MatrixXd unit = shapes(Eigen::all, kept) * after(kept).cwiseSqrt().cwiseInverse().asDiagonal();
  if (kept.empty()) return unit;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> gram(unit.transpose() * (energy * unit));
  const Index independent = (gram.eigenvalues().array() > least_part).count();
  const VectorXd sizes = gram.eigenvalues().tail(independent).cwiseSqrt();
  return unit * (gram.eigenvectors().rightCols(independent) * sizes.cwiseInverse().asDiagonal());
}

/// Adds shapes that are orthonormal in K + s M and orthogonal to the modes, uncoupled and scaled.
void append(ResponseBasis& basis, const MatrixXd& shapes, const SparseMatrix& mass, double shift, double highest) {
  if (shapes.cols() == 0) return;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> pairs(shapes.transpose() * (mass * shapes));
  const Index first = basis.size(), count = shapes.cols();
  basis.shapes.conservativeResize(Eigen::NoChange, first + count);
  basis.stiffness.conservativeResize(first + count);
  basis.mass.conservativeResize(first + count);
  for (Index j = 0; j < count; ++j) {
    const Index from = count - 1 - j;  // the largest mass has the lowest frequency
    const double m = pairs.eigenvalues()[from];
    const bool has_mass = m * highest * highest > massless;
    basis.shapes.col(first + j) = shapes * pairs.eigenvectors().col(from) / (has_mass ? std::sqrt(m) : 1.0);
    basis.stiffness[first + j] = has_mass ? 1.0 / m - shift : 1.0;
    basis.mass[first + j] = has_mass ? 1.0 : 0.0;
  }
}

/// Number `j` of a list whose last entry holds for all further ones.
double entry_of(const std::vector<double>& ratios, Index j) {
  return ratios[std::min(static_cast<std::size_t>(j), ratios.size() - 1)];
}

/// Which shapes have ratios of their own. All others share the rate of mode `last`; -1: nothing is damped.
struct RatioRange {
  Eigen::Array<bool, Eigen::Dynamic, 1> own;
  Index last = -1;

  RatioRange(const ResponseBasis& basis, const ModalRatios& ratios)
      : own(basis.circular_frequencies().array() <= 2.0 * std::numbers::pi * ratios.up_to) {
    if (!ratios.values.empty()) last = own.head(basis.modes).count() - 1;
  }
};

// C_m is a function of K and M through their modes. Its derivative in the basis of modes is a divided difference of the
// damping rates over the eigenvalues, d_jk = (rate_j - rate_k) / (lambda_j - lambda_k) for a change of K. The cases
// avoid the cancellation of that quotient where the rates are equal, where the frequencies are, or where a common ratio
// makes the rates proportional to omega.
/// Two shapes' share in the derivative of C_m: their circular frequencies and damping rates, and whether both have a
/// ratio of their own.
struct ShapePair {
  double omega_j, omega_k, rate_j, rate_k;
  bool own_ratios;

  [[nodiscard]] double derivative(double a, double b) const {
    const double sum = omega_j + omega_k, difference = omega_j - omega_k;
    if (sum == 0.0) return 0.0;
    const bool same_ratio = rate_j * omega_k == rate_k * omega_j;
    if (own_ratios && (same_ratio || std::abs(difference) <= same_frequency * sum)) {
      const double twice_ratio = (rate_j + rate_k) / sum;
      return twice_ratio * (a + omega_j * omega_k * b) / sum;
    }
    if (rate_j == rate_k || std::abs(difference) <= same_frequency * sum) return 0.5 * (rate_j + rate_k) * b;
    const double lambda_j = omega_j * omega_j, lambda_k = omega_k * omega_k;
    return (a * (rate_j - rate_k) + b * (rate_k * lambda_j - rate_j * lambda_k)) / (sum * difference);
  }
};

}  // namespace

VectorXd ResponseBasis::circular_frequencies() const {
  return (mass.array() > 0.0).select(stiffness.cwiseMax(0.0).cwiseSqrt(), 0.0);
}

// The basis of the response up to a frequency: all modes up to a multiple of it, and static answers for the rest (modal
// truncation augmentation). The static part holds the answers to the loads and outputs, to the inertia of those
// answers, and to the dashpots' forces when the modes move. It is taken without its part in the modes, orthonormalised
// in the energy K + s M, and made uncoupled by its mass: massless directions keep stiffness alone. A small model gets
// all of its coordinates, which makes the basis exact.
ResponseBasis response_basis(const LinearModel& model, const MatrixXd& places, double highest,
                             const ResponseBasisOptions& options) {
  const SparseMatrix& mass = model.mass;
  const StiffnessFactor shifted = factor_stiffness(model.stiffness, mass);
  const double limit = 2.0 * std::numbers::pi * highest;
  const bool exact = mass.rows() <= options.exact_up_to;
  const double below = exact ? std::numeric_limits<double>::max() : std::pow(options.multiple * limit, 2);
  LowestModes modes = lowest_modes(model.stiffness, mass, shifted, {.below = below});
  ResponseBasis basis{std::move(modes.vectors), std::move(modes.values), {}, 0};
  basis.modes = basis.stiffness.size();
  basis.mass = VectorXd::Ones(basis.modes);
  if (basis.modes == mass.rows()) return basis;
  const SparseMatrix energy = model.stiffness + shifted.shift * mass;
  const MatrixXd answers = exact ? shifted.factor.solve(MatrixXd::Identity(mass.rows(), mass.rows()))
                                 : static_answers(model, places, basis.shapes, shifted.factor);
  append(basis, static_remainders(answers, basis.shapes, energy, mass), mass, shifted.shift, limit);
  return basis;
}

VectorXd modal_damping_rates(const ResponseBasis& basis, const ModalRatios& ratios) {
  VectorXd rates = VectorXd::Zero(basis.size());
  const RatioRange range(basis, ratios);
  if (range.last < 0) return rates;
  const VectorXd omega = basis.circular_frequencies();
  for (Index j = 0; j < basis.size(); ++j) {
    const Index from = range.own[j] ? j : range.last;
    if (basis.mass[j] > 0.0) rates[j] = 2.0 * entry_of(ratios.values, from) * omega[from];
  }
  return rates;
}

MatrixXd modal_damping_derivative(const ResponseBasis& basis, const ModalRatios& ratios,
                                  const std::vector<double>& ratio_derivatives, const MatrixXd& stiffness_derivative,
                                  const MatrixXd& mass_derivative) {
  const Index size = basis.size();
  MatrixXd derivative = MatrixXd::Zero(size, size);
  const RatioRange range(basis, ratios);
  if (range.last < 0) return derivative;
  const VectorXd rates = modal_damping_rates(basis, ratios), omega = basis.circular_frequencies();
  const auto entry = [](const MatrixXd& matrix, Index j, Index k) { return matrix.size() == 0 ? 0.0 : matrix(j, k); };
  for (Index j = 0; j < size; ++j)
    for (Index k = 0; k < size; ++k)
      if (basis.mass[j] > 0.0 && basis.mass[k] > 0.0)
        derivative(j, k) = ShapePair{omega[j], omega[k], rates[j], rates[k], range.own[j] && range.own[k]}.derivative(
            entry(stiffness_derivative, j, k), entry(mass_derivative, j, k));
  const auto of_ratio = [&](Index j) {
    return ratio_derivatives.empty() ? 0.0 : 2.0 * entry_of(ratio_derivatives, j) * omega[j];
  };
  const Index c = range.last;
  const double of_frequency =
      omega[c] == 0.0 ? 0.0
                      : entry_of(ratios.values, c) *
                            (entry(stiffness_derivative, c, c) / omega[c] - omega[c] * entry(mass_derivative, c, c));
  for (Index j = 0; j < size; ++j)
    if (basis.mass[j] > 0.0) derivative(j, j) += range.own[j] ? of_ratio(j) : of_ratio(c) + of_frequency;
  return derivative;
}

}  // namespace kalfem
