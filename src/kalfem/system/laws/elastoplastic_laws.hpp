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

}  // namespace kalfem
