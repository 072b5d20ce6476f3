// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "kalfem/formats/tables/frf_table.hpp"
#include "kalfem/records/measured_file.hpp"
#include "kalfem/records/spectrum.hpp"

namespace kalfem {

/// Frequency responses of one input, from a table of text as read_frf_table() reads it, or from another measured file
/// that holds some, such as a universal file, as select_frequency_responses() chooses them. `outputs` are their names;
/// the other options are those of tables. Values are in the file's units. Throws InvalidInput as both do.
FrequencyResponse read_frequency_responses(const std::filesystem::path& file, const FrfTableOptions& options = {});

/// Frequency responses between several inputs and outputs of a file, such as a universal file of functions (dataset
/// 58).
struct FrfFileMatrix {
  FrfMatrix responses;
  std::vector<MeasuredPlace> places;      ///< of the outputs
  std::vector<std::string> remarks = {};  ///< how they were taken, a sentence each
};

/// All of the file that are no functions of other kinds, in its units: outputs and inputs by node and direction, those
/// that look against a direction turned. Where there are more inputs than outputs (a hammer that moves, sensors that
/// stay), the two are exchanged by reciprocity. Throws InvalidInput where there are none, one is missing or twice
/// there, lines differ, or values are no numbers or magnitudes alone.
FrfFileMatrix frf_matrix_of(const MeasuredFile& measured, const std::filesystem::path& file);

}  // namespace kalfem
