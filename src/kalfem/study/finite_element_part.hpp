#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kalfem/casefile/description.hpp"
#include "kalfem/formats/deck.hpp"
#include "kalfem/identification/finite_element_part.hpp"

namespace kalfem {

/// A finite-element substructure of a case, and what there is to say of it.
struct DescribedPart {
  FiniteElementPart part;
  std::vector<DeckNote> notes;        ///< the cards of its deck that were not used
  std::vector<std::string> warnings;  ///< on the boundary, in sentences
};

/// Reads the mesh, deck or matrices, assembles and damps them. `attached`: the points of it that connectors and forces
/// touch ("p1.z"). Throws InvalidInput with every problem and its place.
/// `parameters`: names of parameters that will change, without the substructure's own; those of beams are kept apart
/// only where they are named.
DescribedPart make_finite_element_part(const std::string& name, const description::Substructure& given,
                                       const std::vector<std::string>& attached,
                                       const std::vector<std::string>& parameters);

/// How the case reduces it; by default as ReductionRequest says.
ReductionRequest reduction_request(const std::optional<Located<description::Reduction>>& given);

}  // namespace kalfem
