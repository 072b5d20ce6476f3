// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>

#include "kalfem/sampling/posterior.hpp"

namespace kalfem {

struct ProfileOptions {
  int points = 21;
  double reach = 4.0;  ///< of the values about the centre, in deviations of the parameter
  int threads = 1;     ///< results do not depend on it
};

/// ln p(data | parameters) along one parameter, the others at their most likely values.
struct Profile {
  Eigen::VectorXd values;              ///< ascending [unit]
  Eigen::VectorXd log_likelihood;      ///< less the largest one; -infinity where there is none
  std::optional<double> lower, upper;  ///< where it has fallen by 1.92, half the 95 % quantile of chi-squared: between
                                       ///< them lie 95 %; empty where it has not fallen so far within the values
};

/// l(theta_i) = max over the other parameters of ln p(data | theta), at values about `centre` (Raue et al. 2009,
/// Bioinformatics 25, 1923-1929). The others are sought within `reach` deviations times two, inside the prior's
/// support: no prior acts on them. Of one parameter alone it is the likelihood itself. Throws InvalidInput and
/// Interrupted.
Profile profile_likelihood(const Posterior& posterior, Eigen::Index parameter, const Eigen::VectorXd& centre,
                           const Eigen::VectorXd& deviation, const ProfileOptions& options = {});

}  // namespace kalfem
