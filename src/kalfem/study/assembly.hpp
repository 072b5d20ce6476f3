// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/casefile/description.hpp"
#include "kalfem/identification/structure.hpp"

namespace kalfem {

struct CaseStudy;

/// Builds the substructures, connectors and inputs of the case. Problems go to `issues` with their place; a part that
/// has one is left out. `finite_elements`: the case's finite-element substructures.
StructureParts make_parts(const description::Case& given, std::vector<Substructure> finite_elements, IssueList& issues);

/// Builds the sensors of the case, whose structure has been coupled to `study.model`. Problems go to `issues` with
/// their place.
std::vector<Sensor> make_sensors(const CaseStudy& study, IssueList& issues);

/// Points of a substructure that connectors and forces touch, without its name.
std::vector<std::string> attached_points(const description::Case& given, const std::string& substructure);

/// What the making of signals tells the user, a sentence each.
struct SignalNotes {
  std::vector<std::string> remarks = {};      ///< assumptions that may be wrong
  std::vector<std::string> preparation = {};  ///< what was done to measured inputs, as the case asks
};

/// Makes one signal per excitation, which is an input each. `duration` [s] is the period of random signals that have
/// none of their own.
std::vector<SignalPtr> make_signals(const description::Case& given, double duration, IssueList& issues,
                                    SignalNotes& notes);

/// Whether the excitation is the acceleration of named grounds, which becomes their displacement.
bool accelerates_grounds(const description::Case& given, const description::Excitation& excitation);

/// Name of the spring in parameters: the case's, or "from-to" if it gives none.
std::string spring_name(const description::Spring& spring);

}  // namespace kalfem
