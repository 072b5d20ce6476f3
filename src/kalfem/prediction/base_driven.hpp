#pragma once

#include <vector>

#include "kalfem/model/linear_model.hpp"

namespace kalfem {

/// Motion of boundary degrees of freedom, one column a sample.
struct BoundaryMotion {
  Eigen::MatrixXd displacement;  ///< n_b x samples [m]
  Eigen::MatrixXd velocity;      ///< n_b x samples [m/s]
  Eigen::MatrixXd acceleration;  ///< n_b x samples [m/s^2]
};

/// Motion of all degrees of freedom of a substructure, n x samples each.
struct PredictedMotion {
  Eigen::MatrixXd displacement, velocity, acceleration;
};

/// A linear substructure driven by the motion of its boundary b. With the static boundary modes Psi = -K_ii^-1 K_ib and
/// coordinates relative to them, z_i = Psi z_b + q,
///     M_ii q'' + C_ii q' + K_ii q = -(M_ii Psi + M_ib) z_b'' - (C_ii Psi + C_ib) z_b' + F_i,
/// so that the accelerations z_i'' = Psi z_b'' + q'' need no integral of z_b'' and do not drift. Integrated exactly for
/// boundary motion linear over each sample interval.
class BaseDrivenSubstructure {
public:
  /// `boundary`: indices into the model's degrees of freedom. Throws InvalidInput where there is no interior, or where
  /// the interior still moves freely with the boundary held (naming a degree of freedom that does).
  BaseDrivenSubstructure(const LinearModel& model, std::vector<Eigen::Index> boundary);

  /// `applied`: forces on all degrees of freedom, n x samples (empty: none). `start` and `start_rate`: displacement and
  /// velocity of all degrees of freedom at the first sample, n.
  [[nodiscard]] PredictedMotion predict(const BoundaryMotion& boundary, const Eigen::MatrixXd& applied,
                                        const Eigen::VectorXd& start, const Eigen::VectorXd& start_rate,
                                        double sample_rate) const;

  [[nodiscard]] const std::vector<Eigen::Index>& boundary() const { return boundary_; }
  [[nodiscard]] const std::vector<Eigen::Index>& interior() const { return interior_; }

private:
  std::vector<Eigen::Index> boundary_, interior_;
  Eigen::MatrixXd static_modes_;  ///< Psi, n_i x n_b
  Eigen::MatrixXd dynamics_;      ///< of [q; q'], 2 n_i x 2 n_i
  Eigen::MatrixXd drive_;         ///< per [z_b''; z_b'; F_i], 2 n_i x (2 n_b + n_i)
};

}  // namespace kalfem
