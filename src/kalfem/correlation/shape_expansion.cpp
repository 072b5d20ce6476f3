// SPDX-License-Identifier: Apache-2.0
#include "kalfem/correlation/shape_expansion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/correlation/modal_mixing.hpp"
#include "kalfem/linalg/complex_factor.hpp"
#include "kalfem/updating/shape_errors.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double least_seen = 1e-2;  ///< combinations of modes of which the sensors see less are left out by SEREP

/// What is stated of the errors; where nothing is, all entries are known alike: their noise is found in any case.
ShapeErrors errors_of(const MeasuredMode& mode) {
  constexpr double usual_deviation = 0.05;
  MeasuredMode stated = mode;
  if (mode.shape_covariance.size() == 0 && mode.shape_deviations.size() == 0 && !(mode.shape_deviation > 0.0))
    stated.shape_deviation = usual_deviation;
  return shape_errors_of(stated, ShapeScale::given);
}

/// A measured shape with its errors, and the model's at the same entries.
struct Matched {
  std::size_t measured;
  ShapeErrors errors;
  MatchedShape shape;
};

std::vector<Matched> matched_shapes(const std::vector<MeasuredMode>& measured, const std::vector<ModePair>& pairs,
                                    const MatrixXd& at_points) {
  std::vector<Matched> matched;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!pairs[i].model || measured[i].shape.size() == 0) continue;
    auto errors = errors_of(measured[i]);
    MatchedShape shape{errors.whitened(measured[i].shape), errors.whitened(at_points), *pairs[i].model};
    if (std::abs(shape.model.col(shape.mode).dot(shape.measured)) > 0.0)  // otherwise they share nothing
      matched.push_back({i, std::move(errors), std::move(shape)});
  }
  return matched;
}

/// The factor on the model's mode, by least squares.
double scale_of(const MatchedShape& shape) {
  const auto mode = shape.model.col(shape.mode);
  return mode.dot(shape.measured) / mode.squaredNorm();
}

/// Deviations a d_j of the coordinates of the truth.
VectorXd coordinate_deviations(const MatchedShape& shape, const VectorXd& frequencies, const ModalMixing& mixing) {
  return std::abs(scale_of(shape)) * mixing_deviations(frequencies, shape.mode, mixing.stiffness_error);
}

/// Bayes' rule for the coordinates, that of the mode itself without a prior.
ExpandedShape by_model(const Matched& matched, const NormalModes& modes, const ModalMixing& mixing) {
  const auto& shape = matched.shape;
  VectorXd precision = coordinate_deviations(shape, modes.frequencies, mixing).cwiseAbs2().cwiseInverse();
  precision[shape.mode] = 0.0;
  const double noise = mixing.noise * mixing.noise;
  MatrixXd information = shape.model.transpose() * shape.model / noise;
  information.diagonal() += precision;
  const Eigen::LLT<MatrixXd> factor(information);
  const VectorXd coordinates = factor.solve(shape.model.transpose() * shape.measured) / noise;
  // Phi (L L^T)^-1 Phi^T has the rows of Phi L^-T as its roots.
  const MatrixXd roots = factor.matrixL().solve(modes.shapes.transpose());
  return {.measured = matched.measured,
          .shape = modes.shapes * coordinates,
          .deviation = roots.colwise().norm().transpose()};
}

/// T of entries in their deviations, with its errors.
ExpandedShape by_matrix(const Matched& matched, const MatrixXd& expanding, const NormalModes& modes,
                        const ModalMixing& mixing) {
  const auto& shape = matched.shape;
  const MatrixXd bias =
      (expanding * shape.model - modes.shapes) * coordinate_deviations(shape, modes.frequencies, mixing).asDiagonal();
  return {
      .measured = matched.measured,
      .shape = expanding * shape.measured,
      .deviation =
          (bias.rowwise().squaredNorm() + mixing.noise * mixing.noise * expanding.rowwise().squaredNorm()).cwiseSqrt()};
}

/// Phi_p (L^-1 P Phi_p)^+ of the paired modes p.
MatrixXd serep_matrix(const MatchedShape& shape, const NormalModes& modes, std::vector<Index> paired) {
  const auto distance = [&](Index mode) {
    return std::abs(std::log(modes.frequencies[mode] / modes.frequencies[shape.mode]));
  };
  std::ranges::stable_sort(paired, {}, distance);
  paired.resize(std::min<std::size_t>(paired.size(), static_cast<std::size_t>(shape.measured.size())));
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> at_entries(shape.model.rows(), std::ssize(paired));
  at_entries.setThreshold(least_seen).compute(shape.model(Eigen::all, paired));
  return modes.shapes(Eigen::all, paired) * at_entries.pseudoInverse();
}

/// omega^2, off every eigenvalue of the model so that K - omega^2 M can be factored.
double squared_frequency(double frequency, const VectorXd& frequencies) {
  constexpr double nearest = 1e-7;  // relative; of the answer it leaves nine digits
  const double squared = std::pow(2.0 * std::numbers::pi * frequency, 2);
  const bool on_one = ((frequencies.array() / frequency).square() - 1.0).abs().minCoeff() < nearest;
  return on_one ? squared * (1.0 + 2.0 * nearest) : squared;
}

/// Expands by (K - omega^2 M)^-1 P^T; the pattern is analysed once for all shapes.
class DynamicStiffness {
public:
  DynamicStiffness(const LinearModel& model, const SparseMatrix& rows)
      : model_(model), rows_(rows), matrix_(at(1.0)), factor_(matrix_) {}

  MatrixXd expanding(double frequency, const VectorXd& frequencies, const ShapeErrors& errors) {
    matrix_ = at(squared_frequency(frequency, frequencies));
    if (!factor_.factor(matrix_))
      throw InvalidInput(fmt::format("K - omega^2 M is singular at {:.4g} Hz", frequency),
                         "the dynamic expansion solves with it", "take the expansion by the model");
    const MatrixXd entries = errors.of_measured(MatrixXd::Identity(rows_.rows(), rows_.rows()));
    const MatrixXd forces = rows_.transpose() * entries.transpose();
    const MatrixXd motion = factor_.solve(forces.cast<std::complex<double>>()).real();
    // T P~ = 1 at the entries in their deviations, P~ = L^-1 P: T = X (L^-1 P X)^+.
    return motion * errors.whitened(rows_ * motion).completeOrthogonalDecomposition().pseudoInverse();
  }

private:
  [[nodiscard]] ComplexSparseMatrix at(double squared) const {
    return SparseMatrix(model_.stiffness - squared * model_.mass).cast<std::complex<double>>();
  }

  const LinearModel& model_;
  const SparseMatrix& rows_;
  ComplexSparseMatrix matrix_;
  ComplexFactor factor_;
};

}  // namespace

ShapeExpansion expand_shapes(const std::vector<MeasuredMode>& measured, const std::vector<ModePair>& pairs,
                             const std::vector<DofCombination>& points, const LinearModel& model,
                             const NormalModes& modes, ExpansionMethod method) {
  const SparseMatrix rows = point_rows(model, points);
  const auto matched = matched_shapes(measured, pairs, rows * modes.shapes);
  ShapeExpansion expansion{.method = method};
  if (matched.empty()) return expansion;
  std::vector<MatchedShape> shapes;
  std::vector<Index> paired;
  for (const auto& each : matched) {
    shapes.push_back(each.shape);
    paired.push_back(each.shape.mode);
  }
  expansion.mixing = fit_modal_mixing(shapes, modes.frequencies);
  std::optional<DynamicStiffness> dynamic;
  if (method == ExpansionMethod::dynamic) dynamic.emplace(model, rows);
  const auto expanded = [&](const Matched& each) {
    if (method == ExpansionMethod::model) return by_model(each, modes, expansion.mixing);
    if (method == ExpansionMethod::serep)
      return by_matrix(each, serep_matrix(each.shape, modes, paired), modes, expansion.mixing);
    const double frequency = measured[each.measured].frequency;
    return by_matrix(each, dynamic->expanding(frequency, modes.frequencies, each.errors), modes, expansion.mixing);
  };
  const VectorXd mass = model.mass.diagonal();
  for (const auto& each : matched) {
    auto& shape = expansion.shapes.emplace_back(expanded(each));
    shape.model = scale_of(each.shape) * modes.shapes.col(each.shape.mode);
    shape.band = std::sqrt(mass.dot(shape.deviation.cwiseAbs2()) / mass.dot(shape.shape.cwiseAbs2()));
  }
  return expansion;
}

}  // namespace kalfem
