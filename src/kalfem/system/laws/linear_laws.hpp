#pragma once

#include "kalfem/system/connector_law.hpp"

namespace kalfem {

/// Spring and dashpot, f = k d + c v. Parameters k [N/m], c [N s/m].
ConnectorLawPtr linear_law();

/// Inerter, f = b a: a force in proportion to the relative acceleration. Parameter b [kg].
ConnectorLawPtr inerter_law();

/// Constant force, f = f0: gravity or a static preload in a strut, which may be unknown. Parameter f0 [N].
ConnectorLawPtr preload_law();

/// Values that the linear part of the system already holds at the connector's place.
struct LinearNominal {
  double stiffness = 0.0;  ///< k_nominal [N/m]
  double damping = 0.0;    ///< c_nominal [N s/m]
  double inertance = 0.0;  ///< b_nominal [kg]
};

/// Departure of a spring, dashpot or mass of the linear part from its nominal value,
///     f = (k - k_nominal) d + (c - c_nominal) v + (b - b_nominal) a,
/// so that it can be an unknown of an otherwise linear part. Parameters k [N/m], c [N s/m], b [kg]; each defaults to
/// its nominal value, which is no force. Throws InvalidInput where a nominal value is negative or not finite.
ConnectorLawPtr linear_change_law(const LinearNominal& nominal);

}  // namespace kalfem
