// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tables/lvm.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/regular_file.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/tables/lvm_segments.hpp"
#include "kalfem/formats/tables/mapped_text.hpp"
#include "kalfem/formats/tables/measured_table.hpp"
#include "kalfem/formats/tables/text_table.hpp"
#include "kalfem/records/time_stamps.hpp"

namespace kalfem {

namespace {

using Cells = std::vector<std::string_view>;
using Eigen::Index;
using Eigen::VectorXd;

constexpr std::string_view end_of_header = "***End_of_Header***";

/// Keys of the file's header and of a segment's -> cells after them; the segment's win.
struct Header {
  std::map<std::string, Cells, std::less<>> entries;
  std::map<std::string, int, std::less<>> lines;

  [[nodiscard]] std::string_view first(const std::string& key) const {
    const auto found = entries.find(key);
    return found == entries.end() || found->second.empty() ? std::string_view() : found->second.front();
  }
  [[nodiscard]] int line_of(const std::string& key) const {
    const auto found = lines.find(key);
    return found == lines.end() ? 0 : found->second;
  }
};

constexpr std::string_view separator_key = "Separator";

/// The separator that its line names, "Separator<TAB>Tab", "Separator,Comma", or writes as itself, "Separator;;".
char separator_in(std::string_view line) {
  const std::string said = lower_case(line.substr(separator_key.size()));
  const auto says = [&](std::string_view word) { return said.find(word) != std::string::npos; };
  if (says("semicolon")) return ';';
  if (says("comma")) return ',';
  if (says("tab")) return '\t';
  return says(";") ? ';' : says(",") ? ',' : '\t';
}

/// How the file is written.
struct Dialect {
  char separator = '\t';
  char decimal = '.';
};

enum class TimeColumns { none, one, of_each };

/// A segment as its lines say it.
struct Segment {
  Header header;
  TextLine titles;
  std::vector<TextLine> rows;
};

class LvmReader {
public:
  explicit LvmReader(const std::filesystem::path& path)
      : path_(path.string()), text_(path), lines_(split_lines(text_.view())), problems_(path_) {}

  LvmContents read() {
    split();
    problems_.raise();
    for (const auto& segment : segments_) {
      read_segment(segment);
      problems_.raise();
    }
    return std::move(contents_);
  }

private:
  // --- lines ---

  // The separator must be known before the lines can be split, so it is looked for as text.
  void split() {
    std::size_t at = 0;
    Header header;
    if (!read_header(at, header)) return refuse_header(0);
    dialect_.decimal = decimal_of(header);
    while (at < lines_.size()) {
      Segment segment{.header = header, .titles = {}, .rows = {}};
      if (!read_header(at, segment.header)) {
        if (segments_.empty()) return refuse_header(1);
        contents_.notes.push_back(path_ + ": the header of segment " + std::to_string(segments_.size() + 1) +
                                  " is cut off: the segment is left out");
        break;
      }
      if (at < lines_.size()) segment.titles = lines_[at++];
      for (; at < lines_.size() && !begins_segment(lines_[at].text); ++at)
        if (!trimmed(lines_[at].text).empty()) segment.rows.push_back(lines_[at]);
      segments_.push_back(std::move(segment));
      while (at < lines_.size() && trimmed(lines_[at].text).empty()) ++at;
    }
    if (segments_.empty() && problems_.empty()) refuse_header(1);
  }

  /// As the header says, unless the file's last lines behind all headers say otherwise.
  char decimal_of(const Header& header) {
    constexpr std::size_t looked_at = 20;
    const char said = header.first("Decimal_Separator") == "," ? ',' : '.';
    std::vector<TextLine> last;
    for (auto line = lines_.rbegin(); line != lines_.rend() && last.size() < looked_at; ++line) {
      if (line->text.starts_with(end_of_header)) break;
      last.push_back(*line);
    }
    const auto fits = [&](char decimal) {
      return std::ranges::any_of(last, [&](const TextLine& line) {
        return std::ranges::any_of(split_cells(line.text, dialect_.separator), [&](std::string_view cell) {
          return cell.find(decimal) != std::string_view::npos && parse_number(cell, decimal);
        });
      });
    };
    const char other = said == '.' ? ',' : '.';
    if (fits(said) || !fits(other)) return said;
    contents_.notes.push_back(path_ + ":" + std::to_string(header.line_of("Decimal_Separator")) +
                              ": the samples have the decimal sign '" + other + "', not that of the header");
    return other;
  }

  void refuse_header(int blocks) {
    problems_.add(0, "the file has " + std::to_string(blocks) + " of the two " + std::string(end_of_header) + " marks",
                  "this is not a complete LabVIEW measurement file");
  }

  [[nodiscard]] static bool begins_segment(std::string_view line) {
    for (const std::string_view key :
         {std::string_view("Channels"), std::string_view("***Start_Special***"), end_of_header})
      if (line.starts_with(key)) return true;
    return false;
  }

  /// Whether the header has its end.
  bool read_header(std::size_t& at, Header& header) {
    bool special = false;
    while (at < lines_.size()) {
      const auto& line = lines_[at++];
      if (line.text.starts_with(separator_key)) dialect_.separator = separator_in(line.text);
      Cells cells = split_cells(line.text, dialect_.separator);
      const std::string key(cells.front());
      if (key == end_of_header) return true;
      if (key == "***Start_Special***" || key == "***End_Special***") special = key == "***Start_Special***";
      if (special || key.empty()) continue;
      cells.erase(cells.begin());
      header.lines[key] = line.number;
      header.entries[key] = std::move(cells);
    }
    return false;
  }

  // --- a segment ---

  void read_segment(const Segment& segment) {
    const std::size_t count = channel_count(segment.header);
    problems_.raise();
    if (segment.titles.number == 0 || segment.rows.empty()) {
      if (segments_.size() == 1) return problems_.add(0, "the file ends after its header", "there are no samples");
      contents_.notes.push_back(path_ + ":" + std::to_string(segment.header.line_of("Channels")) +
                                ": the segment that begins here has no samples");
      return;
    }
    const auto columns = times_of(segment);
    auto channels = titles_of(segment, count, columns);
    problems_.raise();
    read_rows(segment, columns, channels);
    problems_.raise();
    for (std::size_t j = 0; j < count; ++j) {
      channels[j].of_frequency = dimension_of(segment.header, j) == "frequency";
      set_axis(segment.header, j, channels[j]);
    }
    if (!channels.empty() && channels.front().lines.empty())
      problems_.add(0, "the file ends after its header", "there are no samples");
    contents_.segments.push_back(std::move(channels));
  }

  /// "time", "frequency", ... in small letters.
  static std::string dimension_of(const Header& header, std::size_t channel) {
    const auto entry = header.entries.find("X_Dimension");
    if (entry == header.entries.end() || entry->second.empty()) return "time";
    return lower_case(entry->second[std::min(channel, entry->second.size() - 1)]);
  }

  std::size_t channel_count(const Header& header) {
    const auto number = parse_number(header.first("Channels"), '.');
    if (number && *number >= 1 && *number <= 1e6 && *number == std::floor(*number))
      return static_cast<std::size_t>(*number);
    problems_.add(header.line_of("Channels"),
                  "the header names '" + std::string(header.first("Channels")) + "' channels",
                  "a positive whole number is required");
    return 0;
  }

  static TimeColumns times_of(const Segment& segment) {
    const auto said = segment.header.first("X_Columns");
    return said == "No" ? TimeColumns::none : said == "Multi" ? TimeColumns::of_each : TimeColumns::one;
  }

  /// Column of a channel's values.
  static std::size_t column_of(std::size_t channel, TimeColumns times) {
    return times == TimeColumns::of_each ? 2 * channel + 1 : channel + 1;
  }

  std::vector<LvmChannel> titles_of(const Segment& segment, std::size_t count, TimeColumns times) {
    const Cells titles = split_cells(segment.titles.text, dialect_.separator);
    std::vector<LvmChannel> channels;
    if (titles.size() <= column_of(count - 1, times)) {
      problems_.add(segment.titles.number, "the line of names has " + std::to_string(titles.size()) + " cells",
                    "the time and each of the " + std::to_string(count) + " channels need a name");
      return channels;
    }
    const auto units = segment.header.entries.find("Y_Unit_Label");
    for (std::size_t j = 0; j < count; ++j) {
      const bool has_unit = units != segment.header.entries.end() && j < units->second.size();
      Channel title{to_utf8(titles[column_of(j, times)]), has_unit ? to_utf8(units->second[j]) : ""};
      if (title.unit.empty()) title = channel_of(title.name);
      channels.push_back({{.name = title.name, .unit = title.unit}, {}, {}});
    }
    return channels;
  }

  // Line by line: times and channels; a comment after them is left out.
  void read_rows(const Segment& segment, TimeColumns times, std::vector<LvmChannel>& channels) {
    const std::size_t needed = column_of(channels.size() - 1, times) + 1, first = times == TimeColumns::none ? 1 : 0;
    std::vector<std::size_t> columns(needed - first);
    std::iota(columns.begin(), columns.end(), first);
    const Cells titles = split_cells(segment.titles.text, dialect_.separator);
    NumberRows rows(columns, {titles.begin(), titles.end()}, dialect_.decimal);
    rows.allow_missing_from(times == TimeColumns::one ? 1 : 0);
    for (const TextLine& line : segment.rows) {
      Cells cells = split_cells(line.text, dialect_.separator);
      if (is_cut_off(segment, line, cells.size(), needed)) break;
      while (cells.size() < needed && has_ended(segment.header, channel_in(cells.size(), times), rows.lines().size()))
        cells.emplace_back();
      if (cells.size() >= needed)
        rows.add(line.number, cells, problems_);
      else
        problems_.add(line.number, "the line has " + std::to_string(cells.size()) + " cells",
                      std::to_string(needed) + " are required", "correct the line");
    }
    if (!problems_.empty()) return;
    distribute(segment.header, rows, times, channels);
  }

  /// The channel whose values or times stand in a column.
  static std::size_t channel_in(std::size_t column, TimeColumns times) {
    return times == TimeColumns::of_each ? column / 2 : column - 1;
  }

  /// Whether a channel declares no more samples than there were before this row.
  [[nodiscard]] bool has_ended(const Header& header, std::size_t channel, std::size_t row) const {
    return declared(header, channel).value_or(HUGE_VAL) <= static_cast<double>(row);
  }

  /// The file's last line, if it has too few cells, or ends in a cell that may lack digits because more lines were to
  /// come.
  bool is_cut_off(const Segment& segment, const TextLine& line, std::size_t cells, std::size_t needed) {
    const bool last = line.text.data() + line.text.size() == text_.view().data() + text_.view().size();
    if (!last || segment.rows.size() < 2) return false;
    const auto usual = split_cells(segment.rows.front().text, dialect_.separator).size();
    const bool more_to_come = declared(segment.header, 0).value_or(0.0) > static_cast<double>(segment.rows.size());
    if (cells >= needed && !(more_to_come && cells <= std::min(usual, needed))) return false;
    contents_.notes.push_back(path_ + ":" + std::to_string(line.number) + ": the last line is cut off and left out");
    return true;
  }

  /// Headers keep the decimal sign that they state where the samples have another one.
  [[nodiscard]] std::optional<double> number_in(std::string_view cell) const {
    const auto number = parse_number(cell, dialect_.decimal);
    return number ? number : parse_number(cell, dialect_.decimal == '.' ? ',' : '.');
  }

  [[nodiscard]] std::optional<double> declared(const Header& header, std::size_t channel) const {
    const auto entry = header.entries.find("Samples");
    if (entry == header.entries.end() || entry->second.empty()) return std::nullopt;
    return number_in(entry->second[std::min(channel, entry->second.size() - 1)]);
  }

  void distribute(const Header& header, const NumberRows& rows, TimeColumns times, std::vector<LvmChannel>& channels) {
    const auto values = rows.by_column();
    for (std::size_t j = 0; j < channels.size(); ++j) {
      auto& channel = channels[j].channel;
      auto& stamps = channels[j].stamps;
      auto& lines = channels[j].lines;
      const auto column = static_cast<Index>(column_of(j, times)) - (times == TimeColumns::none ? 1 : 0);
      const Index count = samples_of(header, j, values.row(column));
      channel.values = values.row(column).head(count).transpose();
      if (times != TimeColumns::none)
        stamps = values.row(times == TimeColumns::one ? 0 : column - 1).head(count).transpose();
      lines.assign(rows.lines().begin(), rows.lines().begin() + count);
      check_stamps(channel.name, stamps, lines);
    }
    note_counts(header, channels);
  }

  /// A channel that declares fewer samples than there are lines ends with its last number.
  [[nodiscard]] Index samples_of(const Header& header, std::size_t j,
                                 const Eigen::Ref<const Eigen::RowVectorXd>& row) const {
    Index count = row.size();
    const auto said = declared(header, j);
    while (said && static_cast<double>(count) > *said && count > 0 && std::isnan(row[count - 1])) --count;
    return count;
  }

  void check_stamps(const std::string& name, const VectorXd& stamps, const std::vector<int>& lines) {
    for (Index k = 0; k < stamps.size(); ++k)
      if (!std::isfinite(stamps[k]))
        problems_.add(lines[static_cast<std::size_t>(k)], "the time of channel '" + name + "' is missing",
                      "every sample needs its time", "correct the line");
  }

  void note_counts(const Header& header, const std::vector<LvmChannel>& channels) {
    for (std::size_t j = 0; j < channels.size(); ++j) {
      const auto found = static_cast<double>(channels[j].channel.values.size());
      const auto said = declared(header, j);
      if (!said || *said == found) continue;
      contents_.notes.push_back(path_ + ":" + std::to_string(header.line_of("Samples")) + ": the header declares " +
                                shortest(*said) + " samples, the file contains " + shortest(found) +
                                ": these are taken");
      return;
    }
  }

  // --- times ---

  /// The number of a header entry for a channel, the last of them for channels behind it.
  std::optional<double> number_for(const Header& header, const std::string& key, std::size_t channel) {
    const auto entry = header.entries.find(key);
    if (entry == header.entries.end() || entry->second.empty()) return std::nullopt;
    const auto cell = entry->second[std::min(channel, entry->second.size() - 1)];
    if (cell.empty() && channel > 0) return number_for(header, key, 0);
    const auto number = number_in(cell);
    if (number && std::isfinite(*number)) return number;
    problems_.add(header.line_of(key),
                  key + " of channel " + std::to_string(channel + 1) + " is '" + std::string(cell) + "'",
                  "it must be a number", "correct the header");
    return std::nullopt;
  }

  void set_axis(const Header& header, std::size_t j, LvmChannel& each) {
    const double offset = relative_start(number_for(header, "X0", j).value_or(0.0));
    const auto interval = number_for(header, "Delta_X", j);
    if (!problems_.empty()) return;
    auto& channel = each.channel;
    if (each.stamps.size() > 0) {
      if (offset != 0.0 && std::abs(each.stamps[0] - offset) > 1e-6 * std::abs(offset)) each.stamps.array() += offset;
      return set_stamps(header, interval.value_or(0.0), each);
    }
    channel.start = offset;
    channel.interval = interval.value_or(0.0);
    if (channel.interval > 0.0) return;
    problems_.add(header.line_of("Delta_X"), interval ? "Delta_X is not positive" : "the header has no Delta_X",
                  "it must be the sampling interval in seconds");
  }

  /// Seconds since 1904 become seconds since the first segment began.
  double relative_start(double start) {
    constexpr double calendar = 1e8;
    if (std::abs(start) < calendar) return start;
    if (!calendar_start_) calendar_start_ = start;
    return start - *calendar_start_;
  }

  // Times that are printed to few decimals confirm Delta_X, which has all of them.
  void set_stamps(const Header& header, double interval, LvmChannel& each) {
    auto& channel = each.channel;
    if (each.stamps.size() == 1) {
      channel.start = each.stamps[0];
      channel.interval = std::max(interval, 0.0);
      return;
    }
    set_times(channel, each.stamps);
    if (!(interval > 0.0)) return;
    const double span = each.stamps[each.stamps.size() - 1] - each.stamps[0];
    const double usual = channel.interval > 0.0 ? channel.interval : typical_interval(each.stamps);
    if (std::abs(usual / interval - 1.0) <= 1e-3 + (channel.interval > 0.0 ? resolution(each.stamps) / span : 0.0)) {
      if (channel.interval > 0.0) channel.interval = interval;
      return;
    }
    if (noted_interval_) return;
    noted_interval_ = true;
    contents_.notes.push_back(path_ + ":" + std::to_string(header.line_of("Delta_X")) + ": Delta_X is " +
                              shortest(interval) + " s, but X_Value advances by " + shortest(usual) +
                              " s: X_Value is taken");
  }

  std::string path_;
  MappedText text_;
  std::vector<TextLine> lines_;
  FileProblems problems_;
  Dialect dialect_;
  std::vector<Segment> segments_;
  LvmContents contents_;
  std::optional<double> calendar_start_;
  bool noted_interval_ = false;
};

}  // namespace

bool begins_lvm(std::string_view head) { return head.starts_with("LabVIEW Measurement"); }

namespace {

/// LabVIEW writes no header where the user wants none: the first line holds numbers alone.
bool has_no_header(const std::filesystem::path& path) {
  constexpr std::uintmax_t looked_at = 4096;
  std::string head = read_bytes(path, looked_at);
  head = utf16_as_utf8(head).value_or(head);
  const auto lines = content_lines(head);
  if (lines.empty()) return false;
  const auto cells = split_cells(lines.front().text, '\t');
  return std::ranges::all_of(
      cells, [](std::string_view cell) { return cell.empty() || parse_number(cell, '.') || parse_number(cell, ','); });
}

}  // namespace

MeasuredFile read_lvm(const std::filesystem::path& path) {
  if (has_no_header(path)) return read_measured_table(path);
  LvmContents contents = LvmReader(path).read();
  MeasuredFile file{.format = "LabVIEW measurement file"};
  add_segments(std::move(contents.segments), file);
  file.notes = std::move(contents.notes);
  return file;
}

}  // namespace kalfem
