// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "kalfem/page/page.hpp"
#include "kalfem/steps/placement/outcome.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// The placement of sensors for summary.json. Ranks count from 1.
nlohmann::ordered_json placement_summary(const PlacementOutcome& outcome);

/// The best set in a sentence, or why there is none.
std::string placement_answer(const PlacementOutcome& outcome);

/// Sentences and tables as a person reads them on a terminal.
std::string console_placement(const PlacementOutcome& outcome);

/// The same on the page, with a map of each mesh and bars of the other candidates.
Section placement_section(const Study& study, const PlacementOutcome& outcome);

}  // namespace kalfem
