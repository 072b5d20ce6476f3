#pragma once

#include "kalfem/formats/abaqus/materials.hpp"

namespace kalfem::abaqus {

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

}  // namespace kalfem::abaqus
