// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/api/update.hpp"
#include "kalfem/updating/frf_residual.hpp"

namespace kalfem {

/// Measured responses with their points. Throws InvalidInput where outputs are no motions of single points, or of
/// different quantities.
MeasuredFrf responses_at_points(const MeasuredResponses& given);
/// How they are compared, without smoothing.
FrfResidualOptions response_options(const MeasuredResponses& given);

}  // namespace kalfem
