// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Sparse>
#include <vector>

#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

/// What fixed nodes, rigid links and multi-point constraints leave free: z_all = T z.
struct Elimination {
  std::vector<NodalDof> dofs;                              ///< free ones, by node and then direction, n
  Eigen::SparseMatrix<double, Eigen::RowMajor> transform;  ///< T, 6 nodes x n; the row of a fixed one is empty
};

/// Position of a nodal degree of freedom among all, 6 to a node.
inline Eigen::Index all_index(const NodalDof& dof) { return 6 * dof.node + dof.direction; }

/// Fixed, tied and constrained degrees of freedom that contradict each other: one that follows from two constraints, or
/// is fixed and follows from another, a ring of constraints that follow from one another, terms that determine nothing.
/// The nodes that they name must exist.
std::vector<Issue> constraint_issues(const FiniteElementModel& model);

/// Eliminates the dependent degrees of freedom. A slave of a rigid link moves by the master's displacement and its
/// small rotation, u_s = u_m + theta_m x (x_s - x_m), theta_s = theta_m; the first term of a multi-point constraint
/// follows from its others; what depends on dependent ones is substituted, so links may hang on one another in chains.
/// Free are the independent degrees of freedom that are touched, or that a touched one follows.
/// `touched`: by position among all, whether an element, spring or mass acts there.
///
/// `independent`: degrees of freedom that shall be free although a link or constraint lets them follow others: the
/// follower of a rigid link, the reference of a weighted one. Each takes the place of a free one that it follows: from
///     d = sum_j c_j z_j  comes  z_p = (d - sum_(j != p) c_j z_j) / c_p,
/// with p of the largest |c_p|, of rotations by the size of the model, and z_p is replaced wherever it stands. One that
/// follows only from other wanted ones and from what is held stays dependent: it is determined by these.
///
/// Throws InvalidInput with everything that constraint_issues() finds.
Elimination eliminate(const FiniteElementModel& model, const std::vector<bool>& touched,
                      const std::vector<NodalDof>& independent = {});

}  // namespace kalfem
