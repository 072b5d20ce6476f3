#pragma once

#include <filesystem>

#include "kalfem/records/record.hpp"

namespace kalfem {

/// Reads a LabVIEW measurement file (.lvm, text, version 2): two header blocks that end with ***End_of_Header***, the
/// channel names, then one line per sample with an optional comment in the last column.
///
/// A file with fewer lines of samples than its header declares was cut off: InvalidInput with both counts.
///
/// The sampling rate is 1 / Delta_X, the first time X0 (plus X_Value of the first line where there is one), units are
/// Y_Unit_Label; Separator and Decimal_Separator are obeyed. Values are left in the file's units. X_Columns may be One
/// or No. Throws InvalidInput with file and line for cells that are no finite numbers, missing samples, channels of
/// different Delta_X, X_Columns Multi, and files of more than one segment. With `missing`, cells that are empty, NaN,
/// NA and the like become NaN.
Record read_lvm(const std::filesystem::path& path, bool missing = false);

}  // namespace kalfem
