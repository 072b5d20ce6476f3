// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "kalfem/formats/unpacked_size.hpp"
#include "kalfem/records/measured_file.hpp"

namespace kalfem {

/// A format of measured files with the function that reads it.
struct MeasuredFormat {
  std::string_view name;                  ///< "universal file"
  std::vector<std::string_view> endings;  ///< of its files, in small letters with the point
  bool (*begins)(std::string_view head);  ///< whether a file that begins with these bytes is one; null: only the ending
                                          ///< tells it
  MeasuredFile (*read)(const std::filesystem::path& file, const MeasuredFileOptions& options);
};

/// The formats that are recognised, in the order in which they are tried. A new reader is one entry of this list.
const std::vector<MeasuredFormat>& measured_formats();

/// The format of a file, by its first bytes, and otherwise by its ending. Null: a table of text (.csv, .txt, ...) or an
/// HDF5 file. Throws InvalidInput where the file cannot be read, and where it is of a kind that holds no measured data
/// (.xlsx, .png, .pdf, ...); the message lists the formats that are read.
const MeasuredFormat* measured_format(const std::filesystem::path& file);

/// Everything that the file holds, in the file's units; tables of text as well. Of compressed files (HDF5, MATLAB)
/// `options` say which channels are asked for: others that unpack to more than most_unpacked() are listed in `skipped`,
/// and HDF5's may have no values. Throws InvalidInput as the format's reader does, as measured_format() does, and where
/// memory does not suffice.
MeasuredFile read_measured_file(const std::filesystem::path& file, const MeasuredFileOptions& options = {});

}  // namespace kalfem
