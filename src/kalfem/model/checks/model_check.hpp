// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/linalg/stiffness_factor.hpp"
#include "kalfem/model/assembly/rigid_body.hpp"
#include "kalfem/model/assembly/rigid_motion.hpp"
#include "kalfem/model/linear_model.hpp"
#include "kalfem/model/mesh/mesh.hpp"
#include "kalfem/model/mesh/properties.hpp"

namespace kalfem {

/// Measures of the shape of a cell, by its corners; of quadratic cells too.
enum class QualityMeasure {
  aspect_ratio,    ///< longest side / shortest side; 1e9 where two nodes stand at one place
  smallest_angle,  ///< between two sides of a face [deg]
  largest_angle,   ///< the same [deg]
  warp,   ///< quadrilaterals and such faces: between the two triangles beside a diagonal, the larger of two [deg]
  taper,  ///< the same: smallest of the corners' triangles / mean of the four; 1 for a parallelogram
  scaled_jacobian,  ///< least over the corners of the edges' determinant / product of their lengths, so scaled that
                    ///< equilateral triangles and tetrahedra, and rectangles, have 1 [Knu03]; <= 0: not convex or
                    ///< turned inside out
};
inline constexpr int quality_measures = 6;
std::string to_string(QualityMeasure measure);

/// Values of all measures, in their order.
using CellQuality = std::array<double, quality_measures>;

/// Shape of a triangle, quadrilateral, tetrahedron, wedge or hexahedron. Sides and corners that collapse because the
/// cell names a node twice are left out. Finite for finite coordinates.
CellQuality cell_quality(const Mesh& mesh, const Cell& cell);

/// Limits beyond which a cell counts as badly shaped, in the order of the measures; usual ones of meshing practice.
struct QualityLimits {
  CellQuality limits = {20.0, 15.0, 165.0, 15.0, 0.3, 0.2};
};

/// Whether larger values of a measure are worse.
bool is_worse_when_larger(QualityMeasure measure);

/// One measure over the cells of a region.
struct QualityOfRegion {
  QualityMeasure measure = QualityMeasure::aspect_ratio;
  double worst = 0.0;
  double mean = 0.0;
  Eigen::Index beyond = 0;                ///< cells beyond the limit
  std::vector<Eigen::Index> worst_cells;  ///< indices of up to 5 cells beyond the limit, the worst first
};

/// Shapes of a region's surfaces and solids.
struct RegionQuality {
  std::string region;
  std::map<CellShape, Eigen::Index> cells;  ///< how many of each shape, lines and points too
  Eigen::Index measured = 0;                ///< surfaces and solids
  std::array<QualityOfRegion, quality_measures> measures;
};

RegionQuality region_quality(const Mesh& mesh, const std::string& region, const QualityLimits& limits = {});

/// Stiffness and density of a kind of structural material, as the usual handbooks give them; ranges.
struct UsualMaterial {
  const char* name;
  double least_modulus, most_modulus;  ///< E [Pa]
  double least_density, most_density;  ///< rho [kg/m^3]
};

/// Steel, aluminium, titanium, ..., composites, wood, rubber, foam; the narrower kinds first.
const std::vector<UsualMaterial>& usual_materials();

/// Units in which decks are written.
struct UsualUnits {
  const char* name;                   ///< "mm, t, s (N, MPa)"
  const char* length;                 ///< as units of kalfem are written: "mm"
  const char* mass;                   ///< "t"
  const char* time;                   ///< "s"
  double metres, kilograms, seconds;  ///< of one unit of each in SI
};
const std::vector<UsualUnits>& usual_units();

/// The kind of material whose ranges hold these values in SI; none: no usual one.
std::optional<UsualMaterial> usual_material(double youngs_modulus, double density);

/// sqrt(E / rho), the speed of a longitudinal wave in a bar; 0 without density.
double wave_speed(const IsotropicMaterial& material);

/// A material's numbers as usual ones in other units than SI.
struct UnitsGuess {
  UsualUnits units;
  UsualMaterial material;
};

/// Units in which the numbers are those of a usual material, SI left out; the more common units first.
std::vector<UnitsGuess> units_that_fit(const IsotropicMaterial& material);

/// One of the six rigid-body motions of a structure: along x, y, z, and about axes through its middle.
struct RigidMotion {
  bool exists = true;     ///< it moves any degree of freedom
  bool strained = false;  ///< it takes force, so something holds it
  double largest = 0.0;   ///< largest |(K r)_i| / sum_j |K_ij| |r_j|max over the degrees of freedom, in [0, 1]
};

/// A degree of freedom at which a rigid-body motion takes force though nothing holds it there.
struct StrayForce {
  Eigen::Index dof = 0;
  double ratio = 0.0;  ///< as RigidMotion::largest, of the worst combination of motions
};

/// How a structure is held.
struct GroundingCheck {
  std::array<RigidMotion, 6> motions;
  int existing = 0;               ///< independent rigid-body motions of the degrees of freedom
  int free = 0;                   ///< combinations of them that take no force
  std::vector<StrayForce> stray;  ///< the largest first, at most 10
  Eigen::Index stray_count = 0;
};

/// Applies the six rigid-body motions R (n x 6) to the stiffness: K R = 0 where nothing holds the structure. Rotations
/// are scaled by the size of the structure, so that all compare; rows below 1e-10 of what cancels in them count as
/// rounding. `held`: degrees of freedom at which force is expected, because they are next to a support or hang on a
/// ground; force of more than 1e-6 elsewhere is stray: elements or springs that resist a rigid motion, matrices that
/// were condensed wrongly, constraints that are no rigid body's.
GroundingCheck check_grounding(const SparseMatrix& stiffness, const Eigen::MatrixXd& rigid_motions,
                               const std::vector<bool>& held);

enum class FindingSeverity {
  note,     ///< worth knowing
  warning,  ///< probably not meant
  error     ///< results would be wrong, or cannot be computed
};

/// What a finding is about.
enum class FindingTopic { mesh, elements, materials, units, mass, stiffness, grounding, connections };
std::string to_string(FindingTopic topic);
std::string to_string(FindingSeverity severity);

/// One thing that a look at the model brought up.
struct ModelFinding {
  FindingSeverity severity = FindingSeverity::note;
  FindingTopic topic = FindingTopic::mesh;
  std::string what;                      ///< the fact, with names and values
  std::string why;                       ///< what follows from it
  std::string fix;                       ///< what to do (may be empty)
  std::vector<Eigen::Index> nodes = {};  ///< that show it, up to 1000, for a picture; indices
};

/// A region of the mesh.
struct RegionCheck {
  std::string name;
  std::string kind;      ///< "shell", "laminate", "beam", "solid"; "" where it has no property
  std::string material;  ///< "" of laminates and where there is no property
  Eigen::Index cells = 0;
  double measure = 0.0;    ///< length, area or volume by the corners of the cells [m, m^2, m^3]
  double thickness = 0.0;  ///< of shells [m]
  double area = 0.0;       ///< of a beam's section [m^2]
  double mass = 0.0;       ///< [kg]
};

/// A material of the model.
struct MaterialCheck {
  std::string name;
  IsotropicMaterial values;
  double wave_speed = 0.0;           ///< sqrt(E / rho) [m/s]
  std::string resembles;             ///< the usual material with such values in SI; "" none
  std::vector<std::string> used_by;  ///< regions
};

/// A symmetric matrix of the model.
struct MatrixCheck {
  bool finite = true;                  ///< all entries; nothing else is known where one is not
  double asymmetry = 0.0;              ///< largest |A_ij - A_ji| / largest |A_ij|
  Eigen::Index negative_diagonal = 0;  ///< entries below zero
  Eigen::Index empty_diagonal = 0;     ///< entries that are zero
  std::optional<bool> semi_definite;   ///< whether A + 1e-10 diag(A) has a Cholesky factor; empty: not tried
};

/// What a model is made of and what speaks against it; data only.
struct ModelCheckReport {
  std::vector<ModelFinding> findings;  ///< errors first
  Eigen::Index nodes = 0, cells = 0, degrees_of_freedom = 0;
  Eigen::Vector3d lowest = Eigen::Vector3d::Zero(), highest = Eigen::Vector3d::Zero();  ///< corners of the box [m]
  std::optional<MassProperties> mass;  ///< of the whole; empty where the places of the degrees of freedom are unknown
  std::optional<Eigen::Vector3d> moving_mass;  ///< part that the free degrees of freedom move along x, y, z [kg]; empty
                                               ///< of matrices, which do not tell what is held
  std::optional<GroundingCheck> grounding;     ///< likewise
  std::vector<std::string> stray_dofs;         ///< names of Grounding::stray
  std::vector<std::string> mechanisms;         ///< as of find_mechanisms(); where it was looked for
  MatrixCheck stiffness_matrix, mass_matrix;
  Eigen::Index fixed_dofs = 0;        ///< directions of supports
  Eigen::Index grounded_dofs = 0;     ///< degrees of freedom with springs or dashpots to a ground
  Eigen::Index free_nodes = 0;        ///< that nothing touches
  Eigen::Index coincident_pairs = 0;  ///< of nodes that belong to something
  Eigen::Index unjoined_pairs = 0;    ///< of these, joined by nothing
  std::vector<Eigen::Index> parts;    ///< numbers of nodes of what holds together, the largest first
  std::vector<RegionCheck> regions;
  std::vector<MaterialCheck> materials;
  std::vector<RegionQuality> quality;                  ///< of regions with surfaces or solids and a property
  std::vector<double> lowest_frequencies;              ///< [Hz], of bare matrices only, where they were computed
  std::shared_ptr<const StiffnessFactor> factor = {};  ///< of K held, where it shows that there are no mechanisms

  [[nodiscard]] Eigen::Index count(FindingSeverity severity) const;
};

struct ModelCheckOptions {
  bool mechanisms = true;    ///< look for motions without strain: a factor of K, and where it has none about 100 solves
  bool definiteness = true;  ///< try a Cholesky factor of M too, if it is no sum of elements and masses alone (and of K
                             ///< where there are no mechanisms looked for)
  double coincidence = 1e-6;  ///< nodes nearer than this part of the model's diagonal stand at one place
  QualityLimits quality = {};
  Eigen::Index frequencies = 12;          ///< of bare matrices: how many of the lowest to compute; 0: none
  bool needs_mass = true;                 ///< a model without mass is an error, as statics alone need none: then a note
  std::vector<Eigen::Index> joined = {};  ///< nodes at which something outside joins the model
  std::shared_ptr<const StiffnessFactor> factor = {};  ///< factor_held() of K, where it is at hand
};

/// Looks a model over before it is used: mass, grounding, mechanisms, symmetry and definiteness, nodes that nothing
/// touches or that stand at one place, parts that hang on nothing, shapes of cells, units and materials, springs much
/// stiffer than what they hang on. Time and memory grow with the number of nodes, but for the factorisations. Never
/// throws for what is wrong with the model itself: that is a finding.
ModelCheckReport check_model(const FiniteElementModel& model, const AssembledModel& assembled,
                             const ModelCheckOptions& options = {});
/// The same with K and M at hand, whose terms `assembled` need not have then.
ModelCheckReport check_model(const FiniteElementModel& model, const AssembledModel& assembled,
                             const SparseMatrix& stiffness, const SparseMatrix& mass,
                             const ModelCheckOptions& options = {});

/// A material whose values are usual in other units than SI, while no material of the model is usual in SI: the deck or
/// the mesh was written in these units. Empty: nothing speaks for them.
std::optional<ModelFinding> units_finding(const FiniteElementModel& model);

/// Elements of one kind on the same nodes, both of which count. Empty: there are none.
std::optional<ModelFinding> coincident_elements_finding(const FiniteElementModel& model);

/// check_model() for matrices from elsewhere. `places`: of each degree of freedom, or none where they are unknown; then
/// mass and grounding are left out.
ModelCheckReport check_model(const LinearModel& model, const std::vector<PlacedDof>& places = {},
                             const ModelCheckOptions& options = {});

}  // namespace kalfem
