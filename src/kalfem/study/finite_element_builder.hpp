#pragma once

#include <string>
#include <vector>

#include "kalfem/casefile/description.hpp"
#include "kalfem/casefile/finite_element_description.hpp"
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

/// Matrices of another code as a model without elements: a node for each of the code's nodes (at its place, where the
/// case gives coordinates, else at the origin), NodalMatrices between them in SI. Sets that name a degree of freedom of
/// one node number both are joined there. A generalised coordinate is the motion x of a node of its own, numbered
/// beyond all others, and so are further copies of a node. Throws InvalidInput with every problem and its place.
Deck matrices_as_deck(const description::MatrixFiles& files);

}  // namespace kalfem
