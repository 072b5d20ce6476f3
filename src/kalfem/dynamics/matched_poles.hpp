#pragma once

#include "kalfem/system/locally_nonlinear_system.hpp"

namespace kalfem {

/// Lets average acceleration (Newmark with beta = 1/4, gamma = 1/2) of step h carry single oscillators without an error
/// in period and decay. Over a step it replaces s by (2/h) tanh(s h/2), so that an oscillator
///     m q'' + c q' + k q = f     with poles s_1, s_2 of 1, 2 zeta omega, omega^2
/// keeps its own poles where those of m, c, k are p_i = (2/h) tanh(s_i h/2):
///     m = omega^2 / (p_1 p_2),   c = -(p_1 + p_2) m,   k = omega^2.
/// What is left is an error of (omega h)^2 / 6 at most in the answer to a force, which does not grow with the number of
/// cycles. Changes M and C of the coordinates from `first` on, which nothing but connectors and loads may join to
/// others and whose mass is 1. Coordinates with omega h > 2, and those without stiffness, are left as they are.
void match_poles(LocallyNonlinearSystem& system, Eigen::Index first, double step);

}  // namespace kalfem
