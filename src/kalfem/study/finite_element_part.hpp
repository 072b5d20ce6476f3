// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kalfem/casefile/description.hpp"
#include "kalfem/formats/deck.hpp"
#include "kalfem/identification/finite_element_part.hpp"
#include "kalfem/study/deck_files.hpp"

namespace kalfem {

/// A finite-element substructure of a case, with notes on its deck and warnings.
struct DescribedPart {
  FiniteElementPart part;
  std::vector<DeckNote> notes;        ///< the cards of its deck that were not used
  std::vector<std::string> warnings;  ///< one sentence each, about the boundary
};

/// What other sections of the case name of a substructure, without its name.
struct PartUses {
  std::vector<std::string> attached;              ///< points that connectors and forces touch: "p1.z"
  std::vector<Name> joined;                       ///< groups of nodes at which it is joined to another one
  std::vector<std::string> parameters;            ///< that will change; only these sections of beams stay separate
  const description::Statics* statics = nullptr;  ///< its static load cases, if it has some
  bool at_present_values = false;                 ///< no parameter changes, nor is one tried
};

/// Reads the mesh, deck (from `decks`) or matrices, assembles and damps them. Throws InvalidInput with every problem
/// and its place.
DescribedPart make_finite_element_part(const std::string& name, const description::Substructure& given,
                                       const PartUses& uses, DeckFiles& decks);

/// The reduction that the case asks for; ReductionRequest states the defaults.
ReductionRequest reduction_request(const std::optional<Located<description::Reduction>>& given);

}  // namespace kalfem
