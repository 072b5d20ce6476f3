// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "kalfem/formats/deck.hpp"
#include "kalfem/formats/gmsh/gmsh_builder.hpp"
#include "kalfem/formats/nastran/bulk_data.hpp"
#include "kalfem/formats/nastran/card_stream.hpp"
#include "kalfem/formats/nastran/case_control.hpp"

namespace kalfem::nastran {

/// A coordinate system in basic axes.
struct Frame {
  SystemKind kind = SystemKind::rectangular;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns x, y, z

  /// Basic place of coordinates: x y z; r theta z; or rho theta phi with theta from the z axis and phi about it, angles
  /// in degrees.
  [[nodiscard]] Eigen::Vector3d place(const Eigen::Vector3d& coordinates) const;
  /// Unit vectors along the coordinates at a place, as columns; on the z axis those of angle 0.
  [[nodiscard]] Eigen::Matrix3d directions(const Eigen::Vector3d& at) const;
};

/// All coordinate systems of a deck, and the places of its nodes, which depend on each other in any order.
class Frames {
public:
  /// Writes the places of the nodes in basic axes into bulk.grids. Notes systems that are missing, that depend on
  /// themselves and whose points lie on a line.
  Frames(BulkData& bulk, const NumberLookup& nodes, DeckFiles& files);
  /// The system of this number, 0 is the basic one; null where there is none, which is noted once with the place.
  [[nodiscard]] const Frame* find(Id system, const Place& where) const;

private:
  const Frame* resolve(Id system, const Place& where, int depth);
  bool resolve_node(Id node, const Place& where, int depth, Eigen::Vector3d& place);
  bool resolve_grid(std::size_t index, int depth);
  Frame from_points(const SystemCard& card, const Eigen::Matrix3d& points);

  BulkData& bulk_;
  const NumberLookup& nodes_;
  DeckFiles& files_;
  std::map<Id, Frame> frames_;
  std::map<Id, bool> failed_;
  std::vector<bool> placed_;
};

/// Matrices between degrees of freedom as they come in, entry by entry.
class MatrixGather {
public:
  enum Kind { stiffness, mass, damping };
  /// Adds value (row^T z) (column^T z): both triangles where row and column differ are the caller's.
  void add(Kind kind, const DofSum& row, const DofSum& column, double value);
  [[nodiscard]] bool empty() const { return index_.empty(); }
  [[nodiscard]] NodalMatrices finish(const std::string& name) const;

private:
  int index_of(const NodalDof& dof);
  std::map<NodalDof, int> index_;
  std::array<std::vector<Eigen::Triplet<double>>, 3> entries_;
};

/// What the steps from cards to model share.
struct Building {
  BulkData& bulk;
  const CaseControl& control;
  const NumberLookup& nodes;
  const Frames& frames;
  DeckFiles& files;
  DeckNotes& notes;
  FiniteElementModel& model;
  std::optional<std::int64_t> stated_subcase = {};        ///< load cases are read of this one alone
  std::set<Id> supports = {};                             ///< sets of SPC that hold, see build_constraints()
  std::map<Eigen::Index, Eigen::Index> local_nodes = {};  ///< of nodes with a CD system that load cases move along it
  MatrixGather matrices = {};  ///< of scalar masses, mass matrices and springs without a name of their own

  void note(const Place& place, const std::string& what, const std::string& consequence, DeckNoteKind kind) {
    notes.add(files.location(place), what, consequence, kind);
  }
  /// Index of a node; -1, with the problem noted, where there is none.
  Eigen::Index node(Id id, const std::string& title, const Place& where);
  [[nodiscard]] Eigen::Vector3d place(Eigen::Index node) const { return model.mesh.nodes.col(node); }
  /// Axes of the motions of a node: its CD system there, as columns.
  [[nodiscard]] Eigen::Matrix3d motion_axes(Eigen::Index node) const;
  [[nodiscard]] bool is_turned(Eigen::Index node) const;
  [[nodiscard]] bool is_scalar(Eigen::Index node) const;
  /// A component of a node by global degrees of freedom, times a factor, appended to the terms.
  void append(DofSum& terms, Eigen::Index node, int component, double factor) const;
};

/// Materials as regions need them, of the cards and with PARAM WTMASS applied.
class Materials {
public:
  explicit Materials(Building& building) : building_(building) {}
  /// Name in the model of an isotropic material, which is put into it; empty, with the problem noted, where the number
  /// is none or not isotropic.
  std::string isotropic(Id id, const std::string& title, const Place& where);
  /// The card; null, with the problem noted, where there is none.
  const MaterialCard* find(Id id, const std::string& title, const Place& where);
  /// E, nu and rho of a MAT1 card, two of E, G and nu given.
  IsotropicMaterial complete(const Material1& law, const Place& where);
  /// Given G over E / (2 (1 + nu)).
  [[nodiscard]] double shear_ratio(Id id) const;

private:
  Building& building_;
};

void build_shells(Building& building, Materials& materials);
void build_shear_panels(Building& building, Materials& materials);
void build_solids(Building& building, Materials& materials);
void build_beams(Building& building, Materials& materials);
void build_rods(Building& building, Materials& materials);
void build_scalars(Building& building);
void build_bushes(Building& building);
void build_masses(Building& building);
void build_direct_matrices(Building& building);
void build_constraints(Building& building);
/// Tells of the structural damping of materials, once for each element that has one.
void note_damped_elements(Building& building);
/// The sets of SPC that a subcase's choice stands for, sums followed.
std::set<Id> spc_sets(Building& building, std::optional<Id> spc);
/// Supports by these sets, with the permanent ones of GRID cards: those of a load case that has other ones than the
/// model.
std::vector<FixedNodes> supports_of(Building& building, const std::set<Id>& sets);
/// One load case for each subcase, "subcase1", ...; without case control for each set of loads, "load5". Loads that are
/// not read, and subcases that need another structure than the model's, are problems.
std::vector<LoadCase> build_load_cases(Building& building);
/// The load case whose stresses the chosen subcase carries (STATSUB); nothing where it carries none.
std::optional<LoadCase> build_preload(Building& building);
/// Bars in one line whose twist as a whole nothing holds keep its inertia in their lumped mass, with a note.
void keep_free_twist(Building& building);
/// Supports of load cases that have other ones than the model.
using OtherSupports = std::vector<std::vector<FixedNodes>*>;
/// PARAM AUTOSPC: holds the motions of nodes that nothing stiffens, see singular_motions.cpp.
void apply_autospc(Building& building, const OtherSupports& others);
/// PARAM K6ROT, see singular_motions.cpp.
void apply_k6rot(Building& building, const OtherSupports& others);

/// Cells of a property that share what a region holds. `key` tells variants apart; names are "pshell3", "pshell3.2",
/// ...
class RegionNames {
public:
  /// Name of the region of this property and variant, and whether it is new.
  std::pair<std::string, bool> name(const std::string& base, const std::vector<double>& key);

private:
  std::map<std::pair<std::string, std::vector<double>>, std::string> names_;
  std::map<std::string, int> variants_;
};

/// Properties of different kinds of elements may share a number. The one that `fits`; null, with the problem noted,
/// where there is none of this number, or none that fits.
const PropertyCard* find_property(Building& building, Id property, const std::string& title, const Place& where,
                                  const std::function<bool(const PropertyCard&)>& fits);

template <typename Law>
const Law* find_law(Building& building, Id property, const std::string& title, const Place& where) {
  const auto fits = [](const PropertyCard& card) { return std::holds_alternative<Law>(card.law); };
  const PropertyCard* card = find_property(building, property, title, where, fits);
  return card == nullptr ? nullptr : &std::get<Law>(card->law);
}

/// sum of the terms = 0, of which a component of a node, in its own axes, depends.
struct DependentRow {
  NodalDof dependent;  ///< direction in the node's displacement axes
  DofSum terms;
};
using NodeComponents = std::vector<std::pair<Eigen::Index, unsigned>>;

/// Dependent components of a rigid body from its independent ones: with the rigid motion q about the first node and the
/// rows R of all components, u_d = R_d R_i^-1 u_i. Empty where six independent ones do not determine q.
std::vector<DependentRow> rigid_rows(const Building& building, const NodeComponents& independent,
                                     const NodeComponents& dependent);

/// a . (u_B - u_A) = 0 along the line of two nodes; the one component of either that is given depends.
std::optional<DependentRow> rod_row(const Building& building, const NodeComponents& nodes);

/// A weighted link (see WeightedLink) whose components are those of the nodes' own axes, and whose equations are solved
/// for the components `moved` where there are any. Empty where that cannot be.
std::vector<DependentRow> weighted_rows(const Building& building, const WeightedLink& link,
                                        const NodeComponents& moved);

}  // namespace kalfem::nastran
