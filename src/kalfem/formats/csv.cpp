#include "kalfem/formats/csv.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numeric>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/formats/text_table.hpp"
#include "kalfem/formats/time_axis.hpp"

namespace kalfem {

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
      cells, [&](std::string_view cell) { return !cell.empty() && !parse_number(cell, dialect.decimal); });
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
  if (!(options.jitter >= 0.0 && options.jitter < 0.5))
    issues.add({}, "jitter is " + std::to_string(options.jitter), "it must be at least 0 and below 0.5 of an interval");
  issues.raise();
}

/// "name [unit]" taken apart.
Channel channel_of(std::string_view title) {
  const std::size_t open = title.rfind('[');
  if (open == std::string_view::npos || open == 0 || !title.ends_with(']')) return {std::string(title), ""};
  return {std::string(trimmed(title.substr(0, open))), std::string(title.substr(open + 1, title.size() - open - 2))};
}

std::vector<Channel> titles_of(const TextLine& first, const Dialect& dialect, FileProblems& problems) {
  auto cells = split_cells(first.text, dialect.separator);
  if (cells.size() > 1 && cells.back().empty()) cells.pop_back();
  std::vector<Channel> titles;
  for (const auto cell : cells) {
    Channel title = dialect.header ? channel_of(cell) : Channel{};
    if (title.name.empty()) title.name = "column_" + std::to_string(titles.size() + 1);
    if (std::ranges::any_of(titles, [&](const Channel& other) { return other.name == title.name; }))
      problems.add(first.number, "two columns are named '" + title.name + "'", "names must differ",
                   "rename one of them");
    titles.push_back(std::move(title));
  }
  return titles;
}

std::vector<std::string> names_of(const std::vector<Channel>& titles) {
  std::vector<std::string> names;
  for (const auto& title : titles) names.push_back(title.name);
  return names;
}

/// Positions of the wanted columns; of all when none is named.
std::vector<std::size_t> positions_of(const std::vector<std::string>& wanted, const std::vector<std::string>& names,
                                      FileProblems& problems) {
  std::vector<std::size_t> positions;
  for (const auto& name : wanted) {
    const auto found = std::ranges::find(names, name);
    if (found == names.end())
      problems.add(0, "there is no column '" + name + "'" + did_you_mean(name, names));
    else
      positions.push_back(static_cast<std::size_t>(found - names.begin()));
  }
  if (!wanted.empty()) return positions;
  positions.resize(names.size());
  std::iota(positions.begin(), positions.end(), std::size_t{0});
  return positions;
}

/// Name of the time column of a file with these columns, or "" when it has none.
std::string find_time_column(const std::vector<std::string>& names, const std::string& asked, FileProblems& problems) {
  if (asked.empty()) {
    constexpr std::array known{"t", "time", "t_s", "time_s", "t(s)", "time(s)", "t (s)", "time (s)", "x_value", "zeit"};
    const std::string first = lower_case(names.front());
    return std::ranges::find(known, first) != known.end() ? names.front() : "";
  }
  if (std::ranges::find(names, asked) != names.end()) return asked;
  const auto position = parse_number(asked, '.');
  if (position && *position >= 1 && *position <= double(names.size()) && *position == std::floor(*position))
    return names[static_cast<std::size_t>(*position) - 1];
  problems.add(0, "there is no time column '" + asked + "'" + did_you_mean(asked, names), "",
               "give a column's name, or its position from 1 to " + std::to_string(names.size()));
  return "";
}

/// A file opened, its dialect and titles known, its numbers not yet read.
class CsvFile {
public:
  CsvFile(const std::filesystem::path& path, const CsvOptions& options)
      : problems(path.string()), text_(read_text(path)), lines_(content_lines(text_)) {
    if (lines_.empty()) throw InvalidInput(Issue{{path.string(), 0}, "the file holds no data", "", "check the path"});
    dialect_ = find_dialect(lines_, options);
    titles = titles_of(lines_.front(), dialect_, problems);
    problems.raise();
  }

  /// The rows of the named columns (empty: all).
  CsvTable read(const std::vector<std::string>& wanted) {
    const auto names = names_of(titles);
    const auto positions = positions_of(wanted, names, problems);
    problems.raise();
    NumberRows rows(positions, names, dialect_.decimal);
    for (std::size_t i = dialect_.header ? 1 : 0; i < lines_.size(); ++i) add_row(rows, lines_[i]);
    problems.raise();
    CsvTable table{{}, rows.matrix(), rows.lines()};
    for (const auto position : positions) table.columns.push_back(titles[position]);
    return table;
  }

  FileProblems problems;
  std::vector<Channel> titles;

private:
  void add_row(NumberRows& rows, const TextLine& line) {
    auto cells = split_cells(line.text, dialect_.separator);
    if (cells.size() == titles.size() + 1 && cells.back().empty()) cells.pop_back();
    if (cells.size() == titles.size()) return rows.add(line.number, cells, problems);
    problems.add(
        line.number,
        "the line has " + std::to_string(cells.size()) + " cells, the first line " + std::to_string(titles.size()),
        "every line needs the same number of cells", "mend the line; check separator and decimal sign");
  }

  std::string text_;
  std::vector<TextLine> lines_;
  Dialect dialect_;
};

double seconds_per(const std::string& unit, const std::string& column, FileProblems& problems) {
  if (unit.empty() || unit == "s" || unit == "sec") return 1.0;
  if (unit == "ms") return 1e-3;
  if (unit == "us") return 1e-6;
  problems.add(0, "the time column '" + column + "' is in '" + unit + "'", "s, ms and us are known");
  return 1.0;
}

/// Takes the first column of the table as time.
TimeSeries with_time_column(CsvTable table, const CsvOptions& options, FileProblems& problems) {
  const Channel time = table.columns.front();
  const double unit = seconds_per(time.unit, time.name, problems);
  const TimeAxis axis =
      time_axis(table.values.col(0) * unit, table.lines,
                {.column = time.name, .jitter = options.jitter, .sample_rate = options.sample_rate}, problems);
  problems.raise();
  return {axis.sample_rate,
          axis.start,
          {table.columns.begin() + 1, table.columns.end()},
          table.values.rightCols(table.values.cols() - 1)};
}

}  // namespace

CsvTable read_csv_table(const std::filesystem::path& path, const CsvOptions& options) {
  check(options);
  return CsvFile(path, options).read(options.columns);
}

TimeSeries read_csv(const std::filesystem::path& path, const CsvOptions& options) {
  check(options);
  CsvFile file(path, options);
  const auto names = names_of(file.titles);
  const std::string time = find_time_column(names, options.time_column, file.problems);
  if (time.empty() && !options.sample_rate)
    file.problems.add(0, "neither a time column nor a sampling rate is known", "a record needs one of them",
                      "name the time column or give the sampling rate in Hz");
  file.problems.raise();

  std::vector<std::string> wanted = options.columns.empty() ? names : options.columns;
  std::erase(wanted, time);
  if (!time.empty()) wanted.insert(wanted.begin(), time);
  CsvTable table = file.read(wanted);
  if (!time.empty()) return with_time_column(std::move(table), options, file.problems);
  return {*options.sample_rate, 0.0, std::move(table.columns), std::move(table.values)};
}

}  // namespace kalfem
