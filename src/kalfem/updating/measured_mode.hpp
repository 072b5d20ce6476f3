// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

/// A natural frequency that was measured, with its shape where there is one.
struct MeasuredMode {
  double frequency = 0.0;              ///< [Hz]
  double deviation = 0.0;              ///< standard deviation of the frequency [Hz]
  std::optional<int> model_mode = {};  ///< number of its model mode at the start, 1: the lowest elastic one
  Eigen::VectorXd shape = {};  ///< real, at the measured points, in any scale and sign; not a number: the entry was not
                               ///< measured; empty: no shape
  double shape_deviation = 0.0;           ///< standard deviation of its entries, relative to the largest
  Eigen::VectorXd shape_deviations = {};  ///< of each entry, in the shape's unit, instead; empty: not known
  Eigen::MatrixXd shape_covariance = {};  ///< of all entries, instead of both; empty: not known
  std::optional<double> damping = {};     ///< ratio to critical, to compare with the model's
  double damping_deviation = 0.0;         ///< its standard deviation
  double complexity = 0.0;                ///< of the shape before it was turned to be real, see RealShape
};

/// "measured mode 3 (12.41 Hz)" of the one at position 2.
std::string named_mode(std::size_t position, double frequency);

/// The largest |entry| that was measured; 0 without one.
double largest_entry(const Eigen::VectorXd& shape);

/// Mistakes of measured modes at so many points, which go to `issues`: numbers that are not positive, shapes and errors
/// of another size, model modes that are named twice.
void check_modes(const std::vector<MeasuredMode>& measured, std::size_t points, IssueList& issues);

/// A measured mode beside the model's.
struct PairedMode {
  std::size_t measured = 0;            ///< position in the list of measured modes
  std::optional<int> model_mode = {};  ///< number among the elastic modes, from 1; nothing where no mode agrees
  double measured_frequency = 0.0;     ///< [Hz]
  double model_frequency = 0.0;        ///< [Hz]; of the nearest mode where it pairs with nothing
  double relative_error = 0.0;         ///< model / measured - 1
  double mac = 0.0;                    ///< with the measured shape; without one, with the shape at the start
  std::optional<double> measured_damping = {}, model_damping = {};  ///< ratios, where they are compared
  double complexity = 0.0;                                          ///< of the measured shape, as it was given
};

}  // namespace kalfem
