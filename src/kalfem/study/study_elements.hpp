#pragma once

#include "kalfem/records/spectrum.hpp"
#include "kalfem/study/case_study.hpp"

namespace kalfem {

/// Meshes, assembles and reduces every finite-element substructure of the case into `structure`; what there is to say
/// of them goes to the study, problems to `issues`.
void add_finite_elements(StructureModel& structure, CaseStudy& study, IssueList& issues);

/// Frequencies that the random, sine and swept excitations of a case hold; nothing where there is none.
std::optional<FrequencyBand> excitation_band(const description::Case& given);

/// Words on reductions that are too coarse for the excitation or for the sensors.
void warn_of_reductions(CaseStudy& study);

}  // namespace kalfem
