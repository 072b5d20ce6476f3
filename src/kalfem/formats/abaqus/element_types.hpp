#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "kalfem/model/mesh/mesh.hpp"
#include "kalfem/model/mesh/properties.hpp"

namespace kalfem::abaqus {

/// What becomes of an element.
enum class Family {
  shell,
  membrane,
  solid,
  beam,
  truss,
  ground_spring,     ///< SPRING1
  spring,            ///< SPRING2
  axial_spring,      ///< SPRINGA
  ground_dashpot,    ///< DASHPOT1
  dashpot,           ///< DASHPOT2
  axial_dashpot,     ///< DASHPOTA
  mass,              ///< MASS
  rotary_inertia,    ///< ROTARYI
  reference,         ///< DCOUP3D: the reference node of a distributing coupling
  rigid,             ///< R3D3, R3D4, RB3D2: shape of a rigid body
  without_stiffness  ///< surface elements and gaps
};

struct ElementType {
  Family family = Family::shell;
  CellShape shape = CellShape::point1;
  int nodes = 0;                         ///< in the deck
  SolidKind kind = SolidKind::standard;  ///< of a solid
  bool shear_rigid = false;              ///< of a beam: Euler-Bernoulli
  std::string remark = {};               ///< what is left out of the element, for a note; may be empty
};

/// The element type by its name, in any case; nothing where it cannot be read.
std::optional<ElementType> element_type(std::string_view name);

/// Whether the family becomes cells of the mesh.
inline bool is_cell(Family family) { return family <= Family::beam; }

}  // namespace kalfem::abaqus
