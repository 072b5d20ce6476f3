// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <complex>
#include <vector>

#include "kalfem/modal/subspace.hpp"

namespace kalfem {

/// A vibrating mode of a state-space model, with its deviation by each block of the record.
struct StatePole {
  Eigen::Index order = 0;
  std::complex<double> value;  ///< eigenvalue mu of the continuous model [rad/s], Im mu > 0
  double frequency = 0.0;      ///< |mu| / (2 pi) [Hz]
  double damping = 0.0;        ///< -Re mu / |mu|
  Eigen::VectorXcd shape;      ///< one a channel, in units of the channels' root mean square; the largest is 1
  double participation = 0.0;  ///< share of the references' variance that it carries
  Eigen::MatrixXd deviations;  ///< of frequency and damping, to first order: 2 x blocks
  double frequency_std = 0.0, damping_std = 0.0;
  double degrees_of_freedom = 0.0;  ///< of the standard deviations
};

/// How a pole is taken from its model.
struct PoleOptions {
  double sample_rate = 1.0;       ///< [Hz]
  Eigen::Index block_length = 1;  ///< samples
  double largest_damping = 1.0;   ///< poles beyond are left out, and those that grow by more than a
                                  ///< thousandth a sample: steady vibrations lie on either side of no damping
};

/// Poles of the model of one order: with O = U_1, the first `order` left singular vectors,
///     A = O_up^+ O_down,   C = the first block row of O,   A phi = lambda phi,   mu = ln(lambda) sample_rate,
/// where O_up and O_down lack the last and the first block row [PDR99]. Deviations to first order by [RPDR08] and
/// [DM13]: of the singular vectors by those of H, of A by
///     dA = O_up^+ (dO_down - dO_up A) + (O_up^T O_up)^-1 dO_up^T (O_down - O_up A),
/// of lambda by chi^T dA phi with the left eigenvector chi, chi^T phi = 1. Only products with vectors are formed.
std::vector<StatePole> poles_of_order(const Subspace& subspace, Eigen::Index order, const PoleOptions& options);

/// Deviation of the pole's shape by each block, real parts above imaginary ones: 2 channels x blocks. The largest entry
/// stays 1.
Eigen::MatrixXd shape_deviations(const Subspace& subspace, const StatePole& pole, const PoleOptions& options);

/// Blocks over which the influence of a mode's response is correlated: 2.5 times its decay 1 / (2 zeta omega), at least
/// one and at most a tenth of all.
Eigen::Index memory_in_blocks(const StatePole& pole, const PoleOptions& options, Eigen::Index blocks);

}  // namespace kalfem
