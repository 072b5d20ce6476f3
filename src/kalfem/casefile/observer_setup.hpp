#pragma once

#include <map>
#include <string>

#include "kalfem/casefile/study.hpp"

namespace kalfem {

/// Values that parameters have reached, by their names and by the names of all that they apply to.
using PresentValues = std::map<std::string, double>;
PresentValues present_values(const UpdatingSetup& updating, const Eigen::VectorXd& values);

/// The observer of the case's `estimate`, made of `parts`: the case's own, or those that an updating has reached.
/// Values in `present` stand in for the first guesses of unknowns of the same name. Problems go to `issues` with their
/// place.
ObserverSetup make_observer_setup(const Study& study, Parts parts, const PresentValues& present, IssueList& issues);

}  // namespace kalfem
