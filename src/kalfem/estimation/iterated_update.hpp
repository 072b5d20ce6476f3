// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/estimation/unscented_transform.hpp"

namespace kalfem {

/// Mean and standard deviation of the nonlinear arguments of a measurement, from one pass of an iterated update to the
/// next.
class ArgumentMoves {
public:
  void restart() { any_ = false; }
  /// Takes those of a pass. Whether they have stopped moving since the one before: for every argument
  ///     |m_i - m_i'| <= 1e-4 sigma_i  and  |sigma_i - sigma_i'| <= 1e-4 sigma_i.
  bool settle(const Eigen::VectorXd& mean, const Eigen::VectorXd& deviation);

private:
  bool any_ = false;
  Eigen::VectorXd mean_, deviation_;
};

/// Iterated posterior linearisation of a measurement y, for a filter that has a square root S of the prior covariance
/// [GSMS15]: regress the measurement, y ~ A x + b + e with e ~ N(0, Omega), over sigma points of the posterior that the
/// pass before gave, and condition the prior on that affine model,
///     v = y - A m - b,   C = A P A^T + Omega + R,   K = P A^T C^-1,
/// until ArgumentMoves has settled. A pass that fails leaves the one before. Everything is in the coordinates u of the
/// prior, x = m + S u, where with D = A S and C = L L^T the posterior is
///     u = W L^-1 v,   T T^T = I - W W^T,   W = D^T L^-T,
/// so that a state that is known exactly needs no care. One thread.
class IteratedUpdate {
public:
  /// The prior m, S (lower triangular) and what was measured.
  struct Measurement {
    PartiallyLinearMap& map;
    const Eigen::VectorXd& mean;
    const Eigen::MatrixXd& factor;
    const std::vector<Eigen::Index>& channels;
    const Eigen::VectorXd& y;      ///< of these channels
    const Eigen::MatrixXd& noise;  ///< R of these
  };

  /// `transform`: of the map over the prior; afterwards that of the last pass, at most the given one.
  void refine(const Measurement& measurement, int most, UnscentedTransform& transform);

private:
  bool condition(const Measurement& measurement, UnscentedTransform& transform);
  bool settled(const Measurement& measurement);

  UnscentedTransform before_;
  Eigen::MatrixXd all_channels_, covariance_, root_, weights_;  ///< P_yy, C, L, W
  Eigen::MatrixXd left_, contraction_;                          ///< T T^T, T
  Eigen::VectorXd value_, shift_;                               ///< L^-1 v, u
  Eigen::MatrixXd spread_, spread_there_;                       ///< N S, N S T
  Eigen::VectorXd argument_mean_;
  ArgumentMoves moves_;
};

}  // namespace kalfem
