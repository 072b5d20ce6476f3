// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// Sobol' indices of the outputs that the case names, over its priors: natural frequencies with every connector as
/// stiff as at rest, largest connector forces of the simulation under the known excitation, and the mean NIS of the
/// record. Throws InvalidInput where the excitation is not known, or no output can be computed.
std::vector<OutputSensitivity> output_sensitivity(const Study& study, const Record& record, int threads);

}  // namespace kalfem
