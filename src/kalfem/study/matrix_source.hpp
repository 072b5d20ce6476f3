#pragma once

#include "kalfem/casefile/finite_element_description.hpp"
#include "kalfem/formats/deck.hpp"

namespace kalfem {

/// Matrices of another code as a model without elements: a node for each of the code's nodes (at its place, where the
/// case gives coordinates, else at the origin), NodalMatrices between them in SI. Sets that name a degree of freedom of
/// one node number both are joined there. A generalised coordinate is the motion x of a node of its own, numbered
/// beyond all others, and so are further copies of a node. Throws InvalidInput with every problem and its place.
Deck matrices_as_deck(const description::MatrixFiles& files);

}  // namespace kalfem
