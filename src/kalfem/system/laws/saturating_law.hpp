#pragma once

#include "kalfem/system/connector_law.hpp"

namespace kalfem {

/// Suspension whose spring and damper saturate, [TGDC17] eq. (4):
///     f = k d + mu_k1 d / (mu_k2 + |d|) + c v + mu_c1 v / (mu_c2 + |v|).
/// Parameters k [N/m], mu_k1 [N], mu_k2 [m], c [N s/m], mu_c1 [N], mu_c2 [m/s]. Well below mu_k2 only the slope
/// k + mu_k1 / mu_k2 shows; well above it the second term is a constant mu_k1, like friction.
ConnectorLawPtr saturating_law();

}  // namespace kalfem
