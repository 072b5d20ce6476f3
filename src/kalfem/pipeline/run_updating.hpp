#pragma once

#include "kalfem/identification/parameterised_structure.hpp"
#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/study/comparisons.hpp"

namespace kalfem {

/// Refines the linear substructures: minimises the weighted sum of the case's comparisons. With a driven record among
/// them every evaluation is a stage of the loop reduce - estimate - predict - compare, and a least-squares search from
/// one start keeps its place in the options' folder.
///
/// `comparisons`: those that need no record, of the same structure. `failure` says in words why the numbers are not
/// usable. Throws InvalidInput for what the user can mend.
UpdatingOutcome run_updating(const Study& study, std::vector<ComparisonResidual> comparisons,
                             const StudyResults& results,
                             const std::shared_ptr<const ParameterisedStructure>& structure, const RunOptions& options,
                             std::string& failure);

/// What run_updating() refuses at the first values, of the comparisons that need no record: throws InvalidInput where
/// one of them has no value there, and, where all of them need none, where nothing depends on a parameter.
void check_first_values(const Study& study);

}  // namespace kalfem
