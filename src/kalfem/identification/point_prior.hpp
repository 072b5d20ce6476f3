// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kalfem {

/// Prior of a degree of freedom's displacement [m] and velocity [m/s].
struct PointPrior {
  double displacement = 0.0, velocity = 0.0, displacement_std = 0.0, velocity_std = 0.0;
};
struct ConnectorStatePrior {
  double value = 0.0, std = 0.0;
};

}  // namespace kalfem
