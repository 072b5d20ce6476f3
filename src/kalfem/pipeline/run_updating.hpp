#pragma once

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// Refines the linear substructures: minimises the weighted sum of the case's comparisons. With a driven record among
/// them every evaluation is a pass of the loop reduce - estimate - predict - compare, and a least-squares search from
/// one start keeps its place in the options' folder.
///
/// `failure` says in words why the numbers are not usable. Throws InvalidInput for what the user can mend.
UpdatingOutcome run_updating(const Study& study, const StudyResults& results, const RunOptions& options,
                             std::string& failure);

/// The comparisons of an updating: those that need no record, and the others behind them. Throws InvalidInput with
/// every problem and its place.
std::vector<ComparisonResidual> all_comparisons(const Study& study, const StudyResults& results);

/// What run_updating() refuses at the first values, of the comparisons that need no record: throws InvalidInput where
/// one of them has no value there, and, where all of them need none, where nothing depends on a parameter.
void check_first_values(const Study& study);

}  // namespace kalfem
