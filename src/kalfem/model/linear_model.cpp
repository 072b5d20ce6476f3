// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/linear_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/lowest_modes.hpp"

namespace kalfem {

namespace {

/// Of the largest eigenvalue: what rounding leaves of the zero of a rigid-body mode. The reduction of a large model
/// leaves more than its own arithmetic, found 1e-14. Modal damping takes the root, which makes much of little.
constexpr double rounding_of_squares = 1e-13;

}  // namespace

NormalModes normal_modes(const SparseMatrix& mass, const SparseMatrix& stiffness) {
  const Eigen::MatrixXd dense_mass(mass);
  if (Eigen::LLT<Eigen::MatrixXd>(dense_mass).info() != Eigen::Success)
    throw InvalidInput("the mass matrix is not positive definite", "modes need a mass at every degree of freedom",
                       "give every degree of freedom a mass");
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(Eigen::MatrixXd(stiffness), dense_mass);
  const Eigen::VectorXd& squares = solver.eigenvalues();
  const double rigid = rounding_of_squares * squares.cwiseAbs().maxCoeff();
  const Eigen::VectorXd frequencies = (squares.array() <= rigid).select(0.0, squares).cwiseSqrt();
  return {frequencies / (2.0 * std::numbers::pi), solver.eigenvectors()};
}

Eigen::MatrixXd damping_force(const ModalDamping& damping, const SparseMatrix& mass,
                              const Eigen::MatrixXd& velocities) {
  const auto& [modes, rates] = damping;
  if (rates.size() == 0) return Eigen::MatrixXd::Zero(velocities.rows(), velocities.cols());
  const Eigen::MatrixXd amplitudes = modes.shapes.transpose() * (mass * velocities);
  return mass * (modes.shapes * (rates.asDiagonal() * amplitudes));
}

Eigen::VectorXd damping_rates(const Eigen::VectorXd& frequencies, const std::vector<double>& ratios) {
  Eigen::VectorXd rates = 4.0 * std::numbers::pi * frequencies;
  for (Eigen::Index i = 0; i < rates.size(); ++i)
    rates[i] *= ratios[std::min<std::size_t>(static_cast<std::size_t>(i), ratios.size() - 1)];
  return rates;
}

// For models of moderate size, where all modes are known and C may be full.
SparseMatrix modal_damping(const SparseMatrix& mass, const NormalModes& modes, const std::vector<double>& ratios) {
  if (ratios.empty()) return SparseMatrix(mass.rows(), mass.cols());
  const ModalDamping damping{modes, damping_rates(modes.frequencies, ratios)};
  return damping_force(damping, mass, Eigen::MatrixXd::Identity(mass.rows(), mass.cols())).sparseView();
}

using Eigen::Index;
using Eigen::VectorXd;

namespace {

void check(const LinearModel& model, const std::vector<double>& ratios, const ModalDampingOptions& options) {
  IssueList issues;
  for (const double ratio : ratios)
    if (!(ratio >= 0.0) || !std::isfinite(ratio))
      issues.add({}, "a damping ratio is " + std::to_string(ratio),
                 "it must not be negative: the structure would gain energy");
  if (!options.count && !options.up_to)
    issues.add({}, "the number of modes with modal damping is not given",
               "only some modes of a large model are computed", "give their number or a frequency");
  if (options.count && *options.count < 0)
    issues.add({}, "modal damping of " + std::to_string(*options.count) + " modes", "the number must not be negative");
  if (options.up_to && !(*options.up_to > 0.0 && std::isfinite(*options.up_to)))
    issues.add({}, "modal damping up to " + std::to_string(*options.up_to) + " Hz",
               "the frequency must be positive and finite");
  if (model.modal_damping.rates.size() > 0)
    issues.add({}, "the model has modal damping already", "its modes would be damped twice");
  issues.raise();
}

LowestModes lowest(const LinearModel& model, std::optional<Index> count, std::optional<double> up_to, Index at_least,
                   const StiffnessFactor* factor) {
  LowestModesOptions wanted{.at_least = at_least};
  if (count) wanted.count = std::min(*count, (model.mass.diagonal().array() > 0.0).count());
  if (up_to) wanted.below = std::pow(2.0 * std::numbers::pi * *up_to, 2);
  return factor ? lowest_modes(model.stiffness, model.mass, *factor, wanted)
                : lowest_modes(model.stiffness, model.mass, wanted);
}

VectorXd frequencies_of(const LowestModes& modes) { return modes.values.cwiseSqrt() / (2.0 * std::numbers::pi); }

}  // namespace

// Steps: compute the lowest modes; give each its rate 2 zeta omega; damp the rest by alpha M with the last rate, taken
// off the stored ones again; keep modes and rates, as C_m would be a full matrix.
void add_modal_damping(LinearModel& model, const std::vector<double>& ratios, const ModalDampingOptions& options,
                       const StiffnessFactor* factor) {
  check(model, ratios, options);
  if (ratios.empty()) return;
  LowestModes modes = lowest(model, options.count, options.up_to, 0, factor);
  const Index count = modes.values.size();
  if (count == 0) return;
  const VectorXd frequencies = frequencies_of(modes);
  VectorXd rates = damping_rates(frequencies, ratios);
  if (options.damp_the_rest && modes.next) {
    const double alpha = rates[count - 1];
    model.damping = SparseMatrix(model.damping + alpha * model.mass);
    rates.array() -= alpha;
  }
  model.modal_damping = {{frequencies, std::move(modes.vectors)}, rates};
}

// The modes of the modal damping serve where they are enough, or where the asked band ends before them.
NormalModes lowest_normal_modes(const LinearModel& model, const NormalModesRange& range,
                                const StiffnessFactor* factor) {
  const auto& [count, up_to, at_least] = range;
  const auto& [frequencies, shapes] = model.modal_damping.modes;
  const Index known = frequencies.size(), in_band = up_to ? (frequencies.array() <= *up_to).count() : known;
  const Index wanted = std::min(count, std::max(at_least, in_band));
  if (wanted <= known && (wanted == count || in_band < known))
    return {frequencies.head(wanted), shapes.leftCols(wanted)};
  LowestModes modes = lowest(model, count, up_to, at_least, factor);
  return {frequencies_of(modes), std::move(modes.vectors)};
}

}  // namespace kalfem
