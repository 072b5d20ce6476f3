// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/base/progress.hpp"
#include "kalfem/system/locally_nonlinear_system.hpp"
#include "kalfem/system/sensors/output_map.hpp"
#include "kalfem/system/signal.hpp"

namespace kalfem {

/// Motion of boundary degrees of freedom, and behind them of the points outside that act on the substructure, one
/// column a sample.
struct BoundaryMotion {
  Eigen::MatrixXd displacement;  ///< (n_b + k) x samples [m]
  Eigen::MatrixXd velocity;      ///< (n_b + k) x samples [m/s]
  Eigen::MatrixXd acceleration;  ///< (n_b + k) x samples [m/s^2]
};

/// An input that acts on the substructure itself beside its boundary, over all its degrees of freedom.
struct AppliedInput {
  Input input;
  SignalPtr signal;
};

/// What the prediction starts from: displacement and velocity of all degrees of freedom at the first sample, n. Empty:
/// those that the boundary's motion gives statically.
struct PredictionStart {
  double time = 0.0;  ///< of the first sample [s]
  Eigen::VectorXd displacement, velocity;
};

struct PredictionOptions {
  double sample_rate = 1000.0;        ///< of the boundary motion [Hz]
  Eigen::Index exact_up_to = 400;     ///< interior degrees of freedom that are stepped exactly; more: by Newmark
  Eigen::Index newmark_substeps = 2;  ///< steps per sample then
  Progress progress = {};
};

/// Motion of some points, points x samples each.
struct PredictedMotion {
  Eigen::MatrixXd displacement, velocity, acceleration;
};

/// A linear substructure driven by the motion of its boundary b. With the static boundary modes Psi = -K_ii^-1 K_ib and
/// coordinates relative to them, z_i = Psi z_b + q,
///     M_ii q'' + C_ii q' + K_ii q = -(M_ii Psi + M_ib) z_b'' - (C_ii Psi + C_ib) z_b' - C_io z_o' + F_i,
/// so that the accelerations z_i'' = Psi z_b'' + q'' need no integral of z_b'' and do not drift. Boundary motion is
/// straight between samples. Nothing dense of the substructure's size squared is formed where it is large.
class BaseDrivenSubstructure {
public:
  /// `boundary`: indices into the model's degrees of freedom. `cross_damping`: C_o, by which the velocities of k points
  /// outside act on the model through the damping of the whole structure's modes, n x k; empty where nothing does.
  /// Throws InvalidInput where there is no interior, or where the interior still moves freely with the boundary held
  /// (naming a degree of freedom that does).
  BaseDrivenSubstructure(const LinearModel& model, std::vector<Eigen::Index> boundary,
                         const Eigen::MatrixXd& cross_damping = {});

  /// `points`: rows over all degrees of freedom, points x n.
  [[nodiscard]] PredictedMotion predict(const SparseRows& points, const BoundaryMotion& boundary,
                                        const std::vector<AppliedInput>& applied, const PredictionStart& start,
                                        const PredictionOptions& options) const;

  [[nodiscard]] const std::vector<Eigen::Index>& boundary() const { return boundary_; }
  [[nodiscard]] const std::vector<Eigen::Index>& interior() const { return interior_; }

private:
  [[nodiscard]] OutputMap outputs(const SparseRows& points, Eigen::Index inputs) const;

  std::vector<Eigen::Index> boundary_, interior_;
  Eigen::MatrixXd shapes_;         ///< [Psi; 1] over all degrees of freedom, n x n_b
  LocallyNonlinearSystem driven_;  ///< in q; one input a boundary degree of freedom and a point outside
};

}  // namespace kalfem
