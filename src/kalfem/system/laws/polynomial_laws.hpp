#pragma once

#include "kalfem/system/connector_law.hpp"

namespace kalfem {

/// Hardening or softening spring and damper, f = k d + k3 d^3 + c v + c3 v^3.
/// Parameters k [N/m], k3 [N/m^3], c [N s/m], c3 [N s^3/m^3]; k3 and c3 may be negative.
ConnectorLawPtr cubic_law();

/// Polynomial spring and damper of any degree,
///     f = sum_{i=1..N} k_i d^i + sum_{i=1..M} c_i v^i,     N = stiffness_degree, M = damping_degree.
/// Parameters k1 .. kN [N/m^i], c1 .. cM [N (s/m)^i], all 0 unless given. Even terms make the force differ between
/// tension and compression. Throws InvalidInput unless both degrees lie in [0, 30] and one of them is positive.
ConnectorLawPtr polynomial_law(int stiffness_degree, int damping_degree);

}  // namespace kalfem
