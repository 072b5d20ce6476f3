// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/matlab/matlab_file.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/formats/matlab/matlab_frequencies.hpp"
#include "kalfem/formats/matlab/matlab_scope.hpp"
#include "kalfem/formats/matlab/matlab_units.hpp"
#include "kalfem/formats/matlab/matlab_values.hpp"
#include "kalfem/formats/tables/table_titles.hpp"
#include "kalfem/formats/tables/text_table.hpp"
#include "kalfem/records/time_stamps.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = MatlabValue::Kind;
using Fields = MatlabFields;

constexpr Index most_columns = 1000;

constexpr std::array<std::string_view, 9> rate_names = {
    "fs", "sample_rate", "samplerate", "sampling_rate", "samplingrate", "fsamp", "fs_hz", "rate", "sampling_frequency"};
constexpr std::array<std::string_view, 8> interval_names = {"dt",      "ts",  "delta_t",   "deltat",
                                                            "delta_x", "t_s", "increment", "interval"};
constexpr std::array<std::string_view, 6> start_names = {"t0", "start_value", "start", "x0", "start_time", "tstart"};
constexpr std::array<std::string_view, 4> title_names = {"name", "label", "title", "channel"};

std::string lengths_in_words(const MatlabValue& value) {
  if (value.lengths.empty()) return std::to_string(value.real.rows()) + " x " + std::to_string(value.real.cols());
  std::string words;
  for (const Index length : value.lengths) words += (words.empty() ? "" : " x ") + std::to_string(length);
  return words;
}

class Channels {
public:
  explicit Channels(MeasuredFile& file) : file_(file) {}

  void add_fields(const Fields& given, const std::string& prefix, const Scope* around) {
    const std::vector<NamedValue> fields = with_axis_fields(given);
    const Scope scope(fields, around);
    const SeriesUnits units(scope, prefix);
    for (const auto& [name, value] : given)
      add(value, prefix.empty() || name.empty() ? prefix + name : prefix + "." + name, name, {scope, units});
  }

  /// Leaves out the vectors that turned out to be frequencies of others.
  void finish() {
    for (const auto* axis : axes_)
      if (const auto found = paths_.find(axis); found != paths_.end())
        std::erase_if(file_.channels, [&](const MeasuredChannel& channel) {
          return channel.name == found->second || channel.description == found->second;
        });
  }

private:
  /// A structure: what states the times, frequencies and units of its series.
  struct Place {
    const Scope& scope;
    const SeriesUnits& units;
  };

  void skip(const std::string& name, const std::string& what) { file_.skipped.push_back("'" + name + "' is " + what); }

  void add(const MatlabValue& value, const std::string& path, const std::string& name, const Place& place) {
    if (is_one_of(name, matlab_unit_names) && value.kind != Kind::numbers) return;
    switch (value.kind) {
      case Kind::numbers:
        return add_numbers(value, path, name, place);
      case Kind::structure:
      case Kind::cells:
        return add_elements(value, path, place.scope);
      case Kind::text:
        if (!is_one_of(name, title_names) && !is_unit_of_a_series(name)) skip(path, "text");
        return;
      case Kind::other:
        return skip(path, value.what);
    }
  }

  /// "acc_unit", "unit_acc"
  static bool is_unit_of_a_series(const std::string& name) {
    const std::string word = lower_case(name);
    return word.ends_with("_unit") || word.ends_with("_units") || word.starts_with("unit_");
  }

  void add_elements(const MatlabValue& value, const std::string& path, const Scope& scope) {
    const char open = value.kind == Kind::cells ? '{' : '(', close = value.kind == Kind::cells ? '}' : ')';
    for (std::size_t i = 0; i < value.elements.size(); ++i) {
      const bool single = value.elements.size() == 1 && value.kind == Kind::structure;
      add_fields(value.elements[i], single ? path : path + open + std::to_string(i + 1) + close, &scope);
    }
  }

  void add_numbers(const MatlabValue& value, const std::string& path, const std::string& name, const Place& place) {
    if (value.real.size() <= 1 || is_time(name, value)) return;
    if (value.imaginary.size() > 0) return add_functions(value, path, name, place);
    const auto is_complex = [](const std::string&, const MatlabValue& each) { return each.imaginary.size() > 0; };
    if (is_vector(value) && is_exact_frequency_name(name) && place.scope.find(is_complex) != nullptr) return;
    paths_[&value] = path;
    const auto* times = place.scope.find([&](const std::string& each, const MatlabValue& candidate) {
      return is_time(each, candidate) &&
             (candidate.real.size() == value.real.rows() || candidate.real.size() == value.real.cols());
    });
    const bool turned = is_turned(value, times, path, place.units);
    const Index columns = turned ? value.real.rows() : value.real.cols();
    if (columns > most_columns) return skip(path, "a matrix of " + lengths_in_words(value));
    VectorXd stamps;
    if (times != nullptr)
      stamps = seconds_in(unit_in_time_name(times->name)).value_or(1.0) * as_vector(times->value->real);
    add_columns(value.real, turned, std::move(stamps), {path, name}, place);
  }

  /// Whether the rows of a matrix are its channels: the times say it, or the number of units, otherwise its shape.
  bool is_turned(const MatlabValue& value, const NamedValue* times, const std::string& path, const SeriesUnits& units) {
    const Index rows = value.real.rows(), columns = value.real.cols();
    if (times != nullptr) return times->value->real.size() != rows;
    const auto listed = units.series() == 1 ? static_cast<Index>(units.listed()) : 0;
    if (listed == columns && listed != rows) return false;
    if (rows < columns && rows > 1 && listed != rows)
      file_.notes.push_back(
          "'" + path + "' has " + std::to_string(rows) + " rows and " + std::to_string(columns) +
          " columns: each row is taken as a channel of " + std::to_string(columns) +
          " samples; if its columns are the channels, store a vector of times t beside it, or turn it");
    return rows < columns;
  }

  /// Where a series stands, and the name of its field.
  struct Series {
    const std::string& path;
    const std::string& name;
  };

  void add_columns(const MatrixXd& values, bool turned, VectorXd times, const Series& series, const Place& place) {
    const auto column = [&](Index j) -> VectorXd {
      if (turned) return values.row(j).transpose();
      return values.col(j);
    };
    const Index count = turned ? values.rows() : values.cols();
    const auto rate = place.scope.number(rate_names), interval = place.scope.number(interval_names);
    Index first = 0;
    if (times.size() == 0 && !rate && !interval && count > 1 && even_times(column(0))) {
      times = column(first++);
      file_.notes.push_back("the first column of '" + series.path + "' increases evenly: it is taken as time");
    }
    note(place.units.note(series.name, count - first));
    const std::string title = place.units.series() > 1 ? "" : place.scope.text(title_names);
    for (Index j = first; j < count; ++j) {
      MeasuredChannel channel{.name = count == 1 ? series.path : series.path + "_" + std::to_string(j + 1),
                              .unit = unit_of(series, place, {j, first, count})};
      if (!title.empty() && count == 1) name_by(channel, title);
      if (times.size() > 0)
        set_times(channel, times);
      else
        set_axis(channel, rate, interval, place.scope);
      channel.values = column(j);
      file_.channels.push_back(std::move(channel));
    }
  }

  /// A column of a series, of which the first ones may be times.
  struct Column {
    Index number, first, count;
  };

  /// A list of units may name the time's too.
  static std::string unit_of(const Series& series, const Place& place, const Column& column) {
    if (static_cast<Index>(place.units.listed()) == column.count)
      return place.units.unit_of(series.name, column.number, column.count);
    return place.units.unit_of(series.name, column.number - column.first, column.count - column.first);
  }

  void note(std::string words) {
    if (!words.empty() && std::ranges::find(file_.notes, words) == file_.notes.end())
      file_.notes.push_back(std::move(words));
  }

  /// A title names the channel where no other has it; the path is kept as its description.
  void name_by(MeasuredChannel& channel, const std::string& title) const {
    const Channel apart = channel_of(title);
    if (std::ranges::any_of(file_.channels, [&](const auto& each) { return each.name == apart.name; })) return;
    channel.description = channel.name;
    channel.name = apart.name;
    if (channel.unit.empty()) channel.unit = apart.unit;
  }

  static void set_axis(MeasuredChannel& channel, std::optional<double> rate, std::optional<double> interval,
                       const Scope& scope) {
    channel.start = scope.number(start_names).value_or(0.0);
    if (rate && *rate > 0.0)
      channel.interval = 1.0 / *rate;
    else if (interval && *interval > 0.0)
      channel.interval = *interval;
  }

  /// Complex arrays: lines x functions or functions x lines, with lines first or last in arrays of more dimensions.
  void add_functions(const MatlabValue& value, const std::string& path, const std::string& name, const Place& place) {
    std::vector<Index> lengths = value.lengths;
    if (lengths.empty()) lengths = {value.real.rows(), value.real.cols()};
    const auto axis = frequencies_for(lengths, place.scope);
    if (!axis)
      return skip(path,
                  "complex (" + lengths_in_words(value) + "), without a vector of frequencies of one of its lengths");
    if (axis->source != nullptr) axes_.insert(axis->source);
    note(axis->note);
    const Index count = axis->lines.size();
    Eigen::MatrixXcd columns(value.real.rows(), value.real.cols());
    columns.real() = value.real;
    columns.imag() = value.imaginary;
    if (count != lengths.front()) {
      columns.resize(value.real.size() / count, count);
      columns.transposeInPlace();
      lengths.pop_back();
    } else {
      lengths.erase(lengths.begin());
    }
    note(place.units.note(name, columns.cols()));
    for (Index j = 0; j < columns.cols(); ++j)
      file_.functions.push_back({.name = path + numbered(j, lengths),
                                 .unit = place.units.unit_of(name, j, columns.cols()),
                                 .lines = axis->lines,
                                 .values = columns.col(j)});
  }

  /// "_2", or "_2_1" of response 2 and reference 1; nothing for a single one.
  static std::string numbered(Index place, const std::vector<Index>& lengths) {
    std::string ending;
    for (const Index length : lengths) {
      if (length > 1 || lengths.size() > 1) ending += "_" + std::to_string(place % length + 1);
      place /= length;
    }
    return ending;
  }

  MeasuredFile& file_;
  std::set<const MatlabValue*> axes_;                     ///< vectors that are frequencies of functions
  std::map<const MatlabValue*, std::string> paths_ = {};  ///< of the channels' values
};

}  // namespace

bool begins_matlab(std::string_view head) {
  return head.starts_with("MATLAB 5.0 MAT") || head.starts_with("MATLAB 7.3 MAT");
}

MeasuredFile read_matlab_file(const std::filesystem::path& path, const MeasuredFileOptions& options) {
  UnpackedBudget budget(path, options);
  auto contents = read_matlab_values(path, budget);
  MeasuredFile file{.format = "MATLAB file", .skipped = std::move(contents.skipped)};
  Channels channels(file);
  channels.add_fields(contents.variables, "", nullptr);
  channels.finish();
  if (file.channels.empty() && file.functions.empty())
    throw InvalidInput(
        Issue{{path.string(), 0},
              "the MATLAB file holds no series of numbers",
              file.skipped.empty() ? "it has no vectors or matrices of real numbers" : file.skipped.front(),
              "save the channels as vectors, or one a column of a matrix"});
  return file;
}

}  // namespace kalfem
