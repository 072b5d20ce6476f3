// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/diagnosis/diagnosis.hpp"
#include "kalfem/estimation/estimate.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/step_budget.hpp"

namespace kalfem {

/// A run of a filter that is to be explained: the problem, the parts that its model is made of, and the record.
struct DiagnosisInput {
  EstimationProblemPtr problem;
  StructureParts parts;
  Record record;
  EstimationOptions options = {};
  Eigen::VectorXd nis = {};               ///< of the run that is to be explained, up to where it stopped
  double steps = StepBudget::unlimited;   ///< filter steps that all trials together may take
  std::vector<std::string> updated = {};  ///< parameters that an updating found: they are not held fixed

  /// The filter's run over the record for this problem or a changed one.
  [[nodiscard]] FilterRun run_of(const EstimationProblemPtr& changed, const StructureParts& changed_parts) const;
  /// The filter's run over a changed record, with the start that this one asks for.
  [[nodiscard]] FilterRun run_over(const Record& changed) const;
};

/// A run in which a mistake is undone.
struct CorrectedRun {
  FilterRun run;
  /// log |d corrected / d recorded| over all samples, which makes likelihoods of corrected records comparable.
  double log_jacobian = 0.0;
};

/// How the number of a hypothesis is searched.
enum class Search { none, samples, factor, offset };

/// One mistake that would explain why a record and a model do not fit, and the run without it.
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
  std::function<CorrectedRun(double value)> correct;
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
