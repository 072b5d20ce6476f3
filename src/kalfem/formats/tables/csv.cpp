// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tables/csv.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/stated_times.hpp"
#include "kalfem/formats/tables/mapped_text.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// How this file is written: the options with what was found filled in.
struct Dialect {
  char separator = ',';
  char decimal = '.';
  bool header = true;
};

bool is_header(std::string_view line, const Dialect& dialect) {
  const auto cells = split_cells(line, dialect.separator);
  return std::ranges::any_of(
      cells, [&](std::string_view cell) { return !is_missing_value(cell) && !parse_number(cell, dialect.decimal); });
}

Dialect find_dialect(const std::vector<TextLine>& lines, const CsvOptions& options) {
  Dialect dialect;
  dialect.separator = options.separator.value_or(find_separator(lines));
  dialect.decimal = options.decimal.value_or(find_decimal(lines, dialect.separator));
  dialect.header = options.header.value_or(is_header(lines.front().text, dialect));
  return dialect;
}

void check(const CsvOptions& options) {
  constexpr std::string_view separators = ";\t, ";
  IssueList issues;
  if (options.separator && separators.find(*options.separator) == std::string_view::npos)
    issues.add({}, std::string("CSV separator is '") + *options.separator + "'",
               "it must be a semicolon, tab, comma or space");
  if (options.decimal && *options.decimal != '.' && *options.decimal != ',')
    issues.add({}, std::string("CSV decimal sign is '") + *options.decimal + "'", "it must be a point or a comma");
  if (options.separator && options.decimal && *options.separator == *options.decimal)
    issues.add({}, "CSV separator and decimal sign are both a comma", "they must differ");
  if (options.sample_rate && !(*options.sample_rate > 0.0 && std::isfinite(*options.sample_rate)))
    issues.add({}, "the sampling rate is " + std::to_string(*options.sample_rate) + " Hz",
               "it must be positive and finite");
  if (options.rows && *options.rows < 1)
    issues.add({}, std::to_string(*options.rows) + " rows of a table are requested", "it must be at least one");
  if (!(options.jitter >= 0.0 && options.jitter < 0.5))
    issues.add({}, "jitter is " + std::to_string(options.jitter), "it must be at least 0 and below 0.5 of an interval");
  issues.raise();
}

std::vector<std::string> names_of(const std::vector<Channel>& titles) {
  std::vector<std::string> names;
  for (const auto& title : titles) names.push_back(title.name);
  return names;
}

std::string in_words(const std::vector<std::string>& names) {
  std::string all;
  for (const auto& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

/// Whole titles where columns would otherwise be named alike: "x [mm]" and "x [m/s]".
void tell_apart(std::vector<Channel>& channels, const std::vector<std::string>& titles) {
  std::unordered_map<std::string, int> used;
  for (const auto& channel : channels) ++used[channel.name];
  for (std::size_t i = 0; i < channels.size(); ++i)
    if (used[channels[i].name] > 1) channels[i].name = titles[i];
}

std::vector<Channel> titles_of(const TextLine& first, const Dialect& dialect, FileProblems& problems) {
  auto cells = split_cells(first.text, dialect.separator);
  if (cells.size() > 1 && cells.back().empty()) cells.pop_back();
  require_columns(cells.size(), problems.file(), first.number);
  std::vector<Channel> channels;
  std::vector<std::string> titles;
  std::unordered_set<std::string> used;
  for (const auto cell : cells) {
    const bool named = dialect.header && !cell.empty();
    titles.push_back(named ? to_utf8(cell) : "column_" + std::to_string(titles.size() + 1));
    channels.push_back(named ? channel_of(titles.back()) : Channel{titles.back(), ""});
    if (!used.insert(titles.back()).second)
      problems.add(first.number, "two columns are named '" + titles.back() + "'", "names must be unique",
                   "rename one of them");
  }
  tell_apart(channels, titles);
  return channels;
}

/// Positions of the wanted columns; of all when none is named.
std::vector<std::size_t> positions_of(const std::vector<std::string>& wanted, const std::vector<Channel>& titles,
                                      int title_line, FileProblems& problems) {
  const auto names = names_of(titles);
  std::vector<std::size_t> positions;
  for (const auto& name : wanted) {
    const auto found = find_channel(titles, name);
    if (found < 0)
      problems.add(title_line, "there is no column '" + name + "'" + did_you_mean(name, names), "",
                   "the file has: " + in_words(names));
    else
      positions.push_back(static_cast<std::size_t>(found));
  }
  if (!wanted.empty()) return positions;
  positions.resize(names.size());
  std::iota(positions.begin(), positions.end(), std::size_t{0});
  return positions;
}

/// Name of the time column of a file with these columns, or "" when it has none.
std::string find_time_column(const std::vector<std::string>& names, const std::string& asked, FileProblems& problems) {
  if (asked.empty()) {
    return is_time_name(names.front()) ? names.front() : "";
  }
  if (std::ranges::find(names, asked) != names.end()) return asked;
  const auto position = parse_number(asked, '.');
  if (position && *position >= 1 && *position <= double(names.size()) && *position == std::floor(*position))
    return names[static_cast<std::size_t>(*position) - 1];
  problems.add(0, "there is no time column '" + asked + "'" + did_you_mean(asked, names), "",
               "give a column's name, or its position from 1 to " + std::to_string(names.size()));
  return "";
}

/// What else counts as a row than lines with content.
enum class BlankRows {
  none,   ///< a blank line says nothing
  count,  ///< a row without values: times stand by the rows' order alone
};

/// The columns that were asked for, with their titles.
struct Columns {
  std::vector<Channel> titles;
  NumberRows numbers;
};

// Reading goes in the order in which each step needs the one before: content lines, separator, decimal sign, whether
// the first line is a header, titles, then the wanted columns as numbers. Problems of one step are reported together
// before the next one begins.
/// A file opened, its dialect and titles known, its numbers not yet read. The rows are read one by one: a file may be
/// larger than the memory.
class CsvFile {
public:
  CsvFile(const std::filesystem::path& path, const CsvOptions& options)
      : problems(path.string()), options_(options), text_(path) {
    const auto first = first_lines();
    if (first.empty()) throw InvalidInput(Issue{{path.string(), 0}, "the file has no data", "", "check the path"});
    dialect_ = find_dialect(first, options);
    title_line_ = dialect_.header ? first.front().number : 0;
    titles = titles_of(first.front(), dialect_, problems);
    problems.raise();
    constexpr double margin = 1.02;
    const auto looked_at = static_cast<double>(first.back().text.data() - text_.view().data()) + 1.0;
    likely_rows_ = static_cast<std::size_t>(margin * static_cast<double>(first.size()) *
                                            static_cast<double>(text_.view().size()) / looked_at) +
                   first.size();
  }

  [[nodiscard]] int title_line() const { return title_line_; }

  /// Whether the table is so long that its times and its values are read one after the other, not to stand in the
  /// memory together.
  [[nodiscard]] bool is_long() const { return likely_rows_ > 1'000'000 && !options_.rows; }

  /// The rows of the named columns (empty: all), of which the first `complete`, one at most, must not miss values and
  /// are kept apart.
  Columns read(const std::vector<std::string>& wanted, std::size_t complete, BlankRows blank, bool with_lines = true) {
    const auto positions = positions_of(wanted, titles, title_line_, problems);
    problems.raise();
    NumberRows rows(positions, names_of(titles), dialect_.decimal);
    if (options_.missing) rows.allow_missing_from(complete);
    if (complete > 0) rows.separate_first();
    if (!with_lines) rows.without_lines();
    rows.reserve(options_.rows ? static_cast<std::size_t>(*options_.rows) : likely_rows_);
    read_rows(rows, blank);
    problems.raise();
    Columns columns{{}, std::move(rows)};
    for (const auto position : positions) columns.titles.push_back(titles[position]);
    return columns;
  }

  FileProblems problems;
  std::vector<Channel> titles;

private:
  /// Lines that tell the dialect: those up to the fiftieth with a point or a comma, or all.
  [[nodiscard]] std::vector<TextLine> first_lines() const {
    constexpr int enough = 52;
    const std::size_t most =
        options_.rows ? static_cast<std::size_t>(*options_.rows) + 1 : std::numeric_limits<std::size_t>::max();
    std::vector<TextLine> lines;
    LineWalk reader(text_.view());
    TextLine line;
    for (int with_sign = 0; lines.size() < most && with_sign < enough && reader.next(line);) {
      if (!has_content(line.text)) continue;
      lines.push_back(line);
      with_sign += line.text.find_first_of(",.") != std::string_view::npos ? 1 : 0;
    }
    return lines;
  }

  // Without a time column a row's number is its time: a row without values must keep its place. Blank rows count where
  // a row with content follows.
  void read_rows(NumberRows& rows, BlankRows blank) {
    constexpr std::ptrdiff_t released_at_once = 4 << 20;
    const std::size_t most =
        options_.rows ? static_cast<std::size_t>(*options_.rows) : std::numeric_limits<std::size_t>::max();
    const char* released = text_.view().data();
    std::vector<TextLine> blank_rows;
    bool begun = false;
    LineWalk reader(text_.view());
    for (TextLine line; rows.size() < most && reader.next(line);) {
      if (line.text.data() - released > released_at_once) {
        released = line.text.data();
        text_.release_before(released);
      }
      if (!has_content(line.text)) {
        if (begun && blank == BlankRows::count && is_blank_row(line)) blank_rows.push_back(line);
        continue;
      }
      if (std::exchange(begun, true) || !dialect_.header) {
        for (const TextLine& each : blank_rows) add_row(rows, each);
        add_row(rows, line);
        blank_rows.clear();
      }
    }
  }

  /// A line that holds separators and blanks alone; a line without any separator is such a row where there is one
  /// column.
  [[nodiscard]] bool is_blank_row(const TextLine& line) const {
    return trimmed(line.text).empty() &&
           (titles.size() == 1 || (dialect_.separator == '\t' && line.text.find('\t') != std::string_view::npos));
  }

  void add_row(NumberRows& rows, const TextLine& line) {
    split_cells(line.text, dialect_.separator, cells_);
    if (cells_.empty()) cells_.emplace_back();
    if (cells_.size() == titles.size() + 1 && cells_.back().empty()) cells_.pop_back();
    if (cells_.size() == titles.size()) return rows.add(line.number, cells_, problems);
    problems.add(
        line.number,
        "the line has " + std::to_string(cells_.size()) + " cells, the first line " + std::to_string(titles.size()),
        "every line needs the same number of cells", "correct the line; check the separator and the decimal sign");
  }

  CsvOptions options_;
  MappedText text_;
  Dialect dialect_;
  int title_line_ = 0;
  std::size_t likely_rows_ = 0;
  std::vector<std::string_view> cells_;  ///< of the present line
};

double seconds_per(const Channel& time, FileProblems& problems) {
  constexpr std::array spelled_out{"", "sec", "second", "seconds", "sek"};
  if (std::ranges::find(spelled_out, lower_case(time.unit)) != spelled_out.end()) return 1.0;
  try {
    return to_si("1 " + time.unit, "s");
  } catch (const InvalidInput&) {
    problems.add(0, "the time column '" + time.name + "' is in '" + time.unit + "'", "that is not a unit of time",
                 "write s, ms or us");
    return 1.0;
  }
}

/// What the column of times says.
struct StatedAxis {
  double sample_rate = 1.0, start = 0.0;
  VectorXd times = {};            ///< where they are uneven
  std::vector<Index> order = {};  ///< of the rows in time; empty: as they are
};

/// Of a table whose first column, which is kept apart, holds the times.
StatedAxis axis_of(Columns& table, const CsvOptions& options, FileProblems& problems) {
  const Channel& time = table.titles.front();
  VectorXd stamps = table.numbers.take_first();
  stamps *= seconds_per(time, problems);
  const auto& lines = table.numbers.lines();
  const TimeAxisOptions axis_options{.column = time.name, .jitter = options.jitter, .sample_rate = options.sample_rate};
  StatedAxis found;
  if (options.uneven) {
    StatedTimes stated = stated_times(stamps, lines, axis_options, options.missing, problems, options.notes);
    found = {1.0, stated.times.start, std::move(stated.times.times), std::move(stated.order)};
    if (stated.times.interval > 0.0) found.sample_rate = 1.0 / stated.times.interval;
  } else {
    const TimeAxis axis = time_axis(stamps, lines, axis_options, problems);
    found.sample_rate = axis.sample_rate;
    found.start = axis.start;
  }
  problems.raise();
  return found;
}

CsvRecord with_axis(StatedAxis axis, std::vector<Channel> titles, Eigen::MatrixXd values) {
  if (!axis.order.empty()) values = values(Eigen::all, axis.order).eval();
  return {{.sample_rate = axis.sample_rate,
           .start = axis.start,
           .channels = std::move(titles),
           .values = std::move(values)},
          0,
          std::move(axis.times)};
}

/// The record of a table with a column of times. Those of a long one are read before its values, so that both never
/// stand in the memory together.
CsvRecord record_with_times(CsvFile& file, const std::string& time, std::vector<std::string> wanted,
                            const CsvOptions& options) {
  if (file.is_long() && !wanted.empty()) {
    StatedAxis axis = [&] {
      Columns times = file.read({time}, 1, BlankRows::none);
      return axis_of(times, options, file.problems);
    }();
    auto [titles, numbers] = file.read(wanted, 0, BlankRows::none, false);
    return with_axis(std::move(axis), std::move(titles), numbers.take_by_column());
  }
  wanted.insert(wanted.begin(), time);
  Columns table = file.read(wanted, 1, BlankRows::none);
  StatedAxis axis = axis_of(table, options, file.problems);
  return with_axis(std::move(axis), {table.titles.begin() + 1, table.titles.end()}, table.numbers.take_by_column());
}

}  // namespace

CsvTable read_csv_table(const std::filesystem::path& path, const CsvOptions& options) {
  check(options);
  CsvFile file(path, options);
  auto [titles, numbers] = file.read(options.columns, 0, BlankRows::none);
  return {std::move(titles), numbers.by_column().transpose(), numbers.lines(), file.title_line()};
}

CsvRecord read_csv_record(const std::filesystem::path& path, const CsvOptions& options) {
  check(options);
  CsvFile file(path, options);
  const auto names = names_of(file.titles);
  const std::string time = find_time_column(names, options.time_column, file.problems);
  if (time.empty() && !options.sample_rate)
    file.problems.add(0, "the file has no time column and no sampling rate is given", "a record needs one of the two",
                      "name the time column or give the sampling rate in Hz");
  file.problems.raise();

  std::vector<std::string> wanted = options.columns.empty() ? names : options.columns;
  std::erase(wanted, time);
  if (time.empty()) {
    auto [titles, numbers] = file.read(wanted, 0, BlankRows::count);
    return {{*options.sample_rate, 0.0, std::move(titles), numbers.take_by_column()}, file.title_line()};
  }
  CsvRecord read = record_with_times(file, time, std::move(wanted), options);
  read.title_line = file.title_line();
  return read;
}

Record read_csv(const std::filesystem::path& path, const CsvOptions& options) {
  return read_csv_record(path, options).record;
}

namespace {

std::string title(const Channel& channel) {
  const std::string text = channel.unit.empty() ? channel.name : channel.name + " [" + channel.unit + "]";
  return text.find_first_of(";,\t \"") == std::string::npos ? text : '"' + text + '"';
}

/// The shortest text that reads back as the same number.
void append(std::string& text, double value) {
  std::array<char, 32> digits{};
  text.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
}

}  // namespace

void write_csv(const std::filesystem::path& path, const Record& record, char separator) {
  std::string text = title({"t", "s"});
  for (const auto& channel : record.channels) (text += separator) += title(channel);
  text += '\n';
  for (Eigen::Index k = 0; k < record.samples(); ++k) {
    append(text, record.time(k));
    for (const double value : record.values.col(k)) append(text += separator, value);
    text += '\n';
  }
  write_file_atomically(path, text);
}

}  // namespace kalfem
