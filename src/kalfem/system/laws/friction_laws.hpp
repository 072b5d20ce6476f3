#pragma once

#include "kalfem/system/connector_law.hpp"

namespace kalfem {

/// Regularised Coulomb friction with a spring and dashpot alongside,
///     f = k d + c v + f_c tanh(v / v_ref).
/// The hyperbolic tangent is smooth everywhere and reaches sliding friction to 1e-4 at 5 v_ref; the algebraic form
/// v / (v_ref + |v|), which nears it only as 1/v, is the saturating law's. Below v_ref it creeps instead of sticking:
/// where sticking matters use jenkins. Parameters f_c [N], v_ref [m/s], k [N/m], c [N s/m].
ConnectorLawPtr coulomb_law();

/// Friction that falls from static to sliding with the rate (Stribeck), regularised as in coulomb_law,
///     f = k d + c v + (f_c + (f_s - f_c) exp(-(v / v_s)^2)) tanh(v / v_ref).
/// The static force shows where v_ref is well below v_s. Parameters f_c [N], f_s [N], v_s [m/s], v_ref [m/s], k [N/m],
/// c [N s/m].
ConnectorLawPtr stribeck_law();

}  // namespace kalfem
