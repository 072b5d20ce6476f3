#include "kalfem/formats/matlab/matlab_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"
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

template <std::size_t count>
bool is_one_of(std::string_view name, const std::array<std::string_view, count>& names) {
  return std::ranges::find(names, lower_case(name)) != names.end();
}

constexpr std::array<std::string_view, 9> rate_names = {
    "fs", "sample_rate", "samplerate", "sampling_rate", "samplingrate", "fsamp", "fs_hz", "rate", "sampling_frequency"};
constexpr std::array<std::string_view, 8> interval_names = {"dt",      "ts",  "delta_t",   "deltat",
                                                            "delta_x", "t_s", "increment", "interval"};
constexpr std::array<std::string_view, 6> start_names = {"t0", "start_value", "start", "x0", "start_time", "tstart"};
constexpr std::array<std::string_view, 6> frequency_names = {"f",           "freq",    "frequency",
                                                             "frequencies", "freq_hz", "f_hz"};
constexpr std::array<std::string_view, 4> title_names = {"name", "label", "title", "channel"};
constexpr std::array<std::string_view, 4> unit_names = {"unit", "units", "y_unit", "unit_string"};

bool is_vector(const MatlabValue& value) {
  return value.kind == Kind::numbers && (value.real.rows() == 1 || value.real.cols() == 1) && value.real.size() > 1;
}

VectorXd as_vector(const MatrixXd& values) { return VectorXd::Map(values.data(), values.size()); }

bool is_time(const std::string& name, const MatlabValue& value) {
  if (!is_vector(value) || value.imaginary.size() > 0) return false;
  return is_time_name(name) || is_one_of(name, std::array<std::string_view, 3>{"times", "timestamps", "tvec"}) ||
         (may_be_time_name(name) && increases(as_vector(value.real)));
}

/// A field that is not copied: it may be large.
struct NamedValue {
  std::string name;
  const MatlabValue* value = nullptr;
};

/// The fields around a series, innermost first: what states its times.
class Scope {
public:
  explicit Scope(const std::vector<NamedValue>& fields, const Scope* around = nullptr)
      : fields_(fields), around_(around) {}

  template <class Test>
  [[nodiscard]] const MatlabValue* find(const Test& test) const {
    const NamedValue* found = find_named(test);
    return found == nullptr ? nullptr : found->value;
  }

  template <class Test>
  [[nodiscard]] const NamedValue* find_named(const Test& test) const {
    for (const auto& field : fields_)
      if (test(field.name, *field.value)) return &field;
    return around_ == nullptr ? nullptr : around_->find_named(test);
  }

  template <std::size_t count>
  [[nodiscard]] std::optional<double> number(const std::array<std::string_view, count>& names) const {
    const auto* value = find([&](const std::string& name, const MatlabValue& each) {
      return each.kind == Kind::numbers && each.real.size() == 1 && is_one_of(name, names);
    });
    return value == nullptr || !std::isfinite(value->real(0)) ? std::nullopt : std::optional(value->real(0));
  }

  /// Of the same structure only.
  template <std::size_t count>
  [[nodiscard]] std::string text(const std::array<std::string_view, count>& names) const {
    for (const auto& [name, value] : fields_)
      if (value->kind == Kind::text && is_one_of(name, names)) return value->text;
    return "";
  }

private:
  const std::vector<NamedValue>& fields_;
  const Scope* around_;
};

/// With axes that stand in a structure of their own beside the values: x_values of Testlab, X of dSPACE.
std::vector<NamedValue> with_axis_fields(const Fields& fields) {
  std::vector<NamedValue> all;
  for (const auto& [name, value] : fields) all.push_back({name, &value});
  for (const auto& [name, value] : fields) {
    if (value.kind != Kind::structure || value.elements.size() != 1) continue;
    const bool axis = is_one_of(name, std::array<std::string_view, 3>{"x_values", "x", "xdata"});
    for (const auto& [inner, part] : value.elements.front()) {
      const bool values = is_vector(part) && is_one_of(inner, std::array<std::string_view, 2>{"data", "values"});
      if (axis) all.push_back({values ? "time" : inner, &part});
    }
  }
  return all;
}

class Channels {
public:
  explicit Channels(MeasuredFile& file) : file_(file) {}

  void add_fields(const Fields& given, const std::string& prefix, const Scope* around) {
    const std::vector<NamedValue> fields = with_axis_fields(given);
    const Scope scope(fields, around);
    for (const auto& [name, value] : given)
      add(value, prefix.empty() || name.empty() ? prefix + name : prefix + "." + name, name, scope);
  }

private:
  void skip(const std::string& name, const std::string& what) { file_.skipped.push_back("'" + name + "' is " + what); }

  void add(const MatlabValue& value, const std::string& path, const std::string& name, const Scope& scope) {
    switch (value.kind) {
      case Kind::numbers:
        return add_numbers(value, path, name, scope);
      case Kind::structure:
      case Kind::cells:
        return add_elements(value, path, scope);
      case Kind::text:
        if (!is_one_of(name, title_names) && !is_one_of(name, unit_names)) skip(path, "text");
        return;
      case Kind::other:
        return skip(path, value.what);
    }
  }

  void add_elements(const MatlabValue& value, const std::string& path, const Scope& scope) {
    const char open = value.kind == Kind::cells ? '{' : '(', close = value.kind == Kind::cells ? '}' : ')';
    for (std::size_t i = 0; i < value.elements.size(); ++i) {
      const bool single = value.elements.size() == 1 && value.kind == Kind::structure;
      add_fields(value.elements[i], single ? path : path + open + std::to_string(i + 1) + close, &scope);
    }
  }

  void add_numbers(const MatlabValue& value, const std::string& path, const std::string& name, const Scope& scope) {
    if (value.real.size() <= 1 || is_time(name, value)) return;
    if (value.imaginary.size() > 0) return add_functions(value, path, scope);
    const auto is_complex = [](const std::string&, const MatlabValue& each) { return each.imaginary.size() > 0; };
    if (is_vector(value) && is_one_of(name, frequency_names) && scope.find(is_complex) != nullptr) return;
    const auto* times = scope.find_named([&](const std::string& each, const MatlabValue& candidate) {
      return is_time(each, candidate) &&
             (candidate.real.size() == value.real.rows() || candidate.real.size() == value.real.cols());
    });
    const bool turned =
        times != nullptr ? times->value->real.size() != value.real.rows() : value.real.rows() < value.real.cols();
    const Index columns = turned ? value.real.rows() : value.real.cols();
    if (columns > most_columns)
      return skip(path, "a matrix of " + std::to_string(value.real.rows()) + " x " + std::to_string(value.real.cols()));
    VectorXd stamps;
    if (times != nullptr)
      stamps = seconds_in(unit_in_time_name(times->name)).value_or(1.0) * as_vector(times->value->real);
    add_columns(value.real, turned, std::move(stamps), path, scope);
  }

  void add_columns(const MatrixXd& values, bool turned, VectorXd times, const std::string& path, const Scope& scope) {
    const auto column = [&](Index j) -> VectorXd {
      if (turned) return values.row(j).transpose();
      return values.col(j);
    };
    const Index count = turned ? values.rows() : values.cols();
    const auto rate = scope.number(rate_names), interval = scope.number(interval_names);
    Index first = 0;
    if (times.size() == 0 && !rate && !interval && count > 1 && even_times(column(0))) {
      times = column(first++);
      file_.notes.push_back("the first column of '" + path + "' increases evenly: it is taken as time");
    }
    const std::string title = scope.text(title_names);
    for (Index j = first; j < count; ++j) {
      MeasuredChannel channel{.name = count == 1 ? path : path + "_" + std::to_string(j + 1),
                              .unit = scope.text(unit_names)};
      if (!title.empty() && count == 1) name_by(channel, title);
      if (times.size() > 0)
        set_times(channel, times);
      else
        set_axis(channel, rate, interval, scope);
      channel.values = column(j);
      file_.channels.push_back(std::move(channel));
    }
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

  void add_functions(const MatlabValue& value, const std::string& path, const Scope& scope) {
    const auto* lines = scope.find([&](const std::string& each, const MatlabValue& candidate) {
      return is_vector(candidate) && candidate.imaginary.size() == 0 && is_one_of(each, frequency_names) &&
             (candidate.real.size() == value.real.rows() || candidate.real.size() == value.real.cols());
    });
    if (lines == nullptr) return skip(path, "complex, without a vector of frequencies of its length");
    Eigen::MatrixXcd columns(value.real.rows(), value.real.cols());
    columns.real() = value.real;
    columns.imag() = value.imaginary;
    if (lines->real.size() != columns.rows()) columns.transposeInPlace();
    for (Index j = 0; j < columns.cols(); ++j)
      file_.functions.push_back({.name = columns.cols() == 1 ? path : path + "_" + std::to_string(j + 1),
                                 .unit = scope.text(unit_names),
                                 .lines = as_vector(lines->real),
                                 .values = columns.col(j)});
  }

  MeasuredFile& file_;
};

}  // namespace

bool begins_matlab(std::string_view head) {
  return head.starts_with("MATLAB 5.0 MAT") || head.starts_with("MATLAB 7.3 MAT");
}

MeasuredFile read_matlab_file(const std::filesystem::path& path) {
  auto contents = read_matlab_values(path);
  MeasuredFile file{.format = "MATLAB file", .skipped = std::move(contents.skipped)};
  Channels(file).add_fields(contents.variables, "", nullptr);
  if (file.channels.empty() && file.functions.empty())
    throw InvalidInput(
        Issue{{path.string(), 0},
              "the MATLAB file holds no series of numbers",
              file.skipped.empty() ? "it has no vectors or matrices of real numbers" : file.skipped.front(),
              "save the channels as vectors, or one a column of a matrix"});
  return file;
}

}  // namespace kalfem
