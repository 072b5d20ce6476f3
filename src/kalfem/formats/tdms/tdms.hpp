// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "kalfem/records/measured_file.hpp"

namespace kalfem {

/// Whether a file that begins with these bytes is a TDMS file, or the index of one.
bool begins_tdms(std::string_view head);

/// Reads a TDMS file of LabVIEW and its kin [TDMS]: every layout of its segments, integers and floats of both byte
/// orders, DAQmx raw data.
///
/// Channels are named as in the file, with their group before them ("group/channel") where two have one name. Linear,
/// polynomial, table, added and subtracted scales (NI_Scale) are applied. Times are wf_start_offset + k wf_increment,
/// and wf_start_time against the earliest of the file; otherwise those of a channel of time stamps, or named like a
/// time, of the same group and length. Values along a frequency axis become functions.
///
/// A file that was cut off in a segment keeps what is whole of it. What is not read (texts, scales of temperature
/// sensors, damaged parts, samples that are missing) is listed in `skipped`. Throws InvalidInput where the file cannot
/// be read, is no TDMS file, or holds no channel at all.
MeasuredFile read_tdms(const std::filesystem::path& path);

/// The same from the bytes of a file; `source` names it in messages.
MeasuredFile parse_tdms(std::string_view bytes, const std::string& source);

}  // namespace kalfem
