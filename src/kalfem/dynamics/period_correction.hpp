#pragma once

#include "kalfem/dynamics/simulate.hpp"

namespace kalfem {

/// Lets a scheme of the generalised-alpha family (Newmark, HHT) with step h carry single oscillators without an error
/// in period and decay. A motion a_k = z^k of the scheme has
///     v = h ((1 - gamma) + gamma z) / (z - 1) a,      d = (h v + h^2 ((1/2 - beta) + beta z) a) / (z - 1),
/// and satisfies m A + c V + k D = 0 with A = (1 - alpha_m) z a + alpha_m a and V, D alike with alpha_f. An oscillator
/// with poles s_1, s_2 of 1, 2 zeta omega, omega^2 keeps them where that holds for z = exp(s_i h), two real equations
/// for m and c; k stays omega^2, and with it the static deflection.
/// What is left is an error of (omega h)^2 / 6 at most in the answer to a force, which does not grow with the number of
/// cycles. Changes M and C of the coordinates from `first` on, which nothing but connectors and loads may join to
/// others and whose mass is 1. Coordinates with omega h > 2, and those without stiffness, are left as they are.
void correct_periods(LocallyNonlinearSystem& system, Eigen::Index first, double step,
                     const AlphaParameters& scheme = {});

}  // namespace kalfem
