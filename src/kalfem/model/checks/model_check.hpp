#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/model/assembly/mass_properties.hpp"
#include "kalfem/model/checks/element_quality.hpp"
#include "kalfem/model/checks/grounding_check.hpp"
#include "kalfem/model/checks/plausibility.hpp"

namespace kalfem {

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
struct RegionHealth {
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
struct MaterialHealth {
  std::string name;
  IsotropicMaterial values;
  double wave_speed = 0.0;           ///< sqrt(E / rho) [m/s]
  std::string resembles;             ///< the usual material with such values in SI; "" none
  std::vector<std::string> used_by;  ///< regions
};

/// A symmetric matrix of the model.
struct MatrixHealth {
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
  MatrixHealth stiffness_matrix, mass_matrix;
  Eigen::Index fixed_dofs = 0;        ///< directions of supports
  Eigen::Index grounded_dofs = 0;     ///< degrees of freedom with springs or dashpots to a ground
  Eigen::Index free_nodes = 0;        ///< that nothing touches
  Eigen::Index coincident_pairs = 0;  ///< of nodes that belong to something
  Eigen::Index unjoined_pairs = 0;    ///< of these, joined by nothing
  std::vector<Eigen::Index> parts;    ///< numbers of nodes of what holds together, the largest first
  std::vector<RegionHealth> regions;
  std::vector<MaterialHealth> materials;
  std::vector<RegionQuality> quality;      ///< of regions with surfaces or solids and a property
  std::vector<double> lowest_frequencies;  ///< [Hz], of bare matrices only, where they were computed

  [[nodiscard]] Eigen::Index count(FindingSeverity severity) const;
};

struct ModelCheckOptions {
  bool mechanisms = true;     ///< look for motions without strain: one factorisation of K and about 100 solves
  bool definiteness = true;   ///< try a Cholesky factor of M too (K's where there are no mechanisms looked for)
  double coincidence = 1e-6;  ///< nodes nearer than this part of the model's diagonal stand at one place
  QualityLimits quality = {};
  Eigen::Index frequencies = 12;  ///< of bare matrices: how many of the lowest to compute; 0: none
};

/// Looks a model over before it is used: mass, grounding, mechanisms, symmetry and definiteness, nodes that nothing
/// touches or that stand at one place, parts that hang on nothing, shapes of cells, units and materials, springs much
/// stiffer than what they hang on. Time and memory grow with the number of nodes, but for the factorisations. Never
/// throws for what is wrong with the model itself: that is a finding.
ModelCheckReport check_model(const FiniteElementModel& model, const AssembledModel& assembled,
                             const ModelCheckOptions& options = {});

/// The same for matrices from elsewhere. `places`: of each degree of freedom, or none where they are unknown; then mass
/// and grounding are left out.
ModelCheckReport check_model(const LinearModel& model, const std::vector<PlacedDof>& places = {},
                             const ModelCheckOptions& options = {});

}  // namespace kalfem
