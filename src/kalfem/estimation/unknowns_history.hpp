// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/statistics/band_clusters.hpp"
#include "kalfem/statistics/robust_covariance.hpp"

namespace kalfem {

/// How the estimates of the constant unknowns, and what the filter knows of them, went along a run over a record.
struct UnknownsHistory {
  std::vector<Eigen::Index> unknowns;  ///< places among all unknowns of those that stay constant (no random walk), c
  Eigen::Index stride = 1;             ///< samples from one point to the next
  Eigen::MatrixXd mean;                ///< of the prior and then of every point, in the filter's state, c x points
  Eigen::MatrixXd covariance;          ///< the same, beside each other, c x (c points)

  // Of every sample, unless the record is too long for it.
  Eigen::MatrixXd slope;      ///< derivatives D of the predicted measurements by the constants, c x (l samples)
  Eigen::MatrixXd at_prior;   ///< innovation of a filter that knows them to be the prior's mean, l x samples
  Eigen::MatrixXd deviation;  ///< of the innovation of a filter that knows them, l x samples

  [[nodiscard]] bool empty() const { return unknowns.empty() || points() < 2; }
  [[nodiscard]] Eigen::Index points() const { return mean.cols(); }
  [[nodiscard]] Eigen::Index last() const { return points() - 1; }
  [[nodiscard]] auto covariance_at(Eigen::Index point) const {
    return covariance.middleCols(point * mean.rows(), mean.rows());
  }
  [[nodiscard]] auto covariance_at(Eigen::Index point) {
    return covariance.middleCols(point * mean.rows(), mean.rows());
  }
  [[nodiscard]] Eigen::Index samples_with_slopes() const {
    return at_prior.size() > 0 ? slope.cols() / at_prior.rows() : 0;
  }
  [[nodiscard]] auto slope_at(Eigen::Index sample) const {
    return slope.middleCols(sample * at_prior.rows(), at_prior.rows());
  }
  [[nodiscard]] auto slope_at(Eigen::Index sample) {
    return slope.middleCols(sample * at_prior.rows(), at_prior.rows());
  }
};

/// What each point of a history tells of the constant unknowns.
struct Scores {
  Eigen::MatrixXd value;  ///< gradient of its log-density at the last estimate, c x points
  Eigen::MatrixXd share;  ///< of the last variance of each unknown, about 0 to 1, c x points
};

/// Scores of the constant unknowns at their last estimate.
///
/// With the estimate and the covariance P_k after sample k, a filter of joint state and parameters weighs what it saw
/// so far as u_k = P_k^-1 (theta_k - theta_N): the gradient, at the last estimate theta_N, of the log-density of the
/// parameters given the samples until k. So the score of sample k is
///     s_k = u_k - u_{k-1}.
/// This is exact where the parameters enter linearly: then the estimate of a constant beside states is recursive least
/// squares on the innovations of the filter that knows it (Friedland 1969, IEEE Trans. Automatic Control 14, 359-367).
/// No further run over the record is needed. Its share of the variance of unknown i, by the information P_k^-1 that it
/// added, is (P_N (P_k^-1 - P_{k-1}^-1) P_N)_ii / (P_N)_ii.
Scores scores_of(const UnknownsHistory& history);

/// Innovations of the filter that knows the constants to be their last estimates, over their deviations, and their
/// derivatives by the constants, from the run that estimates them. With what stands before sample k,
///     D = P_theta^-1 P_theta,y,    e(theta) = e_k - D^T (theta - theta_{k-1}),    S = S_k - D^T P_theta D,
/// which is exact where the parameters enter linearly (Friedland 1969). Samples before `first` do not count. Empty
/// where the history does not hold it.
SensitiveInnovations sensitive_innovations(const UnknownsHistory& history, Eigen::Index first);

/// What the prior tells of them: its information and score at the last estimate, P_0^-1 (theta_0 - theta_N).
ScoreCluster prior_score(const UnknownsHistory& history);

/// Covariance of the constant unknowns that allows for innovations that are correlated in time, in the filter's state:
/// the sandwich of the information P_N^-1, the prior's P_0^-1 and these scores.
RobustCovariance robust_covariance(const UnknownsHistory& history);

}  // namespace kalfem
