// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <array>
#include <vector>

namespace kalfem {

/// What one campaign, or one of several nominally equal structures, says of a number.
struct PopulationMember {
  double estimate = 0.0;
  double deviation = 0.0;  ///< standard deviation of its error [unit of the estimate]
};

/// A number that is to be told: its median and the interval that holds it with the probability that was asked for.
struct PopulationEstimate {
  double median = 0.0;
  std::array<double, 2> interval{};
};

/// The members of a population, and what they say of the next one.
struct NormalPopulation {
  PopulationEstimate mean;                  ///< mu
  PopulationEstimate spread;                ///< tau, standard deviation of the true numbers
  PopulationEstimate next;                  ///< true number of a member that was not measured
  std::vector<PopulationEstimate> members;  ///< true numbers of those that were: each leans on the others
};

/// The members' true numbers theta_j vary by tau about mu, and each was estimated with an error of its own:
///     t_j = theta_j + e_j,   e_j ~ N(0, s_j^2),   theta_j ~ N(mu, tau^2).
/// mu is integrated out in closed form and tau numerically, with a flat prior of mu and the reference prior of tau,
///     p(tau) ~ tau sqrt(sum_j 1 / (s_j^2 + tau^2)^2)   [BLE17],
/// with which, for s_j << tau, the next member's interval is that of Student's t with n - 1 degrees of freedom,
/// t_mean +- t sd sqrt(1 + 1/n), and tau may be zero where the errors alone explain how far the estimates lie apart.
/// An error that all members share (a gain, a mass held wrong) is no part of s_j, and moves all of them alike.
///
/// Throws InvalidInput for fewer than two members, estimates that are not finite, deviations that are not positive,
/// and a probability outside (0, 1).
NormalPopulation population_of(const std::vector<PopulationMember>& members, double probability = 0.95);

/// A population whose mean follows covariates, such as temperatures.
struct PopulationTrend {
  PopulationEstimate mean;                 ///< at the members' mean covariates
  std::vector<PopulationEstimate> slopes;  ///< of the mean, per unit of each covariate
  PopulationEstimate spread;               ///< of the true numbers about the mean that follows
};

/// The same with theta_j ~ N(mu + b^T (x_j - mean of x), tau^2), x_j row j of `covariates`, members x covariates; the
/// prior of b is flat too. Throws InvalidInput as above, for other than one row a member, values that are not finite,
/// fewer than two members more than covariates, and covariates of which one follows from the others.
PopulationTrend population_trend(const std::vector<PopulationMember>& members, const Eigen::MatrixXd& covariates,
                                 double probability = 0.95);

}  // namespace kalfem
