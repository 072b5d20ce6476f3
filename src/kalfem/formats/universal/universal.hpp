#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "kalfem/records/measured_file.hpp"

namespace kalfem {

/// Whether a file that begins with these bytes is a universal file: a line "    -1" and a line with the number of a
/// dataset.
bool begins_universal(std::string_view head);

/// Reads a universal file (UFF, UNV): a sequence of datasets, each between two lines "    -1", the first of whose lines
/// holds its number. Datasets that are not read are listed in `skipped` by their number.
///
/// Throws InvalidInput with file and line for what is no universal file and for datasets that are damaged.
MeasuredFile read_universal(const std::filesystem::path& file);

}  // namespace kalfem
