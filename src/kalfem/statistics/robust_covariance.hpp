// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// Covariance of the sum of a stationary series, with what it was computed by.
struct LongRunCovariance {
  Eigen::MatrixXd of_sum;    ///< Cov(sum_k s_k), p x p
  double bandwidth = 1.0;    ///< first lag with weight zero [samples]; 1: successive samples count as independent
  bool batch_means = false;  ///< whether some variance is that of the batch means, because the kernel's was too small
};

/// Covariance of the sum over all samples of p series that may be correlated in time, `series` p x samples and about
/// zero mean,
///     Cov(sum_k s_k) = sum_{|l| < S} w(l / S) sum_k s_k s_{k+l}^T,
/// with the Parzen kernel w, which keeps it positive semi-definite. The bandwidth follows the series by Andrews'
/// plug-in for first-order autoregressions, S = 2.6614 (alpha N)^(1/5), alpha = sum 4 rho^2 sigma^4 / (1 - rho)^8 /
/// sum sigma^4 / (1 - rho)^4 (Andrews 1991, Econometrica 59, equations 6.2 and 6.4). A fixed dozen of lags would
/// miss half of the deviation on vibration records, which are sampled many times a period.
///
/// The first-order model misses slow parts under fast ones, such as those of scores that oscillate at twice a natural
/// frequency and drift over the memory of a lightly damped mode. So the plug-in is also applied to sums over 2, 4, 8
/// ... neighbours, wherever these are correlated beyond chance, and the longest bandwidth holds.
///
/// Scores at an estimate sum to zero: the score of a sample with the share p_k of the information has lost p_k times
/// the sum. Each variance is divided by 1 - sum_kl w((k - l) / S) p_k p_l, which makes up for it (for equal shares:
/// Kiefer and Vogelsang 2005, Econometric Theory 21, 1130-1164; without correlation: Bell and McCaffrey 2002, Survey
/// Methodology 28, 169-181). `information`: of each sample about each series, p x samples in any unit; equal if empty.
///
/// Each variance is checked against the scatter of the sums over 25 batches: where the batches' is larger by more than
/// chance gives once in a hundred times, it holds, and the correlations between series stay.
///
/// Long bandwidths are reached by adding up neighbouring samples first, which leaves the covariance of the sum as it
/// is. Zero for fewer than two samples.
LongRunCovariance long_run_covariance(const Eigen::Ref<const Eigen::MatrixXd>& series,
                                      const Eigen::Ref<const Eigen::MatrixXd>& information = Eigen::MatrixXd());

/// Covariance of estimated parameters that holds where the model is not the truth.
struct RobustCovariance {
  Eigen::MatrixXd covariance;  ///< p x p
  double bandwidth = 1.0;      ///< of the scores' correlation in time [samples]
  bool batch_means = false;    ///< see LongRunCovariance
  /// Of each deviation by contradictions between frequency bands, 1 where they widen nothing; empty: not looked at.
  Eigen::VectorXd widening_by_bands = {};
  Eigen::Index rank = 0;   ///< of the information, with every parameter in units of its own standard deviation
  double condition = 1.0;  ///< its largest over its smallest eigenvalue that counts
};

/// A^+ B A^+ with the information A and the covariance B of the scores' sum, p x p; rank and condition are those of A.
RobustCovariance sandwich(const Eigen::Ref<const Eigen::MatrixXd>& information,
                          const Eigen::Ref<const Eigen::MatrixXd>& of_sum);

/// The sandwich estimator of a quasi-maximum-likelihood estimate,
///     V = A^+ (B + A_0) A^+,    A = A_0 + information of the data,   B = Cov(sum_k s_k),
/// with the scores s_k = d ln p(y_k | y_1 .. y_{k-1}) / d theta at the estimate, p x samples, and the information A_0
/// of the prior, whose part is no sum over samples and counts as stated. B allows for scores that are correlated in
/// time (long_run_covariance()); with a true model B = A - A_0 and V = A^-1. Directions that the information does not
/// see (eigenvalues below 1e-12 of the largest) have variance 0 in V; `rank` tells how many there are. White (1982),
/// Econometrica 50, theorem 3.2; White (1994), Estimation, Inference and Specification Analysis, section 8.3.
/// B is found from A^+ s_k, by which each sample moved each parameter.
/// `information` and `prior_information`: A and A_0, symmetric p x p. `shares`: the part of every parameter's variance
/// that each sample accounts for, p x samples; equal if empty.
RobustCovariance robust_covariance(const Eigen::Ref<const Eigen::MatrixXd>& information,
                                   const Eigen::Ref<const Eigen::MatrixXd>& prior_information,
                                   const Eigen::Ref<const Eigen::MatrixXd>& scores,
                                   const Eigen::Ref<const Eigen::MatrixXd>& shares = Eigen::MatrixXd());

/// Replaces each variance by the other one where that is larger; correlations stay.
void widen(RobustCovariance& robust, const Eigen::Ref<const Eigen::VectorXd>& variances);

/// The same with scores that are independent in time, B = sum_k s_k s_k^T, and no prior.
Eigen::MatrixXd white_robust_covariance(const Eigen::Ref<const Eigen::MatrixXd>& information,
                                        const Eigen::Ref<const Eigen::MatrixXd>& scores);

}  // namespace kalfem
