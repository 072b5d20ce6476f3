// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "kalfem/records/measured_file.hpp"

namespace kalfem {

/// Reads everything that a table of text (.csv, .tsv, .txt, .dat) holds, also with lines before the table, a line of
/// units below the names, decimal commas, and several columns of times.
///
/// A line of the file's last third tells separator, decimal sign and which columns hold numbers, or dates and times of
/// day; the table begins with the first line of this kind. The encoding is UTF-8, UTF-16 or Windows-1252. Names stand
/// above the table or in the last comment before it.
///
/// A column of times (t, time, ..., in its unit; names such as "Time 2" or "a_time" where its numbers increase) serves
/// the columns behind it up to the next one, a single one all columns. Without one, dates and times of day count from
/// the first row on; then a sampling rate that a line above the table states; then a first column that increases
/// evenly. Cells that are empty, NaN, NA and the like are missing samples. Columns of text are listed in `skipped`, a
/// last line that was cut off in `notes`.
///
/// Throws InvalidInput where there is no table of numbers, and with line and column for other cells that are no
/// numbers.
MeasuredFile read_measured_table(const std::filesystem::path& path);

/// Whether at most one line of names stands above the table, and no column but the first holds times: read_csv_record()
/// reads it, and names the line of everything that is wrong. Also true where no table is found.
bool is_plain_table(const std::filesystem::path& path);

}  // namespace kalfem
