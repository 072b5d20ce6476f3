// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/api/structure.hpp"
#include "kalfem/api/update.hpp"
#include "kalfem/correlation/correlate.hpp"
#include "kalfem/correlation/response_agreement.hpp"

namespace kalfem {

/// Measured modes beside those of the substructure, sensor by sensor: pairs, MAC, COMAC, and mistakes of the set-up
/// with the sensors that they are of. What is stated of errors plays no part. It is what `correlate` of a case gives;
/// Structure::at() gives the structure after an updating. `above` of the modes counts, not that of the options.
/// Throws InvalidInput with everything of the modes that does not fit.
Correlation correlate(const Structure& structure, const MeasuredModes& modes, CorrelationOptions options = {});

/// Measured frequency responses beside those of the substructure, output by output: FRAC, size and phase. What is
/// stated of errors plays no part. Throws InvalidInput with everything of the responses that does not fit.
std::vector<ResponseAgreement> correlate(const Structure& structure, const MeasuredResponses& responses);

}  // namespace kalfem
