// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "kalfem/page/page.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/steps/updating/outcome.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// "k1: of +- 31 N/m, 9 are of what was measured, 30 't.2.mass'": a line each parameter. `outcome` has what stated
/// numbers add.
std::string considered_words(const Study& study, const UpdatingOutcome& outcome);

/// The object "updating" of summary.json.
nlohmann::ordered_json updating_summary(const Study& study, const UpdatingOutcome& outcome);

/// Refined parameters with initial value, result, standard deviation, truth and what changed.
Table updated_parameter_table(const Study& study, const UpdatingOutcome& outcome);
/// Each comparison before and after, in standard deviations.
Table comparison_table(const UpdatingOutcome& outcome);
/// Measured and model frequencies of a comparison, before and after.
Table paired_mode_table(const ComparisonResult& comparison);
/// Every evaluation with the parameters that it tried.
Table updating_trace_table(const Study& study, const UpdatingOutcome& outcome);
/// Where the searches from several starts ended, lowest cost first; without rows where there was one start.
Table minima_table(const Study& study, const UpdatingOutcome& outcome);
/// The choices of parameters with their fit, evidence and weight; without rows where there is one.
Table alternatives_table(const UpdatingOutcome& outcome);
/// By how many per cent the natural frequencies of a comparison change where a parameter does by 1 %, at the initial
/// values: a row a parameter, a column a measured mode, of which at most `most` are shown.
Table frequency_sensitivity_table(const Study& study, const FrequencySensitivities& sensitivities,
                                  std::size_t most = 1000);
/// Combinations that the measurement does not determine before the updating and groups that it would, one line each.
std::string first_words(const Study& study, const UpdatingOutcome& outcome);
Table sensitivity_table(const UpdatingOutcome& outcome);
/// Unknowns of the filter before and after the updating; without rows where there are none.
Table before_and_after_table(const Study& study, const StudyResults& results);

/// How many parameters were updated and how far the residual fell.
std::string updating_answer(const UpdatingOutcome& outcome);
/// The updating as a person reads it on a terminal.
std::string console_updating(const Study& study, const StudyResults& results);
/// One line for one evaluation.
std::string console_updating_step(const Study& study, int number, const UpdatingStep& step);

/// Parameters, what they rest on, the course of the search, measured and model responses.
Section updating_section(const Study& study, const StudyResults& results);

/// Mean of |relative frequency error| over the modes that are paired.
double mean_frequency_error(const std::vector<PairedMode>& modes);

}  // namespace kalfem
