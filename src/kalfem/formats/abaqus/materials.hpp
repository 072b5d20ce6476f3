#pragma once

#include <map>
#include <set>

#include "kalfem/formats/abaqus/placed_deck.hpp"
#include "kalfem/model/mesh/laminate_theory.hpp"

namespace kalfem::abaqus {

/// A linear elastic material of the deck.
struct Elastic {
  std::string name;
  bool isotropic = true;
  IsotropicMaterial scalar;  ///< of one that is not isotropic: the density, and stiffness of about its size
  std::optional<OrthotropicSheet> sheet;  ///< in plane stress; none of an anisotropic one
  std::optional<Matrix6> solid;           ///< of a material that is not isotropic, in its own axes; none of a lamina
};

/// The materials of a deck by name. Only those that are asked for are read.
class Materials {
public:
  Materials(const RawDeck& raw, PlacedDeck& deck) : raw_(raw), deck_(deck) {}

  /// The material that a keyword at `where` names; nothing and a problem where it is missing or not elastic.
  const Elastic* find(const std::string& name, const Where& where);
  /// All that were found.
  [[nodiscard]] std::map<std::string, IsotropicMaterial> used() const;

private:
  void read(const RawDeck::Material& raw, Elastic& material);
  void read_elastic(const Block& block, Elastic& material);

  const RawDeck& raw_;
  PlacedDeck& deck_;
  std::map<std::string, Elastic> known_;
  std::set<std::string> broken_;
};

}  // namespace kalfem::abaqus
