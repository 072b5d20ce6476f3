#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// Covariance of estimated parameters that holds where the model is not the truth.
struct RobustCovariance {
  Eigen::MatrixXd covariance;  ///< p x p
  double bandwidth = 1.0;      ///< of the scores' correlation in time [samples]
  bool batch_means = false;    ///< see LongRunCovariance
  Eigen::Index rank = 0;       ///< of the information, with every parameter in units of its own standard deviation
  double condition = 1.0;      ///< its largest over its smallest eigenvalue that counts
};

/// The sandwich estimator of a quasi-maximum-likelihood estimate,
///     V = A^+ (B + A_0) A^+,    A = A_0 + information of the data,   B = Cov(sum_k s_k),
/// with the scores s_k = d ln p(y_k | y_1 .. y_{k-1}) / d theta at the estimate, p x samples, and the information A_0
/// of the prior, whose part is no sum over samples and counts as stated. B allows for scores that are correlated in
/// time (long_run_covariance()); with a true model B = A - A_0 and V = A^-1. Directions that the information does not
/// see (eigenvalues below 1e-12 of the largest) have variance 0 in V; `rank` tells how many there are. White (1982),
/// Econometrica 50, theorem 3.2; White (1994), Estimation, Inference and Specification Analysis, section 8.3.
/// `information` and `prior_information`: A and A_0, symmetric p x p.
RobustCovariance robust_covariance(const Eigen::Ref<const Eigen::MatrixXd>& information,
                                   const Eigen::Ref<const Eigen::MatrixXd>& prior_information,
                                   const Eigen::Ref<const Eigen::MatrixXd>& scores);

/// The same with scores that are independent in time, B = sum_k s_k s_k^T, and no prior.
Eigen::MatrixXd white_robust_covariance(const Eigen::Ref<const Eigen::MatrixXd>& information,
                                        const Eigen::Ref<const Eigen::MatrixXd>& scores);

}  // namespace kalfem
