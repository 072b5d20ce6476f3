// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tables/measured_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <ranges>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/tables/date_time.hpp"
#include "kalfem/formats/tables/mapped_text.hpp"
#include "kalfem/formats/tables/table_titles.hpp"
#include "kalfem/formats/tables/text_table.hpp"
#include "kalfem/records/time_stamps.hpp"

namespace kalfem {
namespace {

using Cells = std::vector<std::string_view>;
using Eigen::Index;
using Eigen::VectorXd;

enum class Content { text, number, stamp };

enum class LookedAt { all, ends };

/// The lines with content; of a large text, where only its `ends` are looked at, those of its first and last two MiB.
/// The numbers of the last ones then count from there.
std::vector<TextLine> lines_of(std::string_view text, LookedAt looked_at) {
  constexpr std::size_t end_size = 2 << 20;
  const std::size_t head = text.substr(0, end_size).rfind('\n');
  if (looked_at == LookedAt::all || text.size() < 4 * end_size || head == std::string_view::npos)
    return content_lines(text);
  std::vector<TextLine> lines = content_lines(text.substr(0, head + 1));
  const std::string_view tail = text.substr(text.size() - end_size);
  const auto last = content_lines(tail.substr(tail.find('\n') + 1));
  lines.insert(lines.end(), last.begin(), last.end());
  return lines;
}

class TableReader {
public:
  explicit TableReader(const std::filesystem::path& path, LookedAt looked_at = LookedAt::all)
      : path_(path.string()), problems_(path_), text_(path), lines_(lines_of(text_.view(), looked_at)) {}

  MeasuredFile read() {
    find_dialect();
    find_table();
    name_columns();
    read_rows();
    problems_.raise();
    make_channels();
    return std::move(measured_);
  }

  // A damaged first row is no line of names: the plain reader will say what is wrong with it.
  bool is_plain() try {
    find_dialect();
    const auto has_table_width = [&](std::size_t line) {
      const auto cells = cells_of(lines_[line]).size();
      return cells == contents_.size() || cells == contents_.size() + 1;
    };
    if (!has_table_width(0) || std::ranges::find(contents_, Content::stamp) != contents_.end()) return false;
    if (lines_.size() > 2 && has_table_width(1) && !is_row(cells_of(lines_[0])) &&
        std::ranges::all_of(cells_of(lines_[1]), is_unit_cell))
      return false;
    find_table();
    name_columns();
    if (named_by_comment_ || lacks_digits()) return false;
    for (std::size_t i = 0; i < columns_.size(); ++i)
      if (may_be_time_name(columns_[i].name) && (i > 0 || !is_time_name(columns_[i].name))) return false;
    return true;
  } catch (const InvalidInput&) {
    return true;
  }

private:
  [[noreturn]] void refuse(int line, std::string what, std::string why) const {
    throw InvalidInput(Issue{{path_, line}, std::move(what), std::move(why), "export a table with one line a sample"});
  }

  [[nodiscard]] Cells cells_of(const TextLine& line) const {
    Cells cells = split_cells(line.text, separator_);
    if (cells.size() > 1 && cells.back().empty() && ends_in_separator_) cells.pop_back();
    return cells;
  }

  /// Whether lines end in a separator that begins no cell: all do then. A column that ends before the others leaves
  /// lines that look alike.
  void find_line_end(const TextLine& typical) {
    const std::size_t width = split_cells(typical.text, separator_).size();
    constexpr std::size_t looked_at = 200;
    ends_in_separator_ = std::ranges::none_of(lines_ | std::views::take(looked_at), [&](const TextLine& line) {
      const Cells cells = split_cells(line.text, separator_);
      return cells.size() == width && !cells.back().empty();
    });
  }

  void find_dialect() {
    if (lines_.empty()) refuse(0, "the file has no data", "it is empty");
    const std::size_t count = lines_.size(), typical = count < 4 ? count / 2 : count - 1 - count / 4;
    const std::vector<TextLine> sample(
        lines_.begin() + static_cast<std::ptrdiff_t>(typical),
        lines_.begin() + static_cast<std::ptrdiff_t>(std::min(lines_.size(), typical + 60)));
    separator_ = find_separator({sample.front(), sample.front()});
    std::vector<TextLine> with_first{sample.front()};
    with_first.insert(with_first.end(), sample.begin(), sample.end());
    decimal_ = find_decimal(with_first, separator_);
    find_line_end(sample.front());
    require_columns(split_cells(sample.front().text, separator_).size(), path_, sample.front().number);
    for (const auto cell : cells_of(sample.front()))
      contents_.push_back(is_number(cell) || is_missing_value(cell) ? Content::number
                          : parse_date_time(cell)                   ? Content::stamp
                                                                    : Content::text);
    if (std::ranges::count(contents_, Content::number) == 0)
      refuse(sample.front().number, "the file holds no table of numbers", "a line from its last third has none");
  }

  [[nodiscard]] bool is_number(std::string_view cell) const { return parse_number(cell, decimal_).has_value(); }

  /// Whether numbers, dates and times stand where the typical line has them.
  [[nodiscard]] bool is_row(const Cells& cells) const {
    if (cells.size() < contents_.size() || cells.size() > contents_.size() + 1) return false;
    int numbers = 0;
    for (std::size_t i = 0; i < contents_.size(); ++i) {
      if (contents_[i] == Content::text || is_missing_value(cells[i])) continue;
      if (contents_[i] == Content::number ? !is_number(cells[i]) : !parse_date_time(cells[i])) return false;
      numbers += contents_[i] == Content::number ? 1 : 0;
    }
    return numbers > 0;
  }

  void find_table() {
    while (first_ < lines_.size() && !is_row(cells_of(lines_[first_]))) ++first_;
    if (first_ == lines_.size()) refuse(0, "the file holds no table of numbers", "no line has only numbers");
    refuse_damaged_first_row();
  }

  /// A line of the table's width that begins with a number is no line of names.
  void refuse_damaged_first_row() const {
    if (first_ == 0) return;
    const Cells above = cells_of(lines_[first_ - 1]);
    const auto first_number =
        static_cast<std::size_t>(std::ranges::find(contents_, Content::number) - contents_.begin());
    if (above.size() < contents_.size() || above.size() > contents_.size() + 1 || !is_number(above[first_number]))
      return;
    refuse(lines_[first_ - 1].number, "the line begins with a number and has other cells that are none",
           "it is neither a line of names nor a row of the table");
  }

  /// Names stand right above the table, above a line of units, or in the last comment above the table.
  void name_columns() {
    const std::size_t width = contents_.size();
    const auto above = [&](std::size_t lines) -> Cells {
      if (first_ < lines) return {};
      Cells cells = split_cells(lines_[first_ - lines].text, separator_);
      if (cells.size() > width) cells.resize(width);
      return cells.size() + 1 >= width ? cells : Cells();
    };
    Cells names = above(1), units;
    const bool two_lines = !above(2).empty() && std::ranges::all_of(names, is_unit_cell) && !names.empty();
    if (two_lines) {
      units = names;
      names = above(2);
    }
    if (first_ == 0) {
      names = names_in_comment(text_.view(), lines_.front(), separator_, decimal_, width);
      named_by_comment_ = !names.empty();
    }
    columns_ = table_titles(names, units, width);
  }

  void read_rows() {
    std::vector<std::size_t> wanted, stamped;
    std::vector<std::string> names;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      names.push_back(columns_[i].name);
      if (contents_[i] == Content::number) wanted.push_back(i);
      if (contents_[i] == Content::stamp) stamped.push_back(i);
      if (contents_[i] == Content::text) measured_.skipped.push_back("column '" + columns_[i].name + "' holds text");
    }
    NumberRows rows(wanted, names, decimal_);
    rows.allow_missing_from(0);
    std::vector<Cells> stamps(stamped.size());
    for (std::size_t i = first_; i < lines_.size(); ++i) {
      Cells cells = split_cells(lines_[i].text, separator_);
      if (is_cut_off(i, cells.size())) break;
      if (cells.size() < contents_.size()) {
        problems_.add(
            lines_[i].number,
            "the line has " + std::to_string(cells.size()) + " cells, others " + std::to_string(contents_.size()),
            "every line needs the same number of cells", "correct the line");
        continue;
      }
      rows.add(lines_[i].number, cells, problems_);
      for (std::size_t j = 0; j < stamped.size(); ++j) stamps[j].push_back(cells[stamped[j]]);
    }
    problems_.raise();
    const auto values = rows.by_column();
    values_.assign(columns_.size(), VectorXd());
    for (std::size_t j = 0; j < wanted.size(); ++j) values_[wanted[j]] = values.row(static_cast<Index>(j)).transpose();
    read_stamps(stamped, stamps, rows.lines());
  }

  /// Dates and times of day as seconds from the first on; a date alone belongs to the time of day behind it.
  void read_stamps(const std::vector<std::size_t>& columns, const std::vector<Cells>& stamps,
                   const std::vector<int>& lines) {
    for (std::size_t j = 0; j < columns.size(); ++j) {
      const std::size_t column = columns[j];
      StampColumn read = read_stamp_column(stamps[j]);
      if (read.odd) {
        problems_.add(lines[*read.odd],
                      "column '" + columns_[column].name + "' holds '" +
                          std::string(stamps[j][*read.odd].substr(0, 40)) + "', which is no date or time",
                      "every sample needs its time", "correct the line");
        continue;
      }
      const bool time_follows = j + 1 < columns.size() && columns[j + 1] == column + 1;
      if (read.dates_only && time_follows) {
        measured_.skipped.push_back("column '" + columns_[column].name + "' holds dates");
        continue;
      }
      stamp_columns_.push_back(column);
      columns_[column].unit = "s";
      values_[column] = std::move(read.seconds);
      if (stamp_columns_.size() == 1)
        measured_.notes.push_back(path_ + ": times are counted from " + std::string(stamps[j].front()));
    }
    problems_.raise();
  }

  /// The file's last line, without a line end and with too few cells or digits.
  bool is_cut_off(std::size_t line, std::size_t cells) {
    if (line + 1 < lines_.size() || ends_in_line_end() || (cells >= contents_.size() && !lacks_digits())) return false;
    measured_.notes.push_back(path_ + ":" + std::to_string(lines_[line].number) +
                              ": the last line is cut off and left out");
    return true;
  }

  [[nodiscard]] bool ends_in_line_end() const { return text_.view().ends_with('\n') || text_.view().ends_with('\r'); }

  /// Whether the file ends within a number: all lines before have one number of decimals there, the last one fewer.
  [[nodiscard]] bool lacks_digits() const {
    constexpr std::size_t compared = 8, fewest_digits = 4;  // with the decimal sign
    if (ends_in_line_end() || lines_.size() < first_ + compared) return false;
    const auto decimals = [&](const TextLine& line) {
      const auto cells = split_cells(line.text, separator_);
      const std::size_t point = cells.empty() ? std::string_view::npos : cells.back().find(decimal_);
      return point == std::string_view::npos ? 0 : cells.back().size() - point;
    };
    const std::size_t usual = decimals(lines_[lines_.size() - 2]);
    for (std::size_t i = lines_.size() - compared; i + 1 < lines_.size(); ++i)
      if (decimals(lines_[i]) != usual) return false;
    return usual >= fewest_digits && decimals(lines_.back()) < usual;
  }

  /// Whether the column's name says that it may hold times, and its unit and its numbers do not contradict.
  [[nodiscard]] bool holds_times(std::size_t column) const {
    const std::string &name = columns_[column].name, &unit = columns_[column].unit;
    if (contents_[column] != Content::number) return false;
    if (is_time_name(name)) return column == 0 || !is_unit_but_of_time(unit);
    return may_be_time_name(name) && (unit.empty() || seconds_in(unit)) && increases(values_[column]);
  }

  /// The columns that hold times.
  [[nodiscard]] std::vector<std::size_t> time_columns() {
    std::vector<std::size_t> times;
    for (std::size_t i = 0; i < columns_.size(); ++i)
      if (holds_times(i)) times.push_back(i);
    if (times.empty()) return stamp_columns_.empty() ? first_column_if_even() : stamp_columns_;
    for (const std::size_t column : stamp_columns_)
      measured_.skipped.push_back("column '" + columns_[column].name + "' holds dates, beside the times");
    return times;
  }

  std::vector<std::size_t> first_column_if_even() {
    if (columns_.size() < 2 || contents_[0] != Content::number || !even_times(values_[0])) return {};
    measured_.notes.push_back(path_ + ": '" + columns_[0].name + "' increases evenly: it is taken as time");
    return {0};
  }

  void make_channels() {
    measured_.format = "table of text";
    const auto times = time_columns();
    std::optional<std::size_t> time;
    if (times.size() == 1) time = times.front();
    const auto rate = times.empty() ? rate_in_preamble() : std::nullopt;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (std::ranges::find(times, i) != times.end())
        time = i;
      else if (contents_[i] == Content::number)
        add_channel(i, time, rate);
    }
    if (measured_.channels.empty())
      refuse(0, "the file has no channel beside its times", "there is nothing to look at");
  }

  /// A sampling rate that a line above the table states.
  std::optional<double> rate_in_preamble() {
    for (const TextLine& line : split_lines(
             text_.view().substr(0, static_cast<std::size_t>(lines_[first_].text.data() - text_.view().data()))))
      if (const auto rate = stated_rate(line.text, decimal_)) {
        measured_.notes.push_back(path_ + ":" + std::to_string(line.number) + ": the sampling rate " + shortest(*rate) +
                                  " Hz is taken from this line");
        return rate;
      }
    return std::nullopt;
  }

  void add_channel(std::size_t column, std::optional<std::size_t> time, std::optional<double> rate) {
    MeasuredChannel channel{.name = unique(columns_[column].name, column),
                            .unit = columns_[column].unit,
                            .interval = rate ? 1.0 / *rate : 0.0,
                            .values = std::move(values_[column])};
    if (named_by_comment_) channel.other_names = {"column_" + std::to_string(column + 1)};
    if (time) {
      const VectorXd stamps = values_[*time] * seconds_of(*time);
      // A pair of columns that ends before the others has empty cells there.
      Index count = stamps.size();
      while (count > 0 && std::isnan(stamps[count - 1])) --count;
      channel.values.conservativeResize(count);
      set_times(channel, stamps.head(count));
    }
    measured_.channels.push_back(std::move(channel));
  }

  double seconds_of(std::size_t time) {
    const std::string unit = columns_[time].unit.empty() ? unit_in_time_name(columns_[time].name) : columns_[time].unit;
    const auto seconds = seconds_in(unit);
    if (!seconds && std::ranges::find(strange_, time) == strange_.end()) {
      strange_.push_back(time);
      measured_.notes.push_back(path_ + ": '" + columns_[time].name + "' is in '" + unit +
                                "', which is no unit of time: it is taken as s");
    }
    return seconds.value_or(1.0);
  }

  [[nodiscard]] std::string unique(const std::string& name, std::size_t column) const {
    const bool taken = std::ranges::find(measured_.channels, name, &MeasuredChannel::name) != measured_.channels.end();
    return taken ? name + " (column " + std::to_string(column + 1) + ")" : name;
  }

  std::string path_;
  FileProblems problems_;
  MappedText text_;
  std::vector<TextLine> lines_;
  char separator_ = ',', decimal_ = '.';
  bool ends_in_separator_ = false;
  std::vector<Content> contents_;  ///< of each column
  bool named_by_comment_ = false;
  std::size_t first_ = 0;  ///< line of the table
  std::vector<Channel> columns_;
  std::vector<VectorXd> values_;
  std::vector<std::size_t> stamp_columns_;
  std::vector<std::size_t> strange_;
  MeasuredFile measured_;
};

}  // namespace

MeasuredFile read_measured_table(const std::filesystem::path& path) { return TableReader(path).read(); }

bool is_plain_table(const std::filesystem::path& path) { return TableReader(path, LookedAt::ends).is_plain(); }

}  // namespace kalfem
