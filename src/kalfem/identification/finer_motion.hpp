// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/prediction/base_driven.hpp"

namespace kalfem {

/// Motion of a boundary at `factor` times its sampling rate, factor (samples - 1) + 1 columns: displacement, velocity
/// and acceleration each by the cubic spline through their samples.
///
/// A prediction takes boundary motion as straight between the samples that it is given. That weakens a component of the
/// frequency f by (pi f / rate)^2 / 3, as straight lines have the spectrum sinc^2(f / rate), and an updating would make
/// up for it by less damping. `factor` samples in the place of one weaken it by a part 1 / factor^2 of that.
BoundaryMotion finer_motion(const BoundaryMotion& motion, Eigen::Index factor);

}  // namespace kalfem
