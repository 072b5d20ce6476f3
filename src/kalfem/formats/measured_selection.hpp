// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kalfem/formats/record_file.hpp"
#include "kalfem/records/frequency_response.hpp"
#include "kalfem/records/measured_file.hpp"

namespace kalfem {

/// A degree of freedom of a test: "12:+Z", "12+z", "12Z", "12:-RX"; "-12Z" is 12 against Z. Nothing where the text
/// names none.
std::optional<MeasuredPlace> parse_freedom(std::string_view text);

/// The wanted channels of a file as a record, in that order and in SI. Each is asked for by
///   - its name, with or without its unit ("a3", "a3 [g]"), or another name that the file gives it;
///   - its node and direction: the motion along that direction. A channel that looks against it is turned.
/// Of several, the one with a unit of the wanted quantity is taken.
///
/// Channels may have sampling rates and uneven times of their own: the record stands on common_grid(), where a channel
/// is NaN between its samples. Without `missing` they must cover the same time up to their sampling intervals and have
/// no gaps; with it, they may begin and end at other samples and may lack some. Throws InvalidInput with every channel
/// that is not there or is ambiguous, every unit that does not fit, and for channels that no record can hold together.
Record select_record(const MeasuredFile& measured, const std::vector<WantedChannel>& wanted,
                     const RecordFileOptions& options, const std::filesystem::path& file);

/// Frequency responses of a file to one input, in the file's units: those of these names, or all. Each is asked for by
/// its name "12:+Z/3:+X", by its response alone where there is one reference, or by another name; a function that looks
/// against a direction is turned. Throws InvalidInput where one is missing or ambiguous, where lines differ, are not
/// ascending or values are no numbers.
FrequencyResponse select_frequency_responses(const MeasuredFile& measured, const std::vector<std::string>& names,
                                             const std::filesystem::path& file);

}  // namespace kalfem
