// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/hdf5/measured_hdf5.hpp"

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/formats/tables/text_table.hpp"
#include "kalfem/records/time_stamps.hpp"

namespace kalfem {

using Eigen::Index;

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

/// "/run/a" and "/run" and "/": an object and the groups around it.
std::vector<std::string> with_groups_around(const std::string& dataset) {
  std::vector<std::string> objects{dataset};
  for (std::size_t slash = dataset.rfind('/'); slash != std::string::npos && slash > 0;
       slash = dataset.rfind('/', slash - 1))
    objects.push_back(dataset.substr(0, slash));
  objects.emplace_back("/");
  return objects;
}

/// An attribute of one number, or nothing.
std::optional<double> single_number(const Hdf5File& file, const std::string& object, const char* name) {
  if (!file.has_attribute(object, name)) return std::nullopt;
  try {
    const auto values = file.numbers_attribute(object, name);
    return values.size() == 1 ? std::optional(values[0]) : std::nullopt;
  } catch (const InvalidInput&) {
    return std::nullopt;  // a text
  }
}

std::optional<double> number_beside(const Hdf5File& file, const std::string& dataset,
                                    std::initializer_list<const char*> names) {
  const std::string group = dataset.substr(0, dataset.rfind('/'));
  for (const char* name : names) {
    const std::string beside = group + "/" + name;
    if (file.contains(beside) && file.holds_numbers(beside) && is_one_number(file.shape(beside)))
      return file.read(beside)[0];
  }
  for (const auto& object : with_groups_around(dataset))
    for (const char* name : names)
      if (const auto number = single_number(file, object, name)) return number;
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

/// Number of units that a dataset states; 0 where it states none.
Index unit_count(const Hdf5File& file, const std::string& dataset) {
  for (const char* name : {"unit", "units"})
    if (file.has_attribute(dataset, name)) return std::ssize(file.texts_attribute(dataset, name));
  return 0;
}

class Hdf5Reader {
public:
  Hdf5Reader(const std::filesystem::path& path, const MeasuredFileOptions& options)
      : path_(path.string()), file_(Hdf5File::open(path_)), budget_(path, options) {}

  MeasuredFile read() {
    for (const auto& dataset : file_.datasets()) {
      if (file_.lies_elsewhere(dataset))
        skip(dataset, "lies in another file");
      else if (const auto members = file_.members(dataset); !members.empty())
        add_records(dataset, members);
      else
        add_numbers(dataset);
    }
    std::erase_if(measured_.channels, [&](const auto& channel) { return times_of_others_.contains(channel.name); });
    if (measured_.channels.empty())
      throw InvalidInput(Issue{{path_, 0},
                               "the HDF5 file holds no table of numbers",
                               measured_.skipped.empty() ? "" : measured_.skipped.front(),
                               "write the channels as one dataset, samples x channels"});
    return std::move(measured_);
  }

private:
  void skip(const std::string& dataset, const std::string& why) {
    measured_.skipped.push_back("dataset '" + dataset + "' " + why);
  }

  [[nodiscard]] double interval_of(const std::string& dataset) const {
    const auto rate = number_beside(file_, dataset, {"sample_rate", "sampling_rate", "fs_Hz", "fs", "sample_rate_Hz"});
    return rate && *rate > 0.0 ? 1.0 / *rate : number_beside(file_, dataset, {"dt", "time_step"}).value_or(0.0);
  }

  void add_numbers(const std::string& dataset) {
    const auto shape = file_.shape(dataset);
    if (file_.holds_numbers(dataset) && is_one_number(shape)) return;
    if (!file_.holds_numbers(dataset) || shape.empty() || shape.size() > 2)
      return skip(dataset, "is no table of numbers");
    if (!file_.is_complete(dataset)) return skip(dataset, "is damaged: a part of its values is not in the file");
    const Index rows = shape[0], columns = shape.size() == 2 ? shape[1] : 1;
    if (!fits(dataset, rows * columns)) return;
    const auto [times, turned] = times_and_turn(dataset, rows, columns);
    if (!times.empty()) times_of_others_.insert(times);
    const Index count = turned ? rows : columns, samples = turned ? columns : rows,
                first = std::ssize(measured_.channels);
    const Eigen::VectorXd stamps = times.empty() ? Eigen::VectorXd() : file_.read(times);
    const double interval = interval_of(dataset);
    for (Index j = 0; j < count; ++j) {
      const std::string column = count == 1 ? "" : "[" + std::to_string(j) + "]";
      MeasuredChannel channel{.name = dataset + column,
                              .unit = unit_of(file_, dataset, j),
                              .interval = interval,
                              .values = {},
                              .other_names = {dataset.substr(dataset.rfind('/') + 1) + column}};
      if (!times.empty()) set_times(channel, stamps);
      if (budget_.wants(dataset)) channel.values.resize(samples);
      measured_.channels.push_back(std::move(channel));
    }
    if (budget_.wants(dataset)) read_values(dataset, turned, first);
  }

  /// Whether a dataset may be read; says so where not.
  bool fits(const std::string& dataset, Index values) {
    const auto bytes = static_cast<std::uintmax_t>(values) * sizeof(double);
    if (!budget_.wants(dataset) || budget_.take(dataset, bytes)) return true;
    skip(dataset, budget_.refusal(bytes));
    return false;
  }

  /// The dataset of times beside a table, and whether the table's rows are its channels: times say it, then the number
  /// of units, then the shape.
  std::pair<std::string, bool> times_and_turn(const std::string& dataset, Index rows, Index columns) {
    if (auto times = times_beside(file_, dataset, rows); !times.empty()) return {std::move(times), false};
    if (auto times = times_beside(file_, dataset, columns); !times.empty()) return {std::move(times), true};
    const Index units = unit_count(file_, dataset);
    if (columns <= rows || (units == columns && units != rows)) return {"", false};
    if (rows > 1 && units != rows && budget_.wants(dataset))
      measured_.notes.push_back("dataset '" + dataset + "' has " + std::to_string(rows) + " rows and " +
                                std::to_string(columns) + " columns: each row is taken as a channel of " +
                                std::to_string(columns) +
                                " samples; if its columns are the channels, store their times t beside it, or turn it");
    return {"", true};
  }

  /// Into the channels from `first` on, which have room.
  void read_values(const std::string& dataset, bool turned, Index first) {
    file_.read_blocks(dataset, [&](Index row, Index column, const Eigen::MatrixXd& block) {
      for (Index j = 0; j < (turned ? block.cols() : block.rows()); ++j) {
        auto& values = measured_.channels[static_cast<std::size_t>(first + j + (turned ? row : column))].values;
        if (turned)
          values.segment(column, block.rows()) = block.col(j);
        else
          values.segment(row, block.cols()) = block.row(j).transpose();
      }
    });
  }

  /// A table of records: its members are channels, one of which may hold their times.
  void add_records(const std::string& dataset, const std::vector<std::string>& members) {
    if (!file_.is_complete(dataset)) return skip(dataset, "is damaged: a part of its values is not in the file");
    if (!fits(dataset, file_.shape(dataset).at(0) * std::ssize(members))) return;
    std::optional<Eigen::VectorXd> times;
    std::string time_member;
    for (const auto& member : members)
      if (!times && may_be_time_name(member))
        if (auto values = file_.read_member(dataset, member); increases(values)) {
          times = std::move(values);
          time_member = member;
        }
    const double interval = interval_of(dataset);
    for (const auto& member : members) {
      if (member == time_member) continue;
      MeasuredChannel channel{.name = dataset + "/" + member, .interval = interval, .other_names = {member}};
      if (budget_.wants(dataset) || budget_.wants(member)) channel.values = file_.read_member(dataset, member);
      if (times && may_be_time_name(member) && channel.values == *times) continue;
      if (times) set_times(channel, *times);
      measured_.channels.push_back(std::move(channel));
    }
  }

  std::string path_;
  Hdf5File file_;
  UnpackedBudget budget_;
  MeasuredFile measured_{.format = "HDF5 file"};
  std::set<std::string> times_of_others_;
};

}  // namespace

MeasuredFile read_measured_hdf5(const std::filesystem::path& path, const MeasuredFileOptions& options) {
  return Hdf5Reader(path, options).read();
}

}  // namespace kalfem
