// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// One line of a text file, without its end (\n, \r\n, or \r where the text has no \n); `number` is 1-based.
struct TextLine {
  std::string_view text;
  int number = 0;
};

/// Of UTF-8.
inline constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

/// Text in UTF-16 (with a byte-order mark, or every other byte zero) as UTF-8; nothing where it is not in UTF-16.
std::optional<std::string> utf16_as_utf8(std::string_view bytes);

/// Longest line that readers of text take [bytes]. A longer one is no line of a table or a deck, and what it holds
/// would ask for many times its size of memory.
inline constexpr std::size_t longest_line = std::size_t{4} << 20;

/// Throws InvalidInput with the place of the first line that is longer than `longest_line`. Looks at the end of every
/// few million bytes only. `source` names the file.
void require_short_lines(std::string_view text, const std::string& source);

/// Throws InvalidInput where a table has more columns than any record has channels (50,000): it may be one row of
/// samples. `line` is that of its names or its first row.
void require_columns(std::size_t columns, const std::string& source, int line);

/// Content of a file without a leading byte-order mark, UTF-16 as UTF-8. Throws InvalidInput as RegularFile does, and
/// where a line is longer than `longest_line`.
std::string read_text(const std::filesystem::path& path);

/// The same of a file that may hold bytes that are no text: its lines may have any length.
std::string read_content(const std::filesystem::path& path);

/// The lines of a text, one by one.
class LineWalk {
public:
  explicit LineWalk(std::string_view text)
      : rest_(text), line_end_(text.find('\n') == std::string_view::npos ? '\r' : '\n') {}
  /// The next line; false at the end of the text.
  bool next(TextLine& line);

private:
  std::string_view rest_;
  char line_end_;
  int number_ = 0;
};

std::vector<TextLine> split_lines(std::string_view text);

std::string_view trimmed(std::string_view text);

/// Whether a line is neither blank nor a comment, which begins with # or %.
bool has_content(std::string_view line);

/// The lines that have content.
std::vector<TextLine> content_lines(std::string_view text);

/// The strongest separator (; tab , space) in the second line, which is data whether there is a header or not.
char find_separator(const std::vector<TextLine>& lines);

/// A comma is the decimal sign where more cells of the first data lines are numbers with it than with a point. Cells
/// that hold neither, such as dates, do not count.
char find_decimal(const std::vector<TextLine>& lines, char separator);

/// The cells between separators, trimmed, quotation marks removed; a separator inside quotation marks belongs to its
/// cell. The separator ' ' stands for any run of blanks and tabs.
std::vector<std::string_view> split_cells(std::string_view line, char separator);
/// The same into a vector whose memory is used again.
void split_cells(std::string_view line, char separator, std::vector<std::string_view>& cells);

/// The number that fills the whole cell (NaN and infinities included, Fortran's exponents 1.5D+03 too), or nothing.
std::optional<double> parse_number(std::string_view cell, char decimal);

/// Whether programs write this where a value is missing: nothing at all, nan, NA, n/a, null, none and the like.
bool is_missing_value(std::string_view cell);

/// Collects the problems of a file, of which the first 20 are kept and the rest is counted.
class FileProblems {
public:
  explicit FileProblems(std::string file) : file_(std::move(file)) {}
  void add(int line, std::string what, std::string why = {}, std::string fix = {});
  /// Throws InvalidInput when there was any.
  void raise() const;
  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] const std::string& file() const { return file_; }

private:
  std::string file_;
  IssueList listed_;
  std::size_t count_ = 0;
};

/// Rows of finite numbers from lines of cells. Cells that are empty, no number or not finite become problems, unless
/// they are missing values where these are allowed.
class NumberRows {
public:
  /// `columns`: positions of the wanted cells; `names`: of all cells, for the messages.
  NumberRows(std::vector<std::size_t> columns, std::vector<std::string> names, char decimal);
  /// From this one on, the wanted columns may miss values: they become NaN.
  void allow_missing_from(std::size_t wanted) { missing_from_ = wanted; }
  /// Keeps the first wanted column apart, as take_first() gives it. Before rows are added.
  void separate_first() { first_apart_ = true; }
  /// Forgets the rows' lines once their problems are told. Before rows are added.
  void without_lines() { keeps_lines_ = false; }
  /// Makes room for so many rows.
  void reserve(std::size_t rows);
  void add(int line, const std::vector<std::string_view>& cells, FileProblems& problems);
  /// Wanted columns x rows, as they were added; without the first one where that is kept apart.
  [[nodiscard]] Eigen::Map<const Eigen::MatrixXd> by_column() const;
  /// The same, without a copy: the rows are gone.
  [[nodiscard]] Eigen::MatrixXd take_by_column();
  [[nodiscard]] Eigen::VectorXd take_first();
  [[nodiscard]] const std::vector<int>& lines() const { return lines_; }  ///< line of each row
  [[nodiscard]] std::size_t size() const { return size_; }                ///< rows

private:
  std::vector<std::size_t> columns_;
  std::vector<std::string> names_;
  char decimal_;
  std::optional<std::size_t> missing_from_;
  bool first_apart_ = false, keeps_lines_ = true;
  std::size_t size_ = 0;
  Eigen::VectorXd first_;    ///< with room for more rows
  Eigen::MatrixXd numbers_;  ///< columns x rows, with room for more
  std::vector<int> lines_;
};

/// What a column of equidistant time stamps says.
struct TimeAxis {
  double start = 0.0;        ///< [s]
  double sample_rate = 1.0;  ///< [Hz]
};

struct TimeAxisOptions {
  std::string column = "t";                ///< for the messages
  double jitter = 0.05;                    ///< allowed deviation of an interval, as a fraction of the interval
  std::optional<double> sample_rate = {};  ///< known rate [Hz], which the stamps must then confirm within 0.1 %
};

/// Start and sampling rate from time stamps [s], and a problem with its line for every gap, repeated or reversed stamp.
///
/// Stamps may be rounded: an interval may deviate from the typical one by jitter * interval + one unit of the stamps'
/// last decimal. The rate is (N - 1) / (t_N - t_1), taken to the roundest number that the stamps' resolution allows.
/// `lines`: the line of each stamp in the file.
TimeAxis time_axis(const Eigen::VectorXd& stamps, const std::vector<int>& lines, const TimeAxisOptions& options,
                   FileProblems& problems);

/// A column's title taken apart: "a [g]" and "a (g)" are the name a and the unit g.
///
/// Brackets at the end always hold a unit. Parentheses hold one where they are written like one ("(m/s^2)", "(kN)",
/// "(dB)"); otherwise they belong to the name, as in "Displacement (filtered)" or "Channel (2)".
Channel channel_of(std::string_view title);

/// Whether a column of this name (without unit) holds times: t, time, t_s, time_s, x_value, zeit.
bool is_time_name(std::string_view name);

/// Whether a column of this name may hold times, as its values must confirm: "Elapsed Time", "Time 2", "t1", "a_time",
/// "time_ms", "Temps", "t/s".
bool may_be_time_name(std::string_view name);

/// Whether all numbers are larger than the one before and their times are more than one. What is missing at the end
/// does not count.
bool increases(const Eigen::VectorXd& values);

/// The unit of time that a name ends in: "ms" of "time_ms", "s" of "t/s"; empty where there is none.
std::string unit_in_time_name(std::string_view name);

/// Column of the channel that `wanted` names with or without its unit, or -1.
Eigen::Index find_channel(const std::vector<Channel>& channels, std::string_view wanted);

}  // namespace kalfem
