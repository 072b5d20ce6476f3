#pragma once

#include <Eigen/Dense>
#include <vector>

namespace kalfem {

/// Strongly connected groups of the graph with an edge j -> i for every A_ij that is not zero: the irreducible diagonal
/// blocks of A. In topological order, a group behind all that act on it, so that A with its rows and columns in this
/// order is block lower triangular. A: n x n.
std::vector<std::vector<Eigen::Index>> strong_components(const Eigen::Ref<const Eigen::MatrixXd>& A);

}  // namespace kalfem
