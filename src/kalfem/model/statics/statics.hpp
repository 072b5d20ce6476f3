// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kalfem/model/statics/equilibrium.hpp"
#include "kalfem/model/statics/load_case.hpp"

namespace kalfem {

/// What a support, a ground, a joint to the ground or an imposed motion exerts on the structure.
struct Reaction {
  std::string name;  ///< of the support, the ground or the joint; "imposed motion"
  Resultant sum;     ///< about the middle of its nodes
};

/// Equilibrium of a model under one load case.
struct StaticSolution {
  std::string load_case;
  std::string preload;                   ///< the load case whose stresses are in the stiffness; empty: none
  Eigen::VectorXd displacements;         ///< and rotations of all nodes, 6 to a node [m, rad]
  std::vector<DofForce> support_forces;  ///< at held degrees of freedom and those of grounds [N, N m]
  std::vector<Reaction> reactions;
  Resultant applied;       ///< of all loads, about the middle of the model
  Resultant reaction_sum;  ///< of all supports, about the same
  double imbalance = 0.0;  ///< see relative_imbalance(): rounding, unless constraints or matrices carry load to nowhere
};

/// Linear statics K u = f of load cases, f of loads, pressure, gravity and rotation.
///
/// The model is assembled without its supports, which a load case may replace by its own. Degrees of freedom that these
/// hold, and those with an imposed motion, are prescribed (p), all others free (f):
///     K_ff u_f = f_f - K_fp u_p,   reactions r = K_pf u_f + K_pp u_p - f_p,
/// so a reaction is exact also where links end at a support. The solution is refined twice with its own residual. The
/// weight of a mass M in the field g is M R g with the rigid translations R. A load case with a preload is solved with
/// K + K_g, see preload_of(). Load cases that prescribe the same degrees of freedom under the same preload, by its
/// name, share one factor.
class StaticAnalysis {
public:
  /// Checks and factors everything. The model must outlive the analysis. Throws InvalidInput with everything that is
  /// wrong: a load or imposed motion that nothing takes, an imposed motion where a support holds the same degree of
  /// freedom, two imposed motions at one; a model that its supports leave free to move, naming the motion; a preload
  /// beyond the buckling load.
  StaticAnalysis(const FiniteElementModel& model, std::vector<LoadCase> cases);
  ~StaticAnalysis();

  [[nodiscard]] const FiniteElementModel& model() const;
  [[nodiscard]] const std::vector<LoadCase>& cases() const;
  /// One thread at a time.
  [[nodiscard]] StaticSolution solve(std::size_t load_case) const;
  /// Springs whose force the preload of a load case leaves out, see Preload.
  [[nodiscard]] std::vector<std::string> ignored_springs(std::size_t load_case) const;

private:
  class Solver;
  std::unique_ptr<const Solver> solver_;
};

/// Of a model and one load case. Throws as StaticAnalysis does.
StaticSolution solve_statics(const FiniteElementModel& model, const LoadCase& load_case);

}  // namespace kalfem
