// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/records/record.hpp"

namespace kalfem {

/// How a text table is read; what is left out is found by looking at the file.
///
/// Accepted: comment lines that begin with # or %, blank lines, quoted names, both kinds of line ends, a byte-order
/// mark, one separator at the end of a line.
struct CsvOptions {
  std::optional<char> separator = {};     ///< one of  ; tab , space  (space: any run of blanks); found in that order
  std::optional<char> decimal = {};       ///< '.' or ','; a comma is recognised unless it separates
  std::optional<bool> header = {};        ///< whether the first line names the columns; found by its being no numbers
  std::vector<std::string> columns = {};  ///< the channels to read, by name with or without unit; empty: all
  std::optional<int> rows = {};           ///< only so many rows; those behind are not looked at
  /// Cells that are empty, nan, NA, n/a, null or none are missing samples: NaN. Times must be there.
  bool missing = false;

  // Only for read_csv:
  std::string time_column =
      {};  ///< name, or position from "1"; empty: a first column called t, time, t_s, zeit, x_value ...
  std::optional<double> sample_rate = {};     ///< [Hz]; must agree with the time column where there is one
  double jitter = 0.05;                       ///< allowed deviation of a sampling interval, as a fraction of it
  bool uneven = false;                        ///< stamps may be uneven and out of order, see CsvRecord::times
  std::vector<std::string>* notes = nullptr;  ///< where the reader says that it sorted the rows; null: nowhere
};

/// Named columns of numbers with the line of the file in which each row stands.
struct CsvTable {
  std::vector<Channel> columns;  ///< titles as channel_of() takes them apart, whole where two columns would be named
                                 ///< alike; without a header: column_1, column_2, ...
  Eigen::MatrixXd values;        ///< rows x columns
  std::vector<int> lines;
  int title_line = 0;  ///< where the titles stand; 0: there are none
};

/// Throws InvalidInput with file, line and column for every cell that is empty, no number, or not finite (unless it is
/// a missing sample and these are allowed), and every line of another length; 20 of them are listed, the rest counted.
CsvTable read_csv_table(const std::filesystem::path& path, const CsvOptions& options = {});

/// A record with the line of its titles; 0: there are none.
struct CsvRecord {
  Record record;
  int title_line = 0;
  Eigen::VectorXd times = {};  ///< of the samples [s], where they are uneven; rate and start of the record mean nothing
};

/// An equally sampled record, in the file's units. The time column (in s, or in its title's unit) becomes start and
/// sampling rate; see text_table.hpp for what is accepted as equidistant. Without times every row counts as a sample, a
/// blank line between the rows of a single column as well. Throws InvalidInput as above and for gaps, with their lines.
CsvRecord read_csv_record(const std::filesystem::path& path, const CsvOptions& options = {});
Record read_csv(const std::filesystem::path& path, const CsvOptions& options = {});

/// Time in the first column "t [s]", then the channels as "name [unit]", with every digit needed to read the same
/// numbers back. Throws as write_file_atomically() does.
void write_csv(const std::filesystem::path& path, const Record& record, char separator = ',');

}  // namespace kalfem
