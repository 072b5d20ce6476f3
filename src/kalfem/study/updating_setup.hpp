#pragma once

#include "kalfem/study/study.hpp"

namespace kalfem {

/// The parameters of the case's `update`. Problems go to `issues` with their place: names that no substructure has,
/// bounds that exclude the start, one parameter under two names.
UpdatingSetup make_updating_setup(const Study& study, IssueList& issues);

/// The case's structure as a function of what its updating refines.
std::shared_ptr<const ParameterisedStructure> parameterised_structure(const Study& study);

}  // namespace kalfem
