#include "kalfem/formats/tables/measured_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <ranges>
#include <set>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/formats/mapped_file.hpp"
#include "kalfem/formats/tables/text_table.hpp"
#include "kalfem/records/time_stamps.hpp"

namespace kalfem {
namespace {

using Cells = std::vector<std::string_view>;
using Eigen::Index;
using Eigen::VectorXd;

/// Seconds in one of a time column's unit; nothing where it is no unit of time.
std::optional<double> seconds_in(const std::string& unit) {
  const std::string word = lower_case(unit);
  if (word.empty() || word == "sec" || word == "second" || word == "seconds" || word == "sek") return 1.0;
  try {
    return to_si("1 " + unit, "s");
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
}

/// "[mm]" or "(mm)" without its brackets.
std::string unit_in(std::string_view cell) {
  if (cell.size() > 2 && (cell.front() == '[' || cell.front() == '(')) cell = cell.substr(1, cell.size() - 2);
  return valid_utf8(cell);
}

bool is_unit(std::string_view cell) {
  if (cell.empty() || cell == "-") return true;
  if ((cell.front() == '[' && cell.back() == ']') || (cell.front() == '(' && cell.back() == ')')) return true;
  return !channel_of("x (" + std::string(cell) + ")").unit.empty() || seconds_in(std::string(cell)).has_value();
}

class TableReader {
public:
  explicit TableReader(const std::filesystem::path& path)
      : path_(path.string()), file_(path), problems_(path_), text_(file_.bytes()) {
    if (text_.starts_with("\xEF\xBB\xBF")) text_.remove_prefix(3);
    lines_ = content_lines(text_);
  }

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
      return cells == is_number_.size() || cells == is_number_.size() + 1;
    };
    if (!has_table_width(0)) return false;
    if (lines_.size() > 2 && has_table_width(1) && !is_row(cells_of(lines_[0])) &&
        std::ranges::all_of(cells_of(lines_[1]), is_unit))
      return false;
    find_table();
    name_columns();
    return std::ranges::count_if(columns_, [](const Channel& column) { return is_time_name(column.name); }) < 2;
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
    for (const auto cell : cells_of(sample.front())) is_number_.push_back(is_number(cell) || is_missing_value(cell));
    if (std::ranges::count(is_number_, true) == 0)
      refuse(sample.front().number, "the file holds no table of numbers", "a line from its last third has none");
  }

  [[nodiscard]] bool is_number(std::string_view cell) const { return parse_number(cell, decimal_).has_value(); }

  /// Whether numbers stand where the typical line has them.
  [[nodiscard]] bool is_row(const Cells& cells) const {
    if (cells.size() < is_number_.size() || cells.size() > is_number_.size() + 1) return false;
    int numbers = 0;
    for (std::size_t i = 0; i < is_number_.size(); ++i) {
      if (!is_number_[i]) continue;
      if (is_number(cells[i]))
        ++numbers;
      else if (!is_missing_value(cells[i]))
        return false;
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
    const auto first_number = static_cast<std::size_t>(std::ranges::find(is_number_, true) - is_number_.begin());
    if (above.size() < is_number_.size() || above.size() > is_number_.size() + 1 || !is_number(above[first_number]))
      return;
    refuse(lines_[first_ - 1].number, "the line begins with a number and has other cells that are none",
           "it is neither a line of names nor a row of the table");
  }

  /// Names stand right above the table, or above a line of units.
  void name_columns() {
    const std::size_t width = is_number_.size();
    const auto above = [&](std::size_t lines) -> Cells {
      if (first_ < lines) return {};
      Cells cells = split_cells(lines_[first_ - lines].text, separator_);
      if (cells.size() > width) cells.resize(width);
      return cells.size() + 1 >= width ? cells : Cells();
    };
    Cells names = above(1), units;
    const bool two_lines = !above(2).empty() && std::ranges::all_of(names, is_unit) && !names.empty();
    if (two_lines) {
      units = names;
      names = above(2);
    }
    for (std::size_t i = 0; i < width; ++i) {
      Channel title = i < names.size() && !names[i].empty() ? channel_of(names[i]) : Channel{};
      if (title.name.empty()) title.name = "column_" + std::to_string(i + 1);
      if (i < units.size() && title.unit.empty() && units[i] != "-") title.unit = unit_in(units[i]);
      columns_.push_back({valid_utf8(title.name), valid_utf8(title.unit)});
    }
  }

  void read_rows() {
    std::vector<std::size_t> wanted;
    std::vector<std::string> names;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      names.push_back(columns_[i].name);
      if (is_number_[i])
        wanted.push_back(i);
      else
        measured_.skipped.push_back("column '" + columns_[i].name + "' holds text");
    }
    NumberRows rows(wanted, names, decimal_);
    rows.allow_missing_from(0);
    for (std::size_t i = first_; i < lines_.size(); ++i) {
      Cells cells = split_cells(lines_[i].text, separator_);
      if (is_cut_off(i, cells.size())) break;
      if (cells.size() >= is_number_.size())
        rows.add(lines_[i].number, cells, problems_);
      else
        problems_.add(
            lines_[i].number,
            "the line has " + std::to_string(cells.size()) + " cells, others " + std::to_string(is_number_.size()),
            "every line needs the same number of cells", "correct the line");
    }
    problems_.raise();
    const auto values = rows.by_column();
    values_.assign(columns_.size(), VectorXd());
    for (std::size_t j = 0; j < wanted.size(); ++j) values_[wanted[j]] = values.row(static_cast<Index>(j)).transpose();
  }

  /// The file's last line, without a line end and with too few cells.
  bool is_cut_off(std::size_t line, std::size_t cells) {
    if (line + 1 < lines_.size() || text_.ends_with('\n') || cells >= is_number_.size()) return false;
    measured_.notes.push_back(path_ + ":" + std::to_string(lines_[line].number) +
                              ": the last line is cut off and left out");
    return true;
  }

  /// The columns that hold times.
  [[nodiscard]] std::vector<std::size_t> time_columns() {
    std::vector<std::size_t> times;
    for (std::size_t i = 0; i < columns_.size(); ++i)
      if (is_number_[i] && is_time_name(columns_[i].name)) times.push_back(i);
    if (!times.empty() || columns_.size() < 2 || !is_number_[0] || !even_times(values_[0])) return times;
    measured_.notes.push_back(path_ + ": '" + columns_[0].name + "' increases evenly: it is taken as time");
    return {0};
  }

  void make_channels() {
    measured_.format = "table of text";
    const auto times = time_columns();
    std::optional<std::size_t> time;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (std::ranges::find(times, i) != times.end())
        time = i;
      else if (is_number_[i])
        add_channel(i, time);
    }
    if (measured_.channels.empty())
      refuse(0, "the file has no channel beside its times", "there is nothing to look at");
  }

  void add_channel(std::size_t column, std::optional<std::size_t> time) {
    MeasuredChannel channel{
        .name = unique(columns_[column].name, column), .unit = columns_[column].unit, .values = values_[column]};
    if (time) {
      VectorXd stamps = values_[*time] * seconds_of(*time);
      // A pair of columns that ends before the others has empty cells there.
      Index count = stamps.size();
      while (count > 0 && std::isnan(stamps[count - 1])) --count;
      channel.values.conservativeResize(count);
      set_times(channel, stamps.head(count));
    }
    measured_.channels.push_back(std::move(channel));
  }

  double seconds_of(std::size_t time) {
    const auto seconds = seconds_in(columns_[time].unit);
    if (!seconds && std::ranges::find(strange_, time) == strange_.end()) {
      strange_.push_back(time);
      measured_.notes.push_back(path_ + ": '" + columns_[time].name + "' is in '" + columns_[time].unit +
                                "', which is no unit of time: it is taken as s");
    }
    return seconds.value_or(1.0);
  }

  [[nodiscard]] std::string unique(const std::string& name, std::size_t column) const {
    const bool taken = std::ranges::find(measured_.channels, name, &MeasuredChannel::name) != measured_.channels.end();
    return taken ? name + " (column " + std::to_string(column + 1) + ")" : name;
  }

  std::string path_;
  MappedFile file_;
  FileProblems problems_;
  std::string_view text_;
  std::vector<TextLine> lines_;
  char separator_ = ',', decimal_ = '.';
  bool ends_in_separator_ = false;
  std::vector<bool> is_number_;  ///< of each column
  std::size_t first_ = 0;        ///< line of the table
  std::vector<Channel> columns_;
  std::vector<VectorXd> values_;
  std::vector<std::size_t> strange_;
  MeasuredFile measured_;
};

}  // namespace

MeasuredFile read_measured_table(const std::filesystem::path& path) { return TableReader(path).read(); }

bool is_plain_table(const std::filesystem::path& path) { return TableReader(path).is_plain(); }

namespace {

/// A scalar, or what programs write for one: an array of one element.
bool is_one_number(const std::vector<Index>& shape) {
  return std::ranges::all_of(shape, [](Index length) { return length == 1; });
}

/// A vector in the group of a dataset, with as many values, whose name says that it holds times.
std::string times_beside(const Hdf5File& file, const std::string& dataset, Index samples) {
  const std::string group = dataset.substr(0, dataset.rfind('/') + 1);
  for (const char* name : {"t", "time", "Time", "times", "timestamps"}) {
    std::string beside = group + name;
    if (beside == dataset || !file.contains(beside) || !file.holds_numbers(beside)) continue;
    const auto shape = file.shape(beside);
    Index length = 1;
    for (const Index each : shape) length *= each;
    if (length == samples && (shape.size() == 1 || (shape.size() == 2 && std::min(shape[0], shape[1]) == 1)))
      return beside;
  }
  return "";
}

std::optional<double> number_beside(const Hdf5File& file, const std::string& dataset,
                                    std::initializer_list<const char*> names) {
  const std::string group = dataset.substr(0, dataset.rfind('/'));
  for (const char* name : names) {
    for (const std::string& object : {dataset, std::string("/")})
      if (file.has_attribute(object, name)) return file.number_attribute(object, name);
    const std::string beside = group + "/" + name;
    if (file.contains(beside) && file.holds_numbers(beside) && is_one_number(file.shape(beside)))
      return file.read(beside)[0];
  }
  return std::nullopt;
}

std::string unit_of(const Hdf5File& file, const std::string& dataset, Index column) {
  for (const char* name : {"unit", "units"}) {
    if (!file.has_attribute(dataset, name)) continue;
    const auto units = file.texts_attribute(dataset, name);
    if (units.size() == 1) return units.front();
    if (column < std::ssize(units)) return units[static_cast<std::size_t>(column)];
  }
  return "";
}

}  // namespace

MeasuredFile read_measured_hdf5(const std::filesystem::path& path) {
  const auto file = Hdf5File::open(path.string());
  MeasuredFile measured{.format = "HDF5 file"};
  std::set<std::string> times_of_others;
  for (const auto& dataset : file.datasets()) {
    const auto shape = file.shape(dataset);
    if (file.holds_numbers(dataset) && is_one_number(shape)) continue;
    if (!file.holds_numbers(dataset) || shape.empty() || shape.size() > 2) {
      measured.skipped.push_back("dataset '" + dataset + "' is no table of numbers");
      continue;
    }
    const auto rate = number_beside(file, dataset, {"sample_rate", "sampling_rate", "fs_Hz", "fs", "sample_rate_Hz"});
    const auto interval = number_beside(file, dataset, {"dt", "time_step"});
    Eigen::MatrixXd values = file.read_matrix(dataset);
    if (values.rows() == 1) values.transposeInPlace();
    const std::string times = times_beside(file, dataset, values.rows());
    if (!times.empty()) times_of_others.insert(times);
    for (Index j = 0; j < values.cols(); ++j) {
      const std::string column = values.cols() == 1 ? "" : "[" + std::to_string(j) + "]";
      MeasuredChannel channel{.name = dataset + column,
                              .unit = unit_of(file, dataset, j),
                              .interval = rate && *rate > 0.0 ? 1.0 / *rate : interval.value_or(0.0),
                              .values = values.col(j),
                              .other_names = {dataset.substr(dataset.rfind('/') + 1) + column}};
      if (!times.empty()) set_times(channel, file.read(times));
      measured.channels.push_back(std::move(channel));
    }
  }
  std::erase_if(measured.channels, [&](const auto& channel) { return times_of_others.contains(channel.name); });
  if (measured.channels.empty())
    throw InvalidInput(Issue{{path.string(), 0},
                             "the HDF5 file holds no table of numbers",
                             "",
                             "write the channels as one dataset, samples x channels"});
  return measured;
}

}  // namespace kalfem
