// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/deck.hpp"
#include "kalfem/identification/finite_element_part.hpp"
#include "kalfem/model/finite_element_model.hpp"
#include "kalfem/model/mesh/properties.hpp"
#include "kalfem/model/unit_system.hpp"

/// Finite-element substructures as the case file states them, see description.hpp.
namespace kalfem::description {

using Value = Located<Quantity>;        ///< a number whose unit depends on its use
using Points = Located<Named<double>>;  ///< a point, or a weighted sum of points

struct Material {
  double youngs_modulus = 0.0, poissons_ratio = 0.3, density = 0.0;
};
struct RectangleSection {
  double width = 0.0, height = 0.0;
};
struct CircleSection {
  double diameter = 0.0;
};
struct CircularTubeSection {
  double diameter = 0.0, wall = 0.0;
};
struct RectangularTubeSection {
  double width = 0.0, height = 0.0, wall = 0.0;
};
struct GeneralSection {
  double area = 0.0, inertia_y = 0.0, inertia_z = 0.0, torsion = 0.0, shear_factor_y = 0.0, shear_factor_z = 0.0;
};
using Section =
    std::variant<RectangleSection, CircleSection, CircularTubeSection, RectangularTubeSection, GeneralSection>;
struct SectionHolder {
  Section section;
};
struct ShellRegion {
  double thickness = 0.0, offset = 0.0;
};
struct SolidRegion {
  SolidKind kind = SolidKind::standard;
};
struct BeamRegion {
  SectionHolder section;
  std::array<double, 3> up{0.0, 0.0, 1.0}, offset{};
};
struct Region {
  Name material;
  std::variant<ShellRegion, BeamRegion, SolidRegion> property;
};
/// A node by a group of the mesh, by its number, or the nearest one to a place.
struct NodePlace {
  std::string group;
  std::array<double, 3> at{};  ///< used if there is no group [m]
};
struct GaugeElement {
  std::int64_t number = 0;
};
/// A strain gauge at a place or on an element, see GaugeDescription.
struct Gauge {
  std::variant<Located<NodePlace>, GaugeElement> place;
  std::optional<std::array<double, 3>> direction;
  std::optional<Layer> surface;
  std::optional<std::array<double, 2>> fibre;  ///< [m]
  std::optional<Name> region;
};
struct NodeMass {
  Name at;
  double mass = 0.0;
  std::array<double, 3> inertia{}, offset{};
};
struct Link {
  Name master;
  Located<std::string> nodes;
  std::vector<std::string> directions;
};
struct Fixed {
  Located<std::string> nodes;
  std::vector<std::string> directions;
};
/// Source of the elements: a mesh or two tables, whose regions get their properties here; an input file of another
/// code, which holds its own properties; or matrices of another code.
struct MeshFile {
  Located<std::filesystem::path> file;
  double scale = 1.0;  ///< of the mesh's coordinates to metres
};
/// A stick model: tables of nodes and of line elements.
struct TableFiles {
  Located<std::filesystem::path> nodes, elements;
  std::optional<double> scale;  ///< of the coordinates to metres
};
struct DeckFile {
  Located<std::filesystem::path> file;
  DeckFormat format = DeckFormat::automatic;
  UnitSystem units;
  std::optional<double> temperature;  ///< of the materials, in the deck's unit; if empty, as the deck says
  std::optional<int> subcase;         ///< of Nastran, whose structure is meant; if empty, as DeckOptions says
  std::vector<Name> accept_missing;   ///< cards or keywords with stiffness, mass or connections that are not read
};
/// Stiffness, mass and damping in one file or several, by the names of the matrices in the file.
struct MatrixSet {
  std::vector<Located<std::filesystem::path>> files;
  std::string stiffness, mass, damping;
  std::optional<Located<std::filesystem::path>> dofs;
  int directions = 0;
};
struct MatrixFiles {
  std::vector<MatrixSet> sets;
  std::optional<Located<std::filesystem::path>> coordinates;
  UnitSystem units;
};
/// A matrix by its file, and by its name where the file holds several.
struct FactorMatrix {
  std::filesystem::path file;
  std::string name;
};
/// Matrices that a factor multiplies.
struct MatricesOfFactor {
  std::optional<FactorMatrix> stiffness, mass, damping;
  std::optional<Located<std::filesystem::path>> dofs;
  int directions = 0;
};
/// Elements that a factor multiplies.
struct ElementsOfFactor {
  std::vector<Name> elements;
  FactorOf of = FactorOf::stiffness;
};
struct Factor {
  std::variant<MatricesOfFactor, ElementsOfFactor> part;
  double value = 1.0;
};
/// A turn about an axis through a point, by the right-hand rule.
struct Turn {
  std::array<double, 3> axis{};   ///< direction, of any length but 0
  double angle = 0.0;             ///< [rad]
  std::array<double, 3> about{};  ///< a point of the axis [m]
};
struct FiniteElements {
  std::variant<MeshFile, TableFiles, DeckFile, MatrixFiles> source;
  std::optional<Turn> rotate;         ///< of all that the source holds
  std::array<double, 3> translate{};  ///< of all nodes, after the turn [m]
  Named<Material> materials;
  Named<Region> regions;
  Named<Located<NodePlace>> nodes;
  Named<Located<Gauge>> gauges;
  Named<NodeMass> masses;
  Named<Link> links;
  Named<Fixed> fixed;
  Named<Located<Factor>> factors;
  std::optional<MassKind> mass_matrix;

  /// Place of the file (the first one) in the case.
  [[nodiscard]] const SourceLocation& location() const;
};
struct Reduction {
  ReductionMethod method = ReductionMethod::craig_bampton;
  std::optional<int> modes;
  std::optional<double> up_to, effective_mass;
  bool augmentation_vectors = true;
  std::vector<Name> boundary;
};
/// Two groups of coincident nodes that move as one.
struct Joint {
  std::array<Name, 2> between;      ///< "substructure.group"
  std::optional<double> tolerance;  ///< largest distance of two nodes that are joined [m]
};

}  // namespace kalfem::description
