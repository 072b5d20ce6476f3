// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/correlation/setup_mistakes.hpp"
#include "kalfem/correlation/shape_expansion.hpp"
#include "kalfem/model/linear_model.hpp"
#include "kalfem/updating/measured_mode.hpp"
#include "kalfem/updating/mode_pairing.hpp"

namespace kalfem {

struct CorrelationOptions {
  double above = 0.0;             ///< [Hz] modes of the model up to this frequency are not elastic ones
  std::optional<int> modes = {};  ///< elastic modes to compute; none: half more than are measured, and 6
  ModePairingOptions pairing = {};
  double mistake_mac = 0.2;  ///< pairs of a MAC of so much and more tell of mistakes, which lower it
  MistakeOptions mistakes = {};
  ExpansionMethod expansion = ExpansionMethod::model;
  int expansion_modes = 60;  ///< elastic modes, at least, that a true shape may be mixed of
};

/// How well one sensor agrees over the paired modes.
struct SensorCorrelation {
  std::string name;
  std::string place;
  double comac = 0.0;  ///< (sum |f a|)^2 / (sum f^2 sum a^2) in [0, 1] [LE88]; not a number without two pairs
};

/// Measured modes beside those of a model.
struct Correlation {
  std::vector<PairedMode> pairs = {};  ///< one a measured mode; without a model mode where none agrees
  Eigen::VectorXd frequencies = {};    ///< of the model's elastic modes [Hz]
  Eigen::MatrixXd mac = {};            ///< measured x model
  Eigen::MatrixXd auto_mac = {};       ///< measured x measured: how well the sensors tell modes apart
  /// Of the measured shapes by pairs, with the mass reduced to the sensors by SEREP [OCa89], each scaled to 1; empty
  /// where there are fewer sensors than pairs, or gaps.
  Eigen::MatrixXd orthogonality = {};
  std::vector<SensorCorrelation> sensors = {};
  std::vector<SetupMistake> mistakes = {};
  std::vector<std::string> dofs = {};  ///< of the model: rows of the expanded shapes
  ShapeExpansion expansion = {};
};

/// Modal assurance criterion between columns over the entries that are numbers in both.
Eigen::MatrixXd mac_of_measured(const Eigen::MatrixXd& one, const Eigen::MatrixXd& other);

/// Pairs measured modes with those of a model and says how they agree, sensor by sensor. `points`: of the shapes, with
/// the sensors that measured them. Measured modes need no shape: then they have no pair. Throws InvalidInput for points
/// that the model does not have.
Correlation correlate(const std::vector<MeasuredMode>& measured, const std::vector<DofCombination>& points,
                      const std::vector<ShapeSensor>& sensors, const LinearModel& model,
                      const CorrelationOptions& options = {});

}  // namespace kalfem
