// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <functional>

namespace kalfem::distributed {

/// Where the largest entry stands of the eigenvector of a symmetric A, n x n, that keeps it from being positive
/// definite: that of the eigenvalue nearest to zero, of the negative ones where A has `negative` ones. `inverse`
/// applies A^-1.
Eigen::Index weakest_entry(Eigen::Index size, bool negative,
                           const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& inverse);

}  // namespace kalfem::distributed
