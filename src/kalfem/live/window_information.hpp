// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

#include "kalfem/estimation/gaussian.hpp"

namespace kalfem {

/// What the samples of one window tell of p unknowns, without what was known before: their likelihood is that of a
/// normal estimate with this information, exp(-theta' Lambda theta / 2 + theta' eta).
struct WindowInformation {
  Eigen::MatrixXd information;  ///< Lambda, p x p, symmetric, positive semidefinite
  Eigen::VectorXd weighted;     ///< eta = Lambda times the window's own estimate, p

  static void transfer(auto& self, auto& archive) {
    archive(self.information);
    archive(self.weighted);
  }
};

/// The quotient of a filter's densities of the unknowns at the end and at the start of a window,
///     Lambda = P_1^-1 - (P_0 + Q)^-1,   eta = P_1^-1 m_1 - (P_0 + Q)^-1 m_0,
/// exact for a linear filter. `walk`: variances Q by which the unknowns may have moved in between, p. Directions in
/// which rounding leaves no information have none. Windows are then independent of each other, however much the filter
/// remembers.
WindowInformation window_information(const Gaussian& start, const Eigen::VectorXd& walk, const Gaussian& end);

}  // namespace kalfem
