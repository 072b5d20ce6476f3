// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cstdint>

#include "kalfem/records/record.hpp"

namespace kalfem::test {

/// Modes of a structure that white forces move: q'' + 2 zeta omega q' + omega^2 q = B f, y = Phi q'.
struct AmbientStructure {
  Eigen::VectorXd omega;  ///< [rad/s]
  Eigen::VectorXd zeta;
  Eigen::MatrixXd shapes;  ///< Phi, outputs x modes
  Eigen::MatrixXd inputs;  ///< B, modes x forces

  [[nodiscard]] Eigen::VectorXd frequencies() const;  ///< [Hz]
  /// Share of each mode in the variance of the outputs, each in units of its own, from the stationary variance of its
  /// velocity under white forces, (B B^T)_ii / (4 zeta omega).
  [[nodiscard]] Eigen::VectorXd participations() const;
};

/// Shear frame with equal storeys, fixed at its foot: omega_j = 2 sqrt(k/m) sin((2j - 1) pi / (4 n + 2)), white forces
/// of the same strength at each floor, velocities of all floors. The highest mode is at `highest` [Hz].
AmbientStructure shear_frame(int storeys, double highest, double zeta);

/// Simply supported plate: modes (m, n) to 3 x 3 with sides so alike that (m, n) and (n, m) lie close together, forces
/// at `forces` points, velocities on a grid of 4 x 4 points.
AmbientStructure near_square_plate(double lowest, double side_ratio, double zeta);

/// Two modes whose frequencies differ by a fraction `apart`, at three points.
AmbientStructure close_pair(double frequency, double apart, double zeta);

/// Velocities with white noise, `noise` times the root mean square of each channel. Each mode is stepped by its own
/// matrix exponential over `substeps` equal parts of a sample, over each of which the forces are constant and white.
Record ambient_record(const AmbientStructure& structure, double sample_rate, Eigen::Index samples, std::uint64_t seed,
                      double noise = 0.05, int substeps = 4);

}  // namespace kalfem::test
