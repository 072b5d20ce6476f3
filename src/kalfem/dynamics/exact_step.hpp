#pragma once

#include "kalfem/dynamics/first_order_form.hpp"

namespace kalfem {

/// One sample interval of a first-order form with the linear part exact and connector forces and inputs linear in time
/// over the interval:
///     x1 = transition x0 + begin_force f0 + end_force f1 + begin_input u0 + end_input u1.
/// Exact for f and u that are linear over the interval, at any h. The connectors' motion at the end follows as
///     k1 = k1_free + compliance f1,   k1_free = N (x1 without f1) + N_u u1.
struct ExactStep {
  ExactStep(const FirstOrderForm& form, double step);

  double step;                             ///< h [s]
  Eigen::MatrixXd transition;              ///< n_x x n_x
  Eigen::MatrixXd begin_force, end_force;  ///< n_x x m
  Eigen::MatrixXd begin_input, end_input;  ///< n_x x 3 n_u
  Eigen::MatrixXd compliance;              ///< connector motion per force at the end, 3m x m
  Eigen::MatrixXd instant_compliance;      ///< the same at an instant: only d'' feels f, 3m x m
};

}  // namespace kalfem
