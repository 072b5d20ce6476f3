// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "kalfem/formats/tables/frf_table.hpp"

namespace kalfem {

/// Frequency responses of one input, from a table of text as read_frf_table() reads it, or from another measured file
/// that holds some, such as a universal file, as select_frequency_responses() chooses them. `outputs` are their names;
/// the other options are those of tables. Values are in the file's units. Throws InvalidInput as both do.
FrequencyResponse read_frequency_responses(const std::filesystem::path& file, const FrfTableOptions& options = {});

}  // namespace kalfem
