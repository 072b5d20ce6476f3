// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/records/mode_set.hpp"
#include "kalfem/updating/measured_mode.hpp"

namespace kalfem {

/// Measured modes for a ModalResidual: shapes turned to be real, with the errors that are known of them, at the points
/// of the set; without points frequencies alone. Shapes without an entry that was measured and moves are left out.
///
/// A covariance from nu degrees of freedom over p points is known to no more than about p / nu in its correlations: it
/// is shrunk toward its diagonal by (p + 1) / nu, at most entirely.
/// Throws InvalidInput with every mode that is too complex, and every one without a frequency or a damping.
std::vector<MeasuredMode> modes_of_set(const ModeSet& set, const ModeSetOptions& options = {});

}  // namespace kalfem
