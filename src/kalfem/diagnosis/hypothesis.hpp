// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/diagnosis/correction.hpp"
#include "kalfem/diagnosis/diagnosis.hpp"

namespace kalfem {

/// How the number of a hypothesis is searched.
enum class Search { none, samples, factor, offset };

/// One mistake that would explain why a record and a model do not fit, and how it is undone.
struct Hypothesis {
  std::string code;                    ///< for programs: "sensor_sign"
  std::string subject;                 ///< sensor, excitation, parameter, connector or substructure
  std::vector<double> starts = {0.0};  ///< first guesses of its number: a factor, a delay in samples, an offset
  Search search = Search::none;
  double step = 0.0;  ///< of the search: samples, relative, or the offset's unit
  /// Numbers that it takes from the record. Of hypotheses that explain as much the one with the fewest is preferred.
  int fitted = 0;
  /// It only allows a sensor larger innovations. That is an explanation where they are white and even by it; otherwise
  /// anything that is wrong near the sensor would be one.
  bool widens = false;
  std::function<Correction(const DiagnosisInput& input, double value)> correct;
  /// The mistake in words: "'a7' has the wrong sign".
  /// `estimates`: of the unknowns at the end of the corrected run.
  std::function<std::string(double value, const Eigen::VectorXd& estimates)> words;
  std::string remedy;
  bool turned = false;  ///< a gain that is negative besides
  /// What a connector lacks, with the numbers found; empty: this is about something else.
  std::function<std::vector<LackingForce>(double value, const Eigen::VectorXd& estimates)> forces = {};
};

/// x such as 3.2, 0.047 or 1.2e-05 for a sentence.
std::string in_words(double value);

/// A factor in the units that people mix up, or nothing: 9.81 is "g in the place of m/s^2".
std::optional<std::string> unit_mistake(double factor);

/// The factors of such mistakes within `tolerance` (of their logarithm) of a factor, nearest first; the usual ones
/// where the factor is not known.
std::vector<double> unit_factors_near(std::optional<double> factor, double tolerance);

}  // namespace kalfem
