// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

#include "kalfem/records/record_spectra.hpp"

namespace kalfem {

/// E |dU_k|^2 of the error of an input's spectrum, at each line: what a force does between its samples. A blow of a few
/// samples has content beyond half the sampling rate f_s. It moves the structure as it is, and sampling folds it back
/// into U, in another phase at each blow. Beyond the last line a pulse without jumps falls at least as 1 / f^2, so
///     E |dU(f)|^2 = P (f_s / 2 / (f_s - f))^4,    P = mean |U|^2 of the uppermost tenth of the lines.
/// With a filter before the sampling, or a force that moves slowly, P is the noise of the force cell, and this is too.
Eigen::VectorXd input_error_power(const RecordSpectra& spectra);

}  // namespace kalfem
