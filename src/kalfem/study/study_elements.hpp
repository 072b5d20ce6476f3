#pragma once

#include "kalfem/records/spectrum.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// Meshes, assembles and reduces every finite-element substructure of the case. Problems go to `issues`.
void add_finite_elements(Study& study, IssueList& issues);

/// The finite-element substructures as the augmented model holds them.
std::vector<Substructure> reduced_parts(const Study& study);

/// The case's parts as its record is simulated from them.
StructureParts reference_parts(const Study& study);

/// Frequencies that the random, sine and swept excitations of a case hold; nothing where there is none.
std::optional<FrequencyBand> excitation_band(const description::Case& given);

/// Words on reductions that are too coarse for the excitation or for the sensors.
void warn_of_reductions(Study& study);

}  // namespace kalfem
