#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/time_series.hpp"

namespace kalfem {

/// How a text table is read; what is left out is found by looking at the file.
///
/// Accepted: comment lines that begin with # or %, blank lines, quoted names, both kinds of line ends, a byte-order
/// mark, one separator at the end of a line.
struct CsvOptions {
  std::optional<char> separator = {};     ///< one of  ; tab , space  (space: any run of blanks); found in that order
  std::optional<char> decimal = {};       ///< '.' or ','; a comma is recognised unless it separates
  std::optional<bool> header = {};        ///< whether the first line names the columns; found by its being no numbers
  std::vector<std::string> columns = {};  ///< the channels to read, by name; empty: all

  // Only for read_csv:
  std::string time_column =
      {};  ///< name, or position from "1"; empty: a first column called t, time, t_s, zeit, x_value ...
  std::optional<double> sample_rate = {};  ///< [Hz]; must agree with the time column where there is one
  double jitter = 0.05;                    ///< allowed deviation of a sampling interval, as a fraction of it
};

/// Named columns of numbers with the line of the file in which each row stands.
struct CsvTable {
  std::vector<Channel> columns;  ///< "name [unit]" is taken apart; without a header: column_1, column_2, ...
  Eigen::MatrixXd values;        ///< rows x columns
  std::vector<int> lines;
};

/// Throws InvalidInput with file, line and column for every cell that is empty, no number, or not finite, and every
/// line of another length; 20 of them are listed, the rest counted.
CsvTable read_csv_table(const std::filesystem::path& path, const CsvOptions& options = {});

/// An equally sampled record. The time column (in s, or as its [unit] says in ms or us) becomes start and sampling
/// rate; see time_axis.hpp for what is accepted as equidistant. Throws InvalidInput as above and for gaps, with their
/// lines.
TimeSeries read_csv(const std::filesystem::path& path, const CsvOptions& options = {});

/// Time in the first column "t [s]", then the channels as "name [unit]", with every digit needed to read the same
/// numbers back. Throws InvalidInput when the file cannot be written.
void write_csv(const std::filesystem::path& path, const TimeSeries& series, char separator = ',');

}  // namespace kalfem
