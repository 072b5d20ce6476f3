// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "kalfem/casefile/description.hpp"
#include "kalfem/casefile/finite_element_description.hpp"
#include "kalfem/formats/deck.hpp"
#include "kalfem/model/assembly/fe_linear_model.hpp"
#include "kalfem/model/gauges/strain_gauge.hpp"
#include "kalfem/study/deck_files.hpp"

namespace kalfem {

/// What other sections of the case name of the model.
struct UsedGroups {
  std::vector<std::string> loaded;  ///< groups of the mesh that loads act on
  std::vector<Name> joined;         ///< groups whose nodes are joined to another substructure
  bool deck_cases = false;          ///< the load cases of the deck are wanted
};

/// A finite-element model, the names of its nodes, its strain gauges, and notes on its deck.
struct NamedElements {
  FiniteElementModel elements;
  std::vector<NamedNode> nodes;
  std::vector<StrainGauge> gauges;
  std::vector<DeckNote> notes;
  std::map<std::string, std::vector<Eigen::Index>> load_groups;  ///< cells of the groups that loads name
  std::vector<LoadCase> deck_cases = {};                         ///< if they are wanted
  std::optional<LoadCase> deck_preload = {};                     ///< see Deck::preload
};

/// Reads the mesh or deck, the latter from `decks`, of a case's substructure and gives it materials, properties,
/// masses, springs, links and supports. The cells of used groups need no property. Throws InvalidInput with every name
/// that does not exist, each with its place.
NamedElements build_finite_elements(const std::string& name, const description::Substructure& given,
                                    const UsedGroups& used, DeckFiles& decks);

}  // namespace kalfem
