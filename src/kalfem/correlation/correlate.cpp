// SPDX-License-Identifier: Apache-2.0
#include "kalfem/correlation/correlate.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int spare_modes = 6;
constexpr double frequencies_first = 10.0;  ///< weight of a near frequency, against a MAC of 1 at most
constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// Shapes of the measured modes, points x modes; a mode without one is a column of gaps.
MatrixXd shapes_of(const std::vector<MeasuredMode>& measured, Index points) {
  MatrixXd shapes = MatrixXd::Constant(points, std::ssize(measured), none);
  for (Index i = 0; i < shapes.cols(); ++i)
    if (const auto& shape = measured[static_cast<std::size_t>(i)].shape; shape.size() == points) shapes.col(i) = shape;
  return shapes;
}

VectorXd frequencies_of(const std::vector<MeasuredMode>& measured) {
  VectorXd frequencies(std::ssize(measured));
  for (Index i = 0; i < frequencies.size(); ++i) frequencies[i] = measured[static_cast<std::size_t>(i)].frequency;
  return frequencies;
}

/// The lowest modes above the limit.
NormalModes elastic_modes(const LinearModel& model, Index wanted, double above) {
  const Index most = (model.mass.diagonal().array() > 0.0).count();  // others have no mode of their own
  for (Index count = std::min(wanted, most);; count = std::min(count + wanted, most)) {
    const NormalModes modes = count == model.size() ? normal_modes(model.mass, model.stiffness)
                                                    : lowest_normal_modes(model, {.count = count});
    const Index low = (modes.frequencies.array() <= above).count(), found = modes.frequencies.size() - low;
    if (found < wanted && count < most) continue;
    const Index kept = std::min(found, wanted);
    return {modes.frequencies.segment(low, kept), modes.shapes.middleCols(low, kept)};
  }
}

NormalModes lowest_of(const NormalModes& modes, Index count) {
  count = std::min(count, modes.frequencies.size());
  return {modes.frequencies.head(count), modes.shapes.leftCols(count)};
}

std::vector<PairedMode> table_of(const std::vector<MeasuredMode>& measured, const std::vector<ModePair>& pairs) {
  std::vector<PairedMode> table;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double frequency = measured[i].frequency, error = pairs[i].frequency_difference;
    PairedMode row{i, {}, frequency, frequency * (1.0 + error), error, pairs[i].mac};
    if (pairs[i].model) row.model_mode = static_cast<int>(*pairs[i].model) + 1;
    row.complexity = measured[i].complexity;
    table.push_back(row);
  }
  return table;
}

/// Columns of the pairs.
struct PairedShapes {
  std::vector<Index> measured, model;
};
PairedShapes paired(const std::vector<ModePair>& pairs) {
  PairedShapes columns;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (pairs[i].model) {
      columns.measured.push_back(static_cast<Index>(i));
      columns.model.push_back(*pairs[i].model);
    }
  return columns;
}

/// COMAC of each row; each pair counts alike, whatever its scale.
VectorXd comac(MatrixXd measured, MatrixXd model) {
  VectorXd all = VectorXd::Constant(measured.rows(), none);
  if (measured.cols() < 2) return all;
  const auto given = measured.array().isFinite().eval();
  measured = given.select(measured, 0.0);
  model = given.select(model, 0.0);
  for (Index pair = 0; pair < measured.cols(); ++pair) {
    measured.col(pair).normalize();
    model.col(pair).normalize();
  }
  for (Index row = 0; row < all.size(); ++row) {
    const double size = measured.row(row).squaredNorm() * model.row(row).squaredNorm();
    const double mixed = measured.row(row).cwiseProduct(model.row(row)).cwiseAbs().sum();
    if (given.row(row).count() >= 2 && size > 0.0) all[row] = mixed * mixed / size;
  }
  return all;
}

/// f^T M_s f with M_s = (Phi_s^+)^T Phi_s^+, the mass that SEREP reduces to the sensors: the measured shapes in
/// coordinates of the model's paired modes, each of length 1.
MatrixXd orthogonality(const MatrixXd& measured, const MatrixXd& model) {
  if (!measured.allFinite() || measured.cols() == 0 || measured.rows() < measured.cols()) return {};
  const auto factor = model.completeOrthogonalDecomposition();
  if (factor.rank() < model.cols()) return {};
  MatrixXd coordinates = factor.solve(measured);
  coordinates.colwise().normalize();
  return coordinates.transpose() * coordinates;
}

}  // namespace

MatrixXd mac_of_measured(const MatrixXd& one, const MatrixXd& other) {
  MatrixXd mac = MatrixXd::Zero(one.cols(), other.cols());
  for (Index i = 0; i < mac.rows(); ++i)
    for (Index j = 0; j < mac.cols(); ++j) {
      const auto both = (one.col(i).array().isFinite() && other.col(j).array().isFinite()).eval();
      const VectorXd a = both.select(one.col(i), 0.0), b = both.select(other.col(j), 0.0);
      const double size = a.squaredNorm() * b.squaredNorm(), mixed = a.dot(b);
      if (size > 0.0) mac(i, j) = mixed * mixed / size;
    }
  return mac;
}

Correlation correlate(const std::vector<MeasuredMode>& measured, const std::vector<DofCombination>& points,
                      const std::vector<ShapeSensor>& sensors, const LinearModel& model,
                      const CorrelationOptions& options) {
  const Index count = std::ssize(measured);
  const Index wanted = options.modes.value_or(count + count / 2 + spare_modes);
  const auto mixed = elastic_modes(model, std::max<Index>(wanted, options.expansion_modes), options.above);
  const auto modes = lowest_of(mixed, wanted);
  const MatrixXd shapes = shapes_of(measured, std::ssize(points)), at_points = point_rows(model, points) * modes.shapes;
  Correlation result{.frequencies = modes.frequencies,
                     .mac = mac_of_measured(shapes, at_points),
                     .auto_mac = mac_of_measured(shapes, shapes),
                     .dofs = model.dofs};
  const auto pairs_of = [&](double least_mac, double frequency_weight) {
    auto pairing = options.pairing;
    pairing.least_mac = least_mac;
    pairing.frequency_weight = frequency_weight;
    return pair_modes(result.mac, frequencies_of(measured), modes.frequencies, pairing);
  };
  const auto pairs = pairs_of(options.pairing.least_mac, options.pairing.frequency_weight);
  result.pairs = table_of(measured, pairs);
  const auto columns = paired(pairs);
  const MatrixXd of_sensors = shapes(Eigen::all, columns.measured), of_model = at_points(Eigen::all, columns.model);
  const VectorXd agreement = comac(of_sensors, of_model);
  for (std::size_t i = 0; i < sensors.size(); ++i)
    result.sensors.push_back({sensors[i].name, sensors[i].place, agreement[static_cast<Index>(i)]});
  result.orthogonality = orthogonality(of_sensors, of_model);
  // A mistake may make a shape more like that of another mode: then the frequencies tell the pairs.
  const double least_mac = std::min(options.mistake_mac, options.pairing.least_mac);
  for (const auto& pairing :
       {pairs_of(least_mac, options.pairing.frequency_weight), pairs_of(0.0, frequencies_first)}) {
    const auto suspected = paired(pairing);
    auto mistakes = setup_mistakes(shapes(Eigen::all, suspected.measured), at_points(Eigen::all, suspected.model),
                                   sensors, {model.dofs, modes.shapes(Eigen::all, suspected.model)}, options.mistakes);
    if (!mistakes.empty() && (result.mistakes.empty() || mistakes.front().evidence > result.mistakes.front().evidence))
      result.mistakes = std::move(mistakes);
  }
  result.expansion = expand_shapes(measured, pairs, points, model, mixed, options.expansion);
  return result;
}

}  // namespace kalfem
