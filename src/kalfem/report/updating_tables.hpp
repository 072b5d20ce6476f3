// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/report/page.hpp"

namespace kalfem {

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
Table correlation_table(const Study& study, const UpdatingOutcome& outcome);
Table sensitivity_table(const UpdatingOutcome& outcome);
/// Natural frequencies of each modification.
Table modification_table(const std::vector<StructuralModificationResult>& modifications);
/// Unknowns of the filter before and after the updating; without rows where there are none.
Table before_and_after_table(const Study& study, const StudyResults& results);

/// The updating as a person reads it on a terminal.
std::string console_updating(const Study& study, const StudyResults& results);
/// One line for one evaluation.
std::string console_updating_step(const Study& study, int number, const UpdatingStep& step);

/// Mean of |relative frequency error| over the modes that are paired.
double mean_frequency_error(const std::vector<PairedMode>& modes);

}  // namespace kalfem
