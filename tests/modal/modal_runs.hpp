// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/modal/identify_modes.hpp"
#include "modal/ambient_record.hpp"

namespace kalfem::test {

/// What the identifications of many records of one structure found.
struct ModalTally {
  Eigen::VectorXd found;           ///< records in which each mode was found
  Eigen::VectorXd frequency_bias;  ///< mean error of each mode in standard deviations
  Eigen::VectorXd damping_bias;
  int records = 0, missed = 0, spurious = 0;
  int intervals = 0, frequencies_held = 0, dampings_held = 0;  ///< 95 % intervals, and those that hold the truth
  int shape_intervals = 0, shapes_held = 0;                    ///< of real parts of entries
};

/// Records of seeds first ... first + count - 1. A mode is found where one of the identified modes has its frequency to
/// 2 % and its shape to a MAC of 0.7.
ModalTally tally_modes(const AmbientStructure& structure, double sample_rate, Eigen::Index samples, int first,
                       int count, const ModalOptions& options = {});

/// Whether a count of intervals that hold the truth lies in the 99 % binomial range of 95 %.
bool is_binomial(int held, int intervals);

}  // namespace kalfem::test
