// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <random>
#include <string>
#include <vector>

#include "correlation/tested_structures.hpp"
#include "kalfem/correlation/correlate.hpp"
#include "kalfem/linalg/lowest_modes.hpp"

namespace kalfem::test {

/// A modal test of a structure whose members are up to 10 % softer or stiffer than the model's. Shapes of its ten
/// lowest modes have noise of 2 % of their largest entry. Sensors stand where the model moves: in root mean square over
/// the modes, each of length 1 at the candidates, a tenth of the most and more.
struct ModalTest {
  /// `nodes`: so many of them have sensors along all axes of the structure that move there.
  ModalTest(const TestedStructure& structure, int nodes, unsigned seed);

  /// With noise that follows from the seed.
  [[nodiscard]] Correlation correlated();

  int any(int below) { return std::uniform_int_distribution<int>(0, below - 1)(random); }
  [[nodiscard]] std::vector<Eigen::Index> sensors_of_node(Eigen::Index sensor) const;

  std::mt19937 random;
  LinearModel model;
  NormalModes truth;
  std::vector<Eigen::Index> candidates;  ///< degrees of freedom that could be measured
  std::vector<Eigen::Index> rows;        ///< of the sensors
  std::vector<ShapeSensor> sensors;
  Eigen::MatrixXd measured;  ///< sensors x modes, without noise
};

/// How often the first mistake that is named has the sensor at which one was planted, by its kind.
struct MistakeTally {
  std::map<std::string, int> planted, named, with_cause;
  int tests = 0, right = 0, misled = 0;  ///< all planted, named first, and others named first instead
  int set_ups = 0, alarms = 0;
};

/// Adds tests of the seeds from `first` on, one mistake each: turned, swapped, wrong node, and rotated where there is
/// more than one axis, in turn.
void plant_mistakes(const TestedStructure& structure, int nodes, int first, int count, MistakeTally& tally);
/// Adds tests without a mistake.
void count_alarms(const TestedStructure& structure, int nodes, int first, int count, MistakeTally& tally);

std::string in_words(const MistakeTally& tally);

}  // namespace kalfem::test
