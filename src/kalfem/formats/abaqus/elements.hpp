// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <set>

#include "kalfem/formats/abaqus/kinematics.hpp"
#include "kalfem/formats/abaqus/placed_deck.hpp"
#include "kalfem/formats/abaqus/temperatures.hpp"
#include "kalfem/model/mesh/laminate_theory.hpp"

namespace kalfem::abaqus {

/// A beam's cross-section in the deck's axes 1 and 2, measured from the section's origin.
struct BeamProfile {
  double area = 0.0;
  double i11 = 0.0, i12 = 0.0, i22 = 0.0;  ///< about the centroid: int x2^2 dA, int x1 x2 dA, int x1^2 dA
  double torsion = 0.0;
  double shear_1 = 0.0, shear_2 = 0.0;  ///< shear area / A for forces along 1 and 2; 0: shear rigid
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  Eigen::Vector2d shear_centre = Eigen::Vector2d::Zero();
  SectionOutline outline = {};  ///< corners by axes 1 and 2, from the centroid
};

/// The profile of SECTION=shape from the numbers of its data line: RECT, CIRC, PIPE, BOX, I, L, GENERAL. Shear factors
/// of massive and closed sections are Cowper's [Cow66], of open ones the area of the walls along the force (5/6 of it
/// in flanges) over the whole; torsion of open sections is sum b t^3 / 3. Nothing and a problem where the shape is
/// another one or the numbers make none.
std::optional<BeamProfile> beam_profile(const std::string& shape, const std::vector<double>& data,
                                        double poissons_ratio, const Where& where, Problems& problems);

/// How many numbers the data line of SECTION=shape has; 0 for a shape that is not read.
std::size_t profile_numbers(const std::string& shape);

/// As a section with local y against axis 2 and local z along axis 1, so that `up` of a placement is axis 1.
BeamSection section_of(const BeamProfile& profile);

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
  Materials(const RawDeck& raw, PlacedDeck& deck) : raw_(raw), deck_(deck), temperature_(raw, deck) {}

  /// The material that a keyword at `where` names; nothing and a problem where it is missing or not elastic.
  const Elastic* find(const std::string& name, const Where& where);
  /// All that were found.
  [[nodiscard]] std::map<std::string, IsotropicMaterial> used() const;
  /// Whether one of them depends on temperature.
  [[nodiscard]] bool depend_on_temperature() const { return temperature_.is_used(); }
  /// At which they are taken, for what else depends on temperature.
  [[nodiscard]] MaterialTemperature& temperature() { return temperature_; }

private:
  void read(const RawDeck::Material& raw, Elastic& material);
  void read_elastic(const Block& block, Elastic& material);

  const RawDeck& raw_;
  PlacedDeck& deck_;
  MaterialTemperature temperature_;
  std::map<std::string, Elastic> known_;
  std::set<std::string> broken_;
};

/// Cells of one region before it gets its property.
struct RegionDraft {
  std::string name;
  PlacedBlock section;
  std::vector<Index> elements;  ///< positions in PlacedDeck::elements
  std::vector<Index> cells;     ///< of the mesh, in the same order
  Family family = Family::shell;
  SolidKind kind = SolidKind::standard;
  bool shear_rigid = false;
};

/// Gives every element its section, makes the cells of the mesh and the regions with their properties.
void build_regions(const RawDeck& raw, PlacedDeck& deck, Materials& materials, FiniteElementModel& model);

/// A name that no region has yet: NAME, NAME.2, NAME.3 ...
std::string free_region_name(const FiniteElementModel& model, const std::string& name);

/// Properties of a draft's section; problems are noted, and the region is left without one then.
void add_shell_region(PlacedDeck& deck, Materials& materials, const RegionDraft& draft, FiniteElementModel& model);
void add_beam_region(PlacedDeck& deck, Materials& materials, const RegionDraft& draft, FiniteElementModel& model);
void add_solid_region(PlacedDeck& deck, Materials& materials, const RegionDraft& draft, FiniteElementModel& model);
/// Trusses: a spring of stiffness E A / L along the axis, half the mass at each end.
void add_trusses(PlacedDeck& deck, Materials& materials, const RegionDraft& draft, FiniteElementModel& model);

/// Splits the regions whose sections say NODAL THICKNESS, once their cells are the final ones.
void apply_nodal_thickness(PlacedDeck& deck, FiniteElementModel& model);

/// Centre of a cell, and the normal of a surface by the right-hand rule.
Eigen::Vector3d centre_of(const Mesh& mesh, Index cell);
Eigen::Vector3d normal_of(const Mesh& mesh, Index cell);

/// SPRING1, SPRING2, SPRINGA and DASHPOT1, DASHPOT2, DASHPOTA with their *SPRING and *DASHPOT.
/// Values by temperature are taken at that of the materials.
void add_springs(PlacedDeck& deck, MaterialTemperature& temperature, FiniteElementModel& model);
/// MASS and ROTARYI with their *MASS and *ROTARY INERTIA.
void add_masses(PlacedDeck& deck, FiniteElementModel& model);
/// *NONSTRUCTURAL MASS, as masses at nodes. The regions must be there.
void add_nonstructural_masses(PlacedDeck& deck, FiniteElementModel& model);
/// *MATRIX ASSEMBLE of CalculiX: lines "node, direction, node, direction, value" of one triangle.
void add_matrices(const RawDeck& raw, PlacedDeck& deck, FiniteElementModel& model);

}  // namespace kalfem::abaqus
