#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kalfem/casefile/description.hpp"
#include "kalfem/formats/deck.hpp"
#include "kalfem/identification/finite_element_part.hpp"

namespace kalfem {

/// A finite-element substructure of a case, with notes on its deck and warnings.
struct DescribedPart {
  FiniteElementPart part;
  std::vector<DeckNote> notes;        ///< the cards of its deck that were not used
  std::vector<std::string> warnings;  ///< one sentence each, about the boundary
};

/// Reads the mesh, deck or matrices, assembles and damps them. `attached`: the points of it that connectors and forces
/// touch ("p1.z"). Throws InvalidInput with every problem and its place.
/// `parameters`: names of the parameters that will change, without the name of the substructure. Section parameters of
/// beams stay separate only if they are named here.
/// `statics`: the static load cases of this substructure, if it has some.
DescribedPart make_finite_element_part(const std::string& name, const description::Substructure& given,
                                       const std::vector<std::string>& attached,
                                       const std::vector<std::string>& parameters, const description::Statics* statics);

/// The reduction that the case asks for; ReductionRequest states the defaults.
ReductionRequest reduction_request(const std::optional<Located<description::Reduction>>& given);

}  // namespace kalfem
