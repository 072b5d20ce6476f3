// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/model/linear_model.hpp"
#include "kalfem/model/statics/load_case.hpp"
#include "kalfem/model/statics/stresses.hpp"

namespace kalfem {

/// Stiffness of a preload at all degrees of freedom, 6 to a node: the second-order work of the stresses sigma that a
/// static solution left in the elements,
///     u^T K_g u = int sigma_ab u_c,a u_c,b dV                 of solids,
///                 int n_ab u_c,a u_c,b dA                     of shells, with the membrane forces n at their centre,
///                 int N (v'^2 + w'^2) dx                      of beams, with the mean axial force N,
/// a, b, c over the axes [ZTZ05]. Tension makes stiffer, compression softer; at the buckling load K + K_g is singular.
/// The change of the loads' direction with the motion (follower forces) is left out. `stresses`: of recover_stresses().
Eigen::SparseMatrix<double> geometric_stiffness(const FiniteElementModel& model,
                                                const std::vector<RegionStress>& stresses);

/// What a load case adds to the stiffness of the structure that carries it.
struct Preload {
  /// geometric_stiffness() of its stresses, bar_preload_stiffness() and, where it rotates, spin_softening().
  SparseMatrix stiffness;
  std::vector<std::string> ignored;  ///< names of springs and matrices, see springs_without_preload()
};
/// Throws as StaticAnalysis does.
Preload preload_of(const FiniteElementModel& model, const LoadCase& load_case);

/// The stiffness alone, as matrices between the degrees of freedom that it touches: for a model that keeps its preload.
NodalMatrices preload_matrices(const FiniteElementModel& model, const LoadCase& load_case);

/// The stiffness alone.
SparseMatrix preload_stiffness(const FiniteElementModel& model, const LoadCase& load_case);

/// Warns of springs whose force a preload leaves out, by their names, see preload_of().
std::string ignored_preload(const std::string& load_case, const std::vector<std::string>& springs);

}  // namespace kalfem
