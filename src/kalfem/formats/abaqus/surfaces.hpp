#pragma once

#include "kalfem/formats/abaqus/placed_deck.hpp"

namespace kalfem::abaqus {

/// A side of an element: corners, then the nodes amid its sides; two corners of an edge.
struct Face {
  std::vector<Index> nodes;
  std::size_t corners = 0;
  Index element = 0;  ///< position in PlacedDeck::elements
};

/// A surface of *SURFACE with the nodes on it.
struct Surface {
  std::vector<Face> faces;      ///< none where it was given by nodes
  std::vector<Index> nodes;     ///< each once
  std::vector<double> weights;  ///< of the nodes: the area of faces around them, or what was given
};

/// The surface that a keyword at `where` names in a place; a problem where it is missing or of a kind that is not read.
Surface find_surface(PlacedDeck& deck, const std::string& name, int place, const Where& where);

}  // namespace kalfem::abaqus
