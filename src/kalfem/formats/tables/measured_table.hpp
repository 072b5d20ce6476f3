#pragma once

#include <filesystem>

#include "kalfem/records/measured_file.hpp"

namespace kalfem {

/// Reads everything that a table of text (.csv, .tsv, .txt, .dat) holds, also with lines before the table, a line of
/// units below the names, decimal commas, and several columns of times.
///
/// A line of the file's last third tells separator, decimal sign and which columns hold numbers; the table begins
/// with the first line of this kind. A column of times (t, time, ..., in its unit) serves the columns behind it up to
/// the next one; without any, a first column that increases evenly is taken as time. Cells that are empty, NaN, NA and
/// the like are missing samples. Columns of text are listed in `skipped`, a last line that was cut off in `notes`.
///
/// Throws InvalidInput where there is no table of numbers, and with line and column for other cells that are no
/// numbers.
MeasuredFile read_measured_table(const std::filesystem::path& path);

/// Whether at most one line of names stands above the table, and at most one column holds times: read_csv_record()
/// reads it, and names the line of everything that is wrong. Also true where no table is found.
bool is_plain_table(const std::filesystem::path& path);

/// The numeric datasets of an HDF5 file: one column a channel, with the attributes sample_rate (fs, fs_Hz) and unit. A
/// number of that name, or `dt`, in its group states the rate as well, and a vector `t` or `time` of their length the
/// times. A channel is also known by the last part of its path.
MeasuredFile read_measured_hdf5(const std::filesystem::path& path);

}  // namespace kalfem
