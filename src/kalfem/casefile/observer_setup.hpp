#pragma once

#include "kalfem/casefile/study.hpp"

namespace kalfem {

/// The observer of the case's `estimate`. Problems go to `issues` with their place.
ObserverSetup make_observer_setup(const Study& study, IssueList& issues);

}  // namespace kalfem
