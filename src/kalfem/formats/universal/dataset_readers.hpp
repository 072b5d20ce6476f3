// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/formats/universal/universal_source.hpp"
#include "kalfem/formats/universal/universal_units.hpp"
#include "kalfem/records/measured_file.hpp"

namespace kalfem {

/// A universal file while it is read: its lines, the units that hold from dataset 164 on, and what was found.
struct UniversalReading {
  UniversalSource& source;
  MeasuredFile& file;
  UniversalUnits units = {};
  std::string identifier = {};   ///< the line with the number of the dataset
  int begin = 0;                 ///< number of that line
  bool local_axes = false;       ///< a node is measured in axes of its own
  std::string contradicts = {};  ///< a channel whose label of the unit contradicts dataset 164

  /// The next line of the dataset. Throws InvalidInput where the dataset or the file ends instead, naming `wanted`.
  const std::string& line(const std::string& wanted);
  /// The next line, or null where the dataset ends. Throws InvalidInput where the file ends.
  const std::string* next_line();
};

/// @name Readers of a dataset
/// Each reads the lines after the identifier, to the end mark or before it. They throw InvalidInput with the line of
/// what is damaged, and list in `skipped` what the type cannot hold.
///@{
void read_header(UniversalReading& reading);         ///< 151
void read_units(UniversalReading& reading);          ///< 164
void read_nodes_15(UniversalReading& reading);       ///< nodes on a line
void read_nodes_2411(UniversalReading& reading);     ///< nodes in double precision, also 781
void read_elements(UniversalReading& reading);       ///< 2412, also 780
void read_trace_line(UniversalReading& reading);     ///< 82
void read_data_at_nodes(UniversalReading& reading);  ///< 55
void read_analysis_data(UniversalReading& reading);  ///< 2414
void read_function(UniversalReading& reading);       ///< 58, ASCII or binary
///@}

/// Whether an identifier announces bytes ("    58b ..."), and how many of them follow its lines of text.
bool is_binary(const std::string& identifier);

}  // namespace kalfem
