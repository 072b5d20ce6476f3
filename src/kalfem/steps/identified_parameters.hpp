// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/estimation/estimate.hpp"
#include "kalfem/page/page.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// What a run found about one parameter, by whichever step looked for it.
struct IdentifiedParameter {
  std::string name, unit;            ///< SI
  std::string own_unit;              ///< in which the case states it; empty: none
  double value = 0.0;                ///< [unit]
  double deviation = 0.0;            ///< the larger of the two that a step states; not a number: it has none [unit]
  std::optional<Interval> prior;     ///< 95 %; nothing without a prior
  std::optional<Interval> interval;  ///< 95 %
  std::optional<double> truth;

  /// (value - truth) / deviation
  [[nodiscard]] std::optional<double> z() const;
};

/// Of the filter's unknowns, those of the measurement among them.
std::vector<IdentifiedParameter> identified_unknowns(const Study& study, const EstimationOutcome& outcome);
/// Of the filter's unknowns and the updated parameters, or, without these, of the inference.
std::vector<IdentifiedParameter> identified_parameters(const Study& study, const StudyResults& results);

/// "19.98 ± 0.05 N": in the unit and with the digits that people read.
std::string value_in_words(const IdentifiedParameter& parameter);

/// One row a parameter: value, z where the truth is known, and a bar from the prior's interval to the posterior's.
Table identified_parameter_table(const std::vector<IdentifiedParameter>& parameters);

}  // namespace kalfem
