// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/updating/outcome.hpp"

namespace kalfem {

/// Updates the linear substructures: minimises the weighted sum of the case's comparisons. If one of them drives a
/// substructure by estimated motion, each evaluation reduces, estimates, predicts and compares. A least-squares search
/// from one start keeps a checkpoint in the options' folder.
///
/// `failure` states why the numbers are not usable. Throws InvalidInput for problems that the user can mend.
UpdatingOutcome run_updating(const Study& study, const StudyResults& results, const RunOptions& options,
                             std::string& failure);

/// The same with each of the plan's alternatives, weighted with the outcome by their evidence; an alternative that
/// fails has no weight.
void run_alternatives(const Study& study, const StudyResults& results, UpdatingOutcome& outcome);
/// The study with the alternative in the place of its parameters.
Study with_alternative(const Study& study, const AlternativeUpdating& alternative);

/// The comparisons of an updating: first those that need no record, then the others. Throws InvalidInput with every
/// problem and its place.
std::vector<ComparisonResidual> all_comparisons(const Study& study, const StudyResults& results);

/// Evaluates the comparisons that need no record at the initial values, as run_updating() will. Throws InvalidInput if
/// one of them has no value there. If no comparison needs a record, throws InvalidInput also for a parameter on which
/// no comparison depends.
void check_first_values(const Study& study);

}  // namespace kalfem
