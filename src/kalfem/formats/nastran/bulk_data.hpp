// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <variant>
#include <vector>

#include "kalfem/formats/nastran/card.hpp"
#include "kalfem/model/mesh/mesh.hpp"
#include "kalfem/model/mesh/properties.hpp"

namespace kalfem::nastran {

// What the cards of the bulk data say, in the terms of the manual, before it becomes a model. 0 stands for a node, a
// component or a coordinate system that is blank, unless it says otherwise.

inline constexpr double not_given = std::numeric_limits<double>::quiet_NaN();
inline bool given(double value) { return !std::isnan(value); }

struct Grid {
  Id id = 0;
  Id position_system = 0;                           ///< CP
  Id motion_system = 0;                             ///< CD, -1 of a scalar point
  unsigned held = 0;                                ///< PS, bit by direction
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< in CP as written; in basic axes once resolved
  Place where;
};
inline constexpr Id scalar_point = -1;

/// GRDSET.
struct GridDefaults {
  Id position_system = 0, motion_system = 0;
  unsigned held = 0;
};

enum class SystemKind { rectangular, cylindrical, spherical };

/// CORD1x (by nodes) or CORD2x (by points in a reference system).
struct SystemCard {
  SystemKind kind = SystemKind::rectangular;
  std::optional<std::array<Id, 3>> nodes;
  Id reference = 0;
  Eigen::Matrix3d points = Eigen::Matrix3d::Zero();  ///< columns: origin, on the z axis, in the x-z plane
  Place where;
};

/// CTRIA3, CQUAD4 and their kin with midside nodes.
struct ShellCard {
  Id id = 0, property = 0;
  bool triangle = false;
  std::array<Id, 8> nodes{};
  double angle = 0.0;           ///< THETA [deg]
  Id material_system = -1;      ///< MCID instead of the angle; -1: none
  double offset = 0.0;          ///< ZOFFS
  std::int32_t thickness = -1;  ///< place in corner_thickness, -1: of the property
  Place where;
};
/// T1 .. T4 with TFLAG.
struct CornerThickness {
  std::array<double, 4> values{};  ///< not_given: that of the property
  bool relative = false;           ///< shares of the property's thickness
};

/// CSHEAR.
struct ShearCard {
  Id id = 0, property = 0;
  std::array<Id, 4> nodes{};
  Place where;
};

struct SolidCard {
  Id id = 0, property = 0;
  CellShape shape = CellShape::hexahedron8;  ///< of the corners alone
  bool pyramid = false;                      ///< CPYRAM: five corners of a hexahedron
  std::array<Id, 20> nodes{};                ///< in the order of the card
  Place where;
};

/// CBAR, CBEAM. What BAROR or BEAMOR fill in is 0, or a vector that is zero.
struct BeamCard {
  Id id = 0, property = 0;
  std::array<Id, 2> nodes{};
  Id orientation_node = 0;                                ///< G0 instead of the vector
  Eigen::Vector3d orientation = Eigen::Vector3d::Zero();  ///< v
  std::array<char, 3> axes = {};                          ///< OFFT: of v and the offsets of both ends; "???": none
  std::array<unsigned, 2> pins{};                         ///< bit by direction, element axes
  bool is_bar = false;
  Eigen::Matrix<double, 3, 2> offsets = Eigen::Matrix<double, 3, 2>::Zero();  ///< WA, WB
  Place where;
};
/// BAROR, BEAMOR.
struct BeamDefaults {
  Id property = 0;
  Id orientation_node = 0;
  std::optional<Eigen::Vector3d> orientation;
  std::string axes = "GGG";
};

/// CROD, CTUBE, and CONROD with a property of its own.
struct RodCard {
  Id id = 0;
  const char* kind = "CROD";
  Id property = 0;
  std::array<Id, 2> nodes{};
  Place where;
};

/// CELASi, CDAMPi, CMASSi: a scalar element between two components, the second of which may be the ground.
struct ScalarCard {
  enum class Kind { spring, dashpot, mass } kind = Kind::spring;
  Id id = 0;
  Id property = 0;  ///< 0: the value is on the card
  double value = 0.0;
  std::array<Id, 2> nodes{};  ///< 0: the ground
  std::array<int, 2> components{};
  Place where = {};
};

/// CBUSH, CBUSH1D, CVISC.
struct BushCard {
  Id id = 0, property = 0;
  const char* kind = "CBUSH";
  std::array<Id, 2> nodes{};
  Id orientation_node = 0;
  std::optional<Eigen::Vector3d> orientation;
  Id axes = -1;           ///< CID; -1: from the orientation
  double location = 0.5;  ///< S
  Id offset_system = -1;  ///< OCID
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  Place where;
};
struct BushProperty {
  std::array<double, 6> stiffness{}, damping{};
  double mass = 0.0;
};

struct Conm1Card {
  Id id = 0, node = 0, system = 0;
  Eigen::Matrix<double, 6, 6> matrix;
  Place where;
};
struct Conm2Card {
  Id id = 0, node = 0, system = 0;  ///< -1: the offset is a place in basic axes
  double mass = 0.0;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  Place where;
};

struct Material1 {
  double youngs_modulus = not_given, shear_modulus = not_given, poissons_ratio = not_given, density = 0.0;
};
struct Material2 {
  Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();
  double density = 0.0;
};
struct Material8 {
  double e1 = 0.0, e2 = 0.0, nu12 = 0.0, g12 = 0.0, g13 = 0.0, g23 = 0.0, density = 0.0;  ///< 0: not given
};
struct Material9 {
  Eigen::Matrix<double, 6, 6> stiffness = Eigen::Matrix<double, 6, 6>::Zero();  ///< [xx yy zz xy yz zx]
  double density = 0.0;
};
struct MaterialCard {
  std::variant<Material1, Material2, Material8, Material9> law;
  Place where;
};

/// TABLEM1 .. TABLEM4, see apply_temperature().
struct MaterialTable {
  enum class Form { value, factor, polynomial } form = Form::factor;
  std::vector<std::pair<double, double>> points = {};  ///< by ascending x
  std::vector<double> coefficients = {};               ///< of a polynomial: A0, A1, ...
  double shift = 0.0, scale = 1.0;                     ///< X1, X2
  std::array<double, 2> range = {};                    ///< X3, X4 of a polynomial
  Place where = {};
};
/// MATTi: tables by the field that their values have on the MATi card.
struct MaterialTemperatureCard {
  std::string kind;  ///< "MAT1"
  std::vector<std::pair<std::size_t, Id>> tables;
  Place where;
};
/// An entry of TEMP or TEMPD.
struct TemperatureCard {
  Id set = 0, node = 0;  ///< node 0: all that have none of their own
  double value = 0.0;
  Place where = {};
};

struct PshellCard {
  Id membrane = 0, bending = 0, shear = 0, coupling = 0;  ///< MID1 .. MID4
  double thickness = not_given, bending_ratio = 1.0, shear_ratio = 5.0 / 6.0, nonstructural_mass = 0.0;
};
struct PlyCard {
  Id material = 0;
  double thickness = 0.0, angle = 0.0;
};
struct PshearCard {
  Id material = 0;
  double thickness = 0.0, nonstructural_mass = 0.0;
  std::array<double, 2> effectiveness{};  ///< F1 of the edges 1-2 and 3-4, F2 of 2-3 and 1-4
};
struct PcompCard {
  std::vector<PlyCard> plies;  ///< from the bottom up, the symmetric ones spelled out
  double bottom = not_given;   ///< Z0
  double nonstructural_mass = 0.0;
  std::string layout;  ///< LAM
};
struct PsolidCard {
  Id material = 0;
  Id axes = 0;
};
/// PBAR, PBARL, PBEAM, PBEAML: the section at end A.
struct SectionCard {
  Id material = 0;
  double area = 0.0, i1 = 0.0, i2 = 0.0, i12 = 0.0, torsion = 0.0, nonstructural_mass = 0.0;
  double k1 = 0.0, k2 = 0.0;                                       ///< 0: rigid in shear
  Eigen::Vector2d neutral_axis = Eigen::Vector2d::Zero();          ///< N1, N2
  Eigen::Vector2d nonstructural_centre = Eigen::Vector2d::Zero();  ///< M1, M2
  SectionOutline outline = {};                                     ///< of usual shapes
  double nonstructural_inertia = 0.0;                              ///< NSI
  /// Of a beam that is not the same all along: shares of the length from end A, 0 to 1, and the sections there.
  std::vector<std::pair<double, SectionCard>> stations = {};
};
struct RodSection {
  Id material = 0;
  double area = 0.0, torsion = 0.0, nonstructural_mass = 0.0;
};
using PropertyLaw = std::variant<PshellCard, PshearCard, PcompCard, PsolidCard, SectionCard, RodSection, BushProperty>;
/// What is different in the model from what a card describes.
struct Change {
  std::string what, consequence;
};
struct PropertyCard {
  std::string kind;  ///< name of the card
  PropertyLaw law;
  Place where;
  std::vector<Change> changes = {};  ///< told once for each element
};

/// A component of a node; `direction` 0 .. 5 in its displacement axes.
struct Term {
  Id node = 0;
  int direction = 0;
  double coefficient = 1.0;
};

struct RigidBodyCard {
  const char* kind = "RBE2";
  Id id = 0;
  std::vector<std::pair<Id, unsigned>> independent = {};  ///< components that lead
  std::vector<std::pair<Id, unsigned>> dependent = {};
  Place where = {};
};
struct WeightedCard {
  Id id = 0;
  Id reference = 0;
  unsigned components = 0;
  struct Group {
    double weight = 1.0;
    unsigned components = 0;
    std::vector<Id> nodes;
  };
  std::vector<Group> groups;
  std::vector<std::pair<Id, unsigned>> moved;  ///< UM: components that depend instead of the reference's
  Place where;
};
struct MpcCard {
  Id set = 0;
  std::vector<Term> terms;
  Place where;
};
struct SpcCard {
  Id set = 0;
  unsigned components = 0;
  std::vector<IdRange> nodes;
  Place where;
  double value = 0.0;  ///< D, of a single node
};

/// FORCE, MOMENT; FORCE1, FORCE2 and their moments, whose direction is that of grid points; SLOAD.
struct ForceCard {
  Id set = 0, node = 0, system = 0;
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();  ///< in the axes of the system
  bool is_moment = false;
  std::vector<Id> along = {};  ///< G1 G2: from the first to the second; G1 G2 G3 G4: (G2 - G1) x (G4 - G3)
  double size = 0.0;           ///< F or M along it
  Place where;
};
/// PLOAD2, PLOAD4.
struct PressureCard {
  Id set = 0;
  std::vector<IdRange> elements;
  double pressure = 0.0;
  Id first_corner = 0, other_corner = 0;  ///< G1, G3 or G4 of a solid's face
  Place where;
};
/// PLOAD: by the grid points of a triangle or quadrilateral, along its normal.
struct FacePressureCard {
  Id set = 0;
  std::vector<Id> corners;
  double pressure = 0.0;
  Place where;
};
/// PLOAD1.
struct BeamLoadCard {
  Id set = 0, element = 0;
  int direction = 0;          ///< 0 .. 5, forces and moments along x, y, z
  bool element_axes = false;  ///< otherwise basic ones
  bool fractions = false;     ///< places are shares of the length
  std::array<double, 2> places{}, values{};
  bool concentrated = false;  ///< the first value at the first place
  Place where;
};
/// RFORCE: angular velocity in revolutions per unit of time.
struct RotationCard {
  Id set = 0, node = 0, system = 0;
  Eigen::Vector3d revolutions = Eigen::Vector3d::Zero();  ///< A (R1, R2, R3)
  Place where;
};
/// A load that is not read, or a form of one: refused where a load case holds it.
struct UnreadLoadCard {
  Id set = 0;
  std::string what;
  Place where;
};
/// GRAV.
struct GravityCard {
  Id set = 0, system = 0;
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();
  Place where;
};
/// SPCD.
struct EnforcedCard {
  Id set = 0, node = 0;
  unsigned components = 0;
  double value = 0.0;
  Place where;
};

struct DmigEntry {
  Id row = 0, column = 0;
  std::int8_t row_direction = 0, column_direction = 0;
  double value = 0.0;
  Place where;
};
struct DmigMatrix {
  std::optional<int> form;  ///< IFO: 6 symmetric, 1 square, 2 or 9 rectangular
  bool complex = false;
  std::vector<DmigEntry> entries;
  Place where;
};

/// Masses and rigid elements may bear the number of an element that has stiffness.
enum class ElementKind : char { structural, mass, rigid };

struct BulkData {
  std::vector<Grid> grids;
  GridDefaults grid_defaults;
  std::map<Id, SystemCard> systems;

  std::vector<ShellCard> shells;
  std::vector<CornerThickness> corner_thickness;
  std::vector<ShearCard> shear_panels;
  std::vector<SolidCard> solids;
  std::vector<BeamCard> beams;
  BeamDefaults bar_defaults, beam_defaults;
  std::vector<RodCard> rods;
  std::vector<ScalarCard> scalars;
  std::vector<BushCard> bushes;
  std::vector<Conm1Card> mass_matrices;
  std::vector<Conm2Card> masses;
  /// Of all elements; numbers are unique within a kind.
  struct ElementNumber {
    ElementKind kind;
    Id id;
    Place where;
  };
  std::vector<ElementNumber> element_numbers;
  void add_element(ElementKind kind, Id id, const Place& where) { element_numbers.push_back({kind, id, where}); }

  std::map<Id, MaterialCard> materials;
  std::map<Id, Place> damped_materials;  ///< with GE
  std::map<Id, MaterialTable> material_tables;
  std::map<Id, MaterialTemperatureCard> material_temperatures;
  std::vector<TemperatureCard> temperatures;
  std::multimap<Id, PropertyCard> properties;  ///< of different kinds of elements also under one number
  std::map<Id, PropertyCard> conrods;          ///< sections of CONROD by its own number
  std::map<Id, double> spring_stiffness, dashpot_damping, scalar_mass;  ///< PELAS, PDAMP, PMASS
  std::map<Id, std::string> unread_properties, unread_materials;        ///< cards that are known and not read

  std::vector<RigidBodyCard> rigid;
  std::vector<WeightedCard> weighted;
  std::vector<MpcCard> mpcs;
  std::vector<SpcCard> spcs;
  std::map<Id, std::vector<Id>> mpc_sums, spc_sums;  ///< MPCADD, SPCADD

  bool with_loads = false;  ///< loads are wanted
  std::vector<ForceCard> forces;
  std::vector<PressureCard> pressures;
  std::vector<FacePressureCard> face_pressures;
  std::vector<BeamLoadCard> beam_loads;
  std::vector<RotationCard> rotations;
  std::vector<UnreadLoadCard> unread_loads;
  bool expands = false;  ///< a material has a coefficient of thermal expansion
  std::vector<GravityCard> gravities;
  std::vector<EnforcedCard> imposed;
  std::map<Id, std::vector<std::pair<Id, double>>> load_sums;  ///< LOAD: sets with their factors

  std::map<std::string, DmigMatrix> matrices;
  std::array<double, 3> direct_factors = {1.0, 1.0, 1.0};  ///< PARAM CK2, CM2, CB2 of K2GG, M2GG, B2GG
  double mass_factor = 1.0;                                ///< PARAM WTMASS
  bool coupled_mass = false;                               ///< PARAM COUPMASS
  double drilling = 100.0;                                 ///< PARAM K6ROT
  bool autospc = true;                                     ///< PARAM AUTOSPC
  std::optional<double> temperature = {};                  ///< at which materials are taken, if the user states one
};

}  // namespace kalfem::nastran
