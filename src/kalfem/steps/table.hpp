// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "kalfem/steps/run_step.hpp"

namespace kalfem {

/// Every step, in the order in which a run takes them.
const std::vector<RunStep>& run_steps();

/// The step of that name; nullptr if there is none.
const RunStep* find_step(std::string_view name);

/// The steps that have a verb, in the order in which its help lists them.
std::vector<const RunStep*> verbs();

/// The steps that the case asks for and the verb takes, in the order of the run: that of the verb and those `with` it,
/// or all of them (every_step); and those that come `after` them. Throws std::invalid_argument where no step has that
/// name.
std::vector<const RunStep*> steps_of(std::string_view verb, const Study& study);

/// All steps, those that are named first; the others follow in the order of the run.
std::vector<const RunStep*> steps_in_order(std::span<const std::string_view> first);

/// The same, of these the ones that a run has taken.
std::vector<const RunStep*> steps_that_ran(const StudyResults& results, std::span<const std::string_view> first = {});

}  // namespace kalfem
