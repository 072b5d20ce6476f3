// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "kalfem/records/frequency_response.hpp"

namespace kalfem {

/// Writes H as a text table that read_frf_table() reads: "frequency [Hz]", and for each output "NAME_re [UNIT]" and
/// "NAME_im [UNIT]", to the last digit. Deviations and coherences are left out.
void write_frf_table(const std::filesystem::path& path, const FrequencyResponse& response);

}  // namespace kalfem
