// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/information/identifiability.hpp"

namespace kalfem {

/// Which parameters to give one factor, so that the data determine what is left.
struct ParameterGrouping {
  std::vector<std::vector<Eigen::Index>> groups;  ///< in the order of their first parameters; one alone stays as it is
  std::vector<Eigen::Index> hold;                 ///< that data say too little of, and no other acts alike
};

/// Proposes groups from an information matrix [1/(unit_i unit_j)]. With c_i the column of the residual's Jacobian per
/// relative change of group i, two groups act alike where cos(c_i, c_j) is near 1. While a combination of the groups is
/// undetermined by the data alone (see identifiability(), each group without a prior), those two of its members that
/// act most alike are joined, so that they change by one factor; a member that acts like no other is held.
/// Throws InvalidInput as identifiability() does.
ParameterGrouping propose_groups(const Eigen::MatrixXd& information, const std::vector<InformedParameter>& parameters,
                                 const IdentifiabilityOptions& options = {});

}  // namespace kalfem
