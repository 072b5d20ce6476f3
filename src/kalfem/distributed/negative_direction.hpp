#pragma once

#include <Eigen/Dense>
#include <functional>

namespace kalfem::distributed {

/// Where the largest entry stands of a vector x with x^T A x < 0, for an indefinite A, n x n, of which `inverse`
/// applies A^-1: of the eigenvector whose eigenvalue is the negative one nearest to zero.
Eigen::Index largest_entry_of_negative_direction(Eigen::Index size,
                                                 const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& inverse);

}  // namespace kalfem::distributed
