#pragma once

#include <string>
#include <vector>

#include "kalfem/casefile/description.hpp"
#include "kalfem/formats/deck.hpp"
#include "kalfem/model/assembly/fe_linear_model.hpp"

namespace kalfem {

/// A finite-element model, the names of its nodes, and what its deck holds that was not used.
struct NamedElements {
  FiniteElementModel elements;
  std::vector<NamedNode> nodes;
  std::vector<DeckNote> notes;
};

/// Reads the mesh or deck of a case's substructure and gives it materials, properties, masses, springs, links and
/// supports.
/// Throws InvalidInput with every name that does not exist, each with its place.
NamedElements build_finite_elements(const std::string& name, const description::Substructure& given);

}  // namespace kalfem
