#include "kalfem/formats/tables/lvm.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {

namespace {

using Cells = std::vector<std::string_view>;

/// Both header blocks as key -> cells after it; the later block wins.
struct Header {
  std::map<std::string, Cells, std::less<>> entries;
  std::map<std::string, int, std::less<>> lines;
  char separator = '\t';
  char decimal = '.';
  std::size_t length = 0;  ///< lines up to the second end-of-header

  [[nodiscard]] std::string_view first(const std::string& key) const {
    const auto found = entries.find(key);
    return found == entries.end() || found->second.empty() ? std::string_view() : found->second.front();
  }
};

constexpr std::string_view end_of_header = "***End_of_Header***";

// A LabVIEW measurement file has two headers, one of the file and one of the segment, each closed by
// ***End_of_Header***. Each line is a key and its cells, one for each channel. The separator must be known before the
// lines can be split, so it is looked for as text.
Header read_header(const std::vector<TextLine>& lines, FileProblems& problems) {
  Header header;
  int blocks = 0;
  for (const auto& line : lines) {
    ++header.length;
    if (line.text.starts_with("Separator") && line.text.find("Comma") != std::string_view::npos) header.separator = ',';
    Cells cells = split_cells(line.text, header.separator);
    const std::string key(cells.front());
    if (key == end_of_header && ++blocks == 2) break;
    cells.erase(cells.begin());
    header.lines[key] = line.number;
    header.entries[key] = std::move(cells);
  }
  if (blocks < 2)
    problems.add(0, "the file has " + std::to_string(blocks) + " of the two " + std::string(end_of_header) + " marks",
                 "this is not a complete LabVIEW measurement file");
  if (header.first("Decimal_Separator") == ",") header.decimal = ',';
  return header;
}

/// The number of a header entry that must be the same for all channels.
double common_number(const Header& header, const std::string& key, std::size_t channels, FileProblems& problems) {
  const auto entry = header.entries.find(key);
  const int line = entry == header.entries.end() ? 0 : header.lines.at(key);
  std::optional<double> common;
  for (std::size_t j = 0; entry != header.entries.end() && j < std::min(channels, entry->second.size()); ++j) {
    const auto number = parse_number(entry->second[j], header.decimal);
    if (!number || !std::isfinite(*number) || (common && *common != *number)) {
      problems.add(line, key + " of channel " + std::to_string(j + 1) + " is '" + std::string(entry->second[j]) + "'",
                   "it must be a number and the same for all channels", "resample or split the file");
      return NAN;
    }
    common = number;
  }
  if (!common) problems.add(line, "the header has no " + key, "the time axis depends on it");
  return common.value_or(NAN);
}

std::size_t channel_count(const Header& header, FileProblems& problems) {
  const auto number = parse_number(header.first("Channels"), '.');
  if (number && *number >= 1 && *number <= 1e6 && *number == std::floor(*number))
    return static_cast<std::size_t>(*number);
  problems.add(0, "the header names '" + std::string(header.first("Channels")) + "' channels",
               "a positive whole number is required");
  return 0;
}

/// Names and units; the titles stand in the line after the header, the first of them is that of the time.
std::vector<Channel> channels_of(const Header& header, const TextLine& line, std::size_t count,
                                 FileProblems& problems) {
  const Cells titles = split_cells(line.text, header.separator);
  std::vector<Channel> channels;
  if (titles.size() < count + 1) {
    problems.add(line.number, "the line of names has " + std::to_string(titles.size()) + " cells",
                 "the time and each of the " + std::to_string(count) + " channels need a name");
    return channels;
  }
  const auto units = header.entries.find("Y_Unit_Label");
  for (std::size_t j = 0; j < count; ++j) {
    const bool has_unit = units != header.entries.end() && j < units->second.size();
    channels.push_back({std::string(titles[j + 1]), has_unit ? std::string(units->second[j]) : ""});
  }
  return channels;
}

/// Line by line: the time where there is one, the channels; a comment after them is left out.
NumberRows read_rows(const std::vector<TextLine>& lines, const Header& header, bool has_time,
                     const std::vector<Channel>& channels, bool missing, FileProblems& problems) {
  std::vector<std::string> names{"X_Value"};
  for (const auto& channel : channels) names.push_back(channel.name);
  std::vector<std::size_t> columns(channels.size() + (has_time ? 1 : 0));
  std::iota(columns.begin(), columns.end(), std::size_t{has_time ? 0u : 1u});

  NumberRows rows(columns, names, header.decimal);
  if (missing) rows.allow_missing_from(has_time ? 1 : 0);
  for (std::size_t i = header.length + 1; i < lines.size(); ++i) {
    const TextLine& line = lines[i];
    if (trimmed(line.text).empty()) continue;
    if (line.text.starts_with("Channels") || line.text.starts_with(end_of_header)) {
      problems.add(line.number, "a second segment begins here", "only one segment can be read", "split the file");
      break;
    }
    const Cells cells = split_cells(line.text, header.separator);
    if (cells.size() > channels.size())
      rows.add(line.number, cells, problems);
    else
      problems.add(line.number, "the line has " + std::to_string(cells.size()) + " cells",
                   std::to_string(channels.size() + 1) + " are required", "correct the line");
  }
  return rows;
}

/// The header's own count of samples against the lines that are there.
void check_count(const Header& header, std::size_t found, FileProblems& problems) {
  const auto entry = header.entries.find("Samples");
  if (entry == header.entries.end()) return;
  double declared = 0.0;
  for (const auto cell : entry->second) declared = std::max(declared, parse_number(cell, header.decimal).value_or(0.0));
  if (declared <= static_cast<double>(found)) return;
  problems.add(header.lines.at("Samples"),
               "the header declares " + shortest(declared) + " samples, the file contains " + std::to_string(found),
               "the file is truncated", "copy or export it again, or correct the count in the header");
}

}  // namespace

// The interval Delta_X sets the rate. If there is a time column, it must agree with the rate, and its first value is
// added to X0.
Record read_lvm(const std::filesystem::path& path, bool missing) {
  const std::string text = read_text(path);
  const std::vector<TextLine> lines = split_lines(text);
  FileProblems problems(path.string());

  const Header header = read_header(lines, problems);
  if (header.first("X_Columns") == "Multi")
    problems.add(header.lines.at("X_Columns"), "X_Columns is Multi: every channel has its own times",
                 "a record needs one time axis", "export with X_Columns One");
  problems.raise();
  const std::size_t count = channel_count(header, problems);
  const double interval = common_number(header, "Delta_X", count, problems);
  double start = common_number(header, "X0", count, problems);
  if (problems.empty() && !(interval > 0.0))
    problems.add(header.lines.at("Delta_X"), "Delta_X is not positive", "it must be the sampling interval in seconds");
  if (header.length >= lines.size()) problems.add(0, "the file ends after its header", "there are no samples");
  problems.raise();

  const auto channels = channels_of(header, lines[header.length], count, problems);
  problems.raise();
  const bool has_time = header.first("X_Columns") != "No";
  const NumberRows rows = read_rows(lines, header, has_time, channels, missing, problems);
  if (rows.lines().empty())
    problems.add(0, "the file ends after its header", "there are no samples");
  else if (problems.empty())
    check_count(header, rows.lines().size(), problems);
  problems.raise();

  const auto values = rows.by_column();
  const double sample_rate = 1.0 / interval;
  if (has_time && values.cols() > 1)
    start +=
        time_axis(values.row(0).transpose(), rows.lines(), {.column = "X_Value", .sample_rate = sample_rate}, problems)
            .start;
  problems.raise();
  return {sample_rate, start, channels, values.bottomRows(static_cast<Eigen::Index>(count))};
}

}  // namespace kalfem
