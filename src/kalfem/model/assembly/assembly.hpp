// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "kalfem/model/assembly/matrix_sums.hpp"
#include "kalfem/model/assembly/rigid_motion.hpp"
#include "kalfem/model/finite_element_model.hpp"
#include "kalfem/model/linear_model.hpp"

namespace kalfem {

struct AssemblyOptions {
  /// Parameters that shall be there, by name. Those that are factors of a part of a beam region's stiffness, such as
  /// "tubes.bending_y" (see beam_factors()), divide that region's stiffness into a term for each of its parts; offsets
  /// of point masses, such as "engine.offset_x" (see mass_offsets()), divide the mass matrix of the latter; factors of
  /// parts of the model (see part_factors()) have terms of their own; all other names have no effect. Of regions that
  /// none is named of, the stiffness stays one term with others of its material: a model of hundreds of beam regions
  /// would else be thousands of matrices.
  std::vector<std::string> parameters = {};
  /// Degrees of freedom that shall be free although links or constraints let them follow others, see eliminate().
  std::vector<NodalDof> independent = {};
  /// Leaves free what the model's supports hold; its shells are those of the supported model, see ShellEdges.
  bool release_supports = false;
  /// One term each for K and M, at the present values of the parameters, where none of them will change.
  bool at_present_values = false;
};

/// Factors that the stiffness of the model's beam regions can be divided by, all 1: "<region>.axial", ".bending_y",
/// ".bending_z" and ".torsion"; ".axial", ".bending" and ".torsion" where a product of inertia couples the planes;
/// ".stiffness" of the whole where an end has hinges. Beams are described at beam().
std::map<std::string, double> beam_factors(const FiniteElementModel& model);

/// Where the point masses sit beside their nodes [m]: "<mass>.offset_x", ".offset_y", ".offset_z". They act where the
/// node turns.
std::map<std::string, double> mass_offsets(const FiniteElementModel& model);

/// The factors of parts of the model: "<name>.factor". One that no parameter asks for multiplies its part at its value.
std::map<std::string, double> part_factors(const FiniteElementModel& model);

/// A finite-element model as matrices: K = sum of stiffness terms and M = sum of mass terms over the free degrees of
/// freedom, with the map back to the nodes. No two terms have the same powers. Immutable.
struct AssembledModel {
  std::map<std::string, double> parameters;  ///< present values, SI: "<material>.youngs_modulus", "<material>.density",
                                             ///< "<region>.thickness", "<mass>.mass", "<spring>.stiffness" and
                                             ///< the factors of beam regions and the offsets of point masses
                                             ///< that the options ask for
  std::vector<AffineTerm> stiffness;
  std::vector<AffineTerm> mass;
  SparseMatrix damping;                           ///< of dashpots [N s/m], n x n
  std::vector<AffineTerm> factored_damping = {};  ///< of matrices with a factor, beside `damping`
  std::vector<GroundCoupling> grounds;            ///< of springs to grounds, at the present values of the parameters
  std::vector<RigidMass> rigid_mass;              ///< of the whole structure, also where it is held
  std::vector<NodalDof> dofs;                     ///< free degrees of freedom, by node and then direction
  SparseMatrix expansion;  ///< 6 nodes x n: displacement of every node's degree of freedom from the free ones

  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(dofs.size()); }
  /// C = damping + sum of its terms, without Rayleigh damping, at these values of the parameters.
  [[nodiscard]] SparseMatrix viscous_damping(const std::map<std::string, double>& values) const;
  /// Position of a nodal degree of freedom among the free ones, -1 where it is fixed, tied or touched by nothing.
  [[nodiscard]] Eigen::Index find(const NodalDof& dof) const;
};

/// Assembles a model: element matrices by region, point masses, springs, then fixed, tied and constrained degrees of
/// freedom eliminated, z_all = T z, K = T^T K_all T, M alike. Only degrees of freedom that an element, spring or mass
/// touches, itself or through a link or constraint, are numbered.
/// Degrees of freedom without mass stay: M may be singular where K is not.
/// Throws InvalidInput with everything that validate() finds, with the elements whose shape cannot be integrated, and
/// for a factor whose name a spring has already.
AssembledModel assemble(const FiniteElementModel& model, const AssemblyOptions& options = {});

}  // namespace kalfem
