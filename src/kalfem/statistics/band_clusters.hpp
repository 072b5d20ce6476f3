// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace kalfem {

/// Part of the scores at an estimate whose terms may be correlated among each other in any way.
struct ScoreCluster {
  Eigen::VectorXd score;        ///< sum of its gradients of the log-density, p
  Eigen::MatrixXd information;  ///< its part of the information, p x p
};

/// Covariance of estimates from the scatter of the scores between clusters.
struct ClusterCovariance {
  Eigen::MatrixXd covariance;  ///< without the prior's part, p x p
  Eigen::VectorXd expected;    ///< variances that a right model has in their place, p
  Eigen::VectorXd freedom;     ///< degrees of freedom of each variance; 0 where one cluster knows the parameter alone
};

/// The sandwich with the scatter between clusters and the adjustment CR2, which leaves it without bias where the model
/// is right,
///     V = A^+ (sum_b f_b r_b r_b^T f_b^T) A^+,   A = A_0 + sum_b A_b,   f_b = (I - A_b A^+)^(-1/2),
/// with the scores r_b = s_b - A_b A^+ (s_0 + sum s_b) at the minimum next to the estimate, where they sum to zero. The
/// factor f_b is taken in coordinates in which A = I, and directions that a cluster decides alone are left out: no
/// other one can contradict it. `freedom`: Satterthwaite's, (tr W)^2 / tr W^2 with the covariances W that a right model
/// gives to the clusters' contributions (Bell and McCaffrey 2002, Survey Methodology 28, 169-181).
/// `prior`: A_0 and its score s_0.
ClusterCovariance cluster_covariance(const std::vector<ScoreCluster>& clusters, const ScoreCluster& prior);

/// Normalised innovations of a run with known parameters, and their derivatives.
struct SensitiveInnovations {
  Eigen::MatrixXd value;                    ///< e, sensors x samples; not a number where missing
  std::vector<Eigen::MatrixXd> derivative;  ///< de / d theta_i, one per parameter
};

/// Scores by frequency and sensor. By Parseval's theorem the score of a parameter is a sum over frequencies,
///     s_i = - sum_k (de_k / d theta_i)^T e_k = - 1/N sum_f Re(conj(DE_i(f))^T E(f)),
/// so any bands divide it exactly. These are thirds of octaves down from half the sample rate.
class BandScores {
public:
  explicit BandScores(const SensitiveInnovations& innovations);

  /// Clusters of one octave, the first `shift` thirds narrower (0 to 2), of all sensors together or sensor by sensor.
  [[nodiscard]] std::vector<ScoreCluster> octaves(int shift, bool by_sensor) const;

private:
  void add_sensor(const SensitiveInnovations& innovations, Eigen::Index sensor);

  std::vector<std::vector<ScoreCluster>> thirds_;  ///< by sensor
};

/// Variances of estimates that include how much frequency bands contradict each other. A model that cannot have all
/// natural frequencies and shapes of a structure together is wrong in the same way throughout a record: scores along
/// time do not show it, but those of bands are large and cancel each other.
///
/// The clusters are octaves, and octaves sensor by sensor. The mean over octaves that begin at each third does not
/// depend on where one begins. Of both, the larger variance counts, if it exceeds that of a right model by more than
/// chance gives once in a hundred times; elsewhere it is zero. The prior's part is included.
Eigen::VectorXd band_variances(const SensitiveInnovations& innovations, const ScoreCluster& prior);

}  // namespace kalfem
