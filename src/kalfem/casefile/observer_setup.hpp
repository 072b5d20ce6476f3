#pragma once

#include <functional>

#include "kalfem/casefile/unknown_builder.hpp"

namespace kalfem {

PresentValues present_values(const UpdatingSetup& updating, const Eigen::VectorXd& values);

/// The observer of the case's `estimate`, made of `parts`: the case's own, or those that an updating has reached.
/// Values in `present` stand in for the first guesses of unknowns of the same name. Problems go to `issues` with their
/// place.
ObserverSetup make_observer_setup(const Study& study, Parts parts, const PresentValues& present, IssueList& issues);

/// The parts of the case at values of the linear unknowns of an observer, in the bases of its first guesses.
Parts parts_at(const Study& study, const LinearUnknowns& unknowns, const Eigen::VectorXd& values);

/// The observer's system as a function of its linear unknowns; nothing where it has none. The case must outlive it.
std::function<LocallyNonlinearSystem(const Eigen::VectorXd&)> system_of_linear_unknowns(const Study& study,
                                                                                        const ObserverSetup& setup);

}  // namespace kalfem
