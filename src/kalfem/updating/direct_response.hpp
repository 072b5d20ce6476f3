// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/base/progress.hpp"
#include "kalfem/updating/frf_set.hpp"

namespace kalfem {

/// FRFs by direct solution at each line, with nothing neglected:
///     H(s) = s^(q - p) S (K + s (C + C_m) + s^2 M)^-1 (f_0 + s f_1),   s = i 2 pi f,
/// with the loads and outputs of FrfEvaluation. One factorisation a line serves all sets.
/// `frequencies` [Hz], >= 0; `progress` shows "line 3 of 400". Returns lines x outputs, one matrix a set.
/// Throws InvalidInput with every unknown point or ground, and with the first line at which the equations are singular:
/// an undamped resonance.
std::vector<Eigen::MatrixXcd> direct_responses(const LinearModel& model, const std::vector<FrfSet>& sets,
                                               const Eigen::VectorXd& frequencies, const Progress& progress = {});

}  // namespace kalfem
