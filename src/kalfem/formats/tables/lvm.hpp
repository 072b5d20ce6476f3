// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "kalfem/records/measured_file.hpp"

namespace kalfem {

/// Whether a file that begins with these bytes is a LabVIEW measurement file.
bool begins_lvm(std::string_view head);

/// Reads a LabVIEW measurement file (.lvm, text, version 2): a header of the file, then for each segment a header, the
/// channel names and one line a sample with an optional comment in the last column. Headers end with
/// ***End_of_Header***; Separator and Decimal_Separator are obeyed (the latter unless the samples contradict it, which
/// `notes` says), units are Y_Unit_Label or stand in the name, "a [g]". Channels whose X_Dimension is Frequency are
/// functions of frequency. A file without any header is read as a table.
///
/// The lines decide how many samples there are; where a header declares another number, `notes` says so. A last line
/// that was cut off is left out. Times are X0 + X_Value where there is a column of them (X_Columns One), or one a
/// channel (Multi); where they contradict Delta_X they count, and `notes` says so. Without them (X_Columns No) they
/// follow from X0 and Delta_X. Segments of the same channels that follow each other in time are joined; others are
/// channels of their own, "a (segment 2)". Cells that are empty, NaN, NA and the like are missing samples.
///
/// Throws InvalidInput with file and line for other cells that are no finite numbers, and where names, samples or times
/// are missing.
MeasuredFile read_lvm(const std::filesystem::path& path);

}  // namespace kalfem
