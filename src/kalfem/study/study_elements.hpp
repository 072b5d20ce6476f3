// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/base/progress.hpp"
#include "kalfem/records/spectrum.hpp"
#include "kalfem/study/case_study.hpp"

namespace kalfem {

/// Reads, assembles and reduces every finite-element substructure of the case and adds it to `structure`. Notes and
/// warnings go to the study, problems to `issues`. `progress`: "reduce 1 of 4", by the number of substructures.
void add_finite_elements(StructureModel& structure, CaseStudy& study, const Progress& progress, IssueList& issues);

/// Band that the random, sine and swept excitations of a case cover; nothing if there are none.
std::optional<FrequencyBand> excitation_band(const description::Case& given);

/// Warns of reductions that are too coarse for the excitation or for the sensors.
void warn_of_reductions(CaseStudy& study);

}  // namespace kalfem
