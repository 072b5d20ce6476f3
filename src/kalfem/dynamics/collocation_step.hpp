// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/dynamics/first_order_form.hpp"

namespace kalfem {

/// One step of a first-order form by exponential collocation: the linear part exact, connector forces and inputs
/// polynomials in time through their values at the step's begin and its s nodes, the last of them its end,
///     x_j = transition_j x_0 + sum_l (force_jl f_l + input_jl u_l),   j = 1 ... s,   l = 0 ... s,
/// with the f_l that the laws give at the motions of the x_l: all nodes are solved together. Order 2 has the end as its
/// only node (forces are linear), order 4 middle and end (quadratic: the exponential form of Lobatto IIIA, whose nodes
/// integrate cubic forces exactly).
/// Sources: Hochbruck, Ostermann, Applied Numerical Mathematics 53 (2005) 323-339, and Acta Numerica 19 (2010) 209-286.
/// docs/theory/filter-step.md.
struct CollocationStep {
  struct Node {
    Eigen::MatrixXd transition;                 ///< n_x x n_x
    std::vector<Eigen::MatrixXd> force, input;  ///< s + 1 each, n_x x m and n_x x 3 n_u
  };

  /// `order`: 2 or 4, otherwise InvalidInput.
  CollocationStep(const FirstOrderForm& form, double step, int order);

  [[nodiscard]] Eigen::Index instants() const { return static_cast<Eigen::Index>(nodes.size()); }  ///< s

  double step;  ///< h [s]
  std::vector<Node> nodes;
  /// Motion of the connectors at all nodes per force at all nodes, 3 m s x m s, with the connectors of the first node
  /// before those of the second: rows [d; d'; d''] of all these.
  Eigen::MatrixXd compliance;
  Eigen::MatrixXd instant_compliance;  ///< at an instant only d'' feels f, 3m x m
  /// Order 4: times the second differences f_0 - 2 f_1 + f_2 and u_0 - 2 u_1 + u_2, what the state at the end has that
  /// it has not where forces and inputs are linear over either half, the embedded step of order 2. n_x x m and n_x x 3
  /// n_u.
  Eigen::MatrixXd curvature_force, curvature_input;
};

}  // namespace kalfem
