#pragma once

#include "kalfem/system/connector_law.hpp"

namespace kalfem {

/// Jenkins element: a spring in series with a dry-friction slider, with a spring and dashpot alongside,
///     f = k d + c v + q,     q = k_stick (d - slip),     |q| <= f_slip,     slip' = 0 while |q| < f_slip.
/// The state is the slip [m], advanced by the exact return map (the path within a step is taken as monotone); no rate
/// is needed, so it truly sticks. Parameters k_stick [N/m], f_slip [N], k [N/m], c [N s/m].
ConnectorLawPtr jenkins_law();

/// Elastoplastic spring with linear kinematic hardening,
///     f = alpha k d + q + c v,     q = (1 - alpha) k (d - slip),     |q| <= (1 - alpha) f_y:
/// stiffness k up to the force f_y, alpha k beyond it; the elastic range stays 2 f_y wide. State and integration as in
/// jenkins_law. Parameters k [N/m], f_y [N], alpha [-], c [N s/m].
ConnectorLawPtr bilinear_law();

/// Smooth hysteresis of Bouc and Wen [Wen76],
///     f = alpha k d + (1 - alpha) k z + c v,     z' = A v - beta |v| |z|^(n-1) z - gamma v |z|^n,
/// with the hysteretic deformation z [m] as its state; it saturates at z_u = (A / (beta + gamma))^(1/n).
/// Parameters k [N/m], alpha [-], A [-], beta [1/m^n], gamma [1/m^n], n >= 1 [-], c [N s/m].
///
/// z' is proportional to the rate, so z follows the deformation: dz/dd = A - |z|^n (beta sgn(z dd) + gamma). Over an
/// interval this is integrated along d(h) - d(0) by the two-stage, second-order, L-stable diagonally implicit
/// Runge-Kutta method [Ale77]: any increment is safe and a large one lands on z_u. A reversal inside the interval costs
/// an error of second order. Where beta + gamma < 0 makes z run away within one interval, the root is continued
/// linearly (finite).
///
/// The form m y'' + c y' + k_L y + w = u, w' = a y' - b (g |y'| |w|^(n-1) w + e y' |w|^n) of the published benchmark
/// [NS16] is k = k_L + a, alpha = k_L / k, A = 1, beta = b g a^(n-1), gamma = b e a^(n-1), with w = a z.
ConnectorLawPtr bouc_wen_law();

}  // namespace kalfem
