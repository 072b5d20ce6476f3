// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "kalfem/page/page.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// The first sentences of the page: what was found, from how many sensors, how sure that is, and what to do next.
std::string answer(const Study& study, const StudyResults& results);

/// Lines of the case that mend what the verdict doubts, to be copied; nothing where no key of the case does.
std::optional<Listing> asked_edit(const Study& study, const StudyResults& results);

/// The structure with its named sensors, connectors, excitations and grounds: the mesh of the largest finite-element
/// substructure where there is one, otherwise a schematic of masses. Nothing where there is nothing to draw.
std::optional<Picture> structure_picture(const Study& study);

/// The schematic of the whole structure, finite-element substructures as boxes.
std::optional<Picture> schematic_picture(const Study& study);

/// What was read, with its hashes, how it was prepared, which method and why, time, versions, and the resolved case.
Section provenance_section(const Study& study, const StudyResults& results);

}  // namespace kalfem
