// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/record_file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/formats/measured_file_reader.hpp"
#include "kalfem/formats/measured_selection.hpp"
#include "kalfem/formats/tables/csv.hpp"
#include "kalfem/formats/tables/measured_table.hpp"
#include "kalfem/formats/tables/text_table.hpp"
#include "kalfem/formats/unit_labels.hpp"

namespace kalfem {

namespace {

constexpr double same_factor = 1e-9;  ///< relative

/// Parses the unit and requires the dimension of the channel's quantity. Throws InvalidInput.
Unit unit_for(const WantedChannel& wanted, const std::string& text) {
  try {
    return parse_unit_as(text, wanted.unit);
  } catch (const InvalidInput&) {
    if (wanted.rotational_unit.empty()) throw;
    const Unit unit = parse_unit(text);
    if (unit.dimension != parse_unit(wanted.rotational_unit).dimension) throw;
    return unit;
  }
}

/// Parses the unit; for another quantity it is returned unchanged, and nothing if it is unknown.
std::optional<Unit> understood(const WantedChannel& wanted, const std::string& text) {
  try {
    return unit_for(wanted, text);
  } catch (const InvalidInput&) {
  }
  try {
    return parse_unit(text);
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
}

bool same_unit(const Unit& a, const Unit& b) {
  return a.dimension == b.dimension && std::abs(a.factor / b.factor - 1.0) < same_factor;
}

std::string place_in_words(const SourceLocation& place) {
  return place.file + (place.line > 0 ? ":" + std::to_string(place.line) : "");
}

// A unit that the case states counts. If the file states another one, the difference is an issue: one of both is
// wrong, and a factor of 1000 would not be seen later.
double factor_of_case(const WantedChannel& wanted, const Channel& in_file, const SourceLocation& title,
                      IssueList& issues) {
  const auto& given = wanted.unit_given;
  const Unit unit = unit_for(wanted, given.value);
  const auto of_file = in_file.unit.empty() ? std::nullopt : understood(wanted, understood_unit(in_file.unit));
  if (of_file && !same_unit(*of_file, unit))
    issues.add(given.location,
               given.path + " is '" + given.value + "', but the column '" + in_file.name + "' (" + wanted.owner +
                   ") is in '" + in_file.unit + "'",
               place_in_words(title) + " states it",
               given.path == wanted.unit_key ? "remove the wrong one" : "remove it, or set " + wanted.unit_key);
  return unit.factor;
}

}  // namespace

// The unit comes from the case, from the title of the column, or is SI. The message names the place to mend.
double factor_to_si(const WantedChannel& wanted, const Channel& in_file, const SourceLocation& title,
                    IssueList& issues) {
  const auto& given = wanted.unit_given;
  try {
    if (!given.value.empty()) return factor_of_case(wanted, in_file, title, issues);
    const std::string unit = understood_unit(in_file.unit);
    return unit.empty() ? 1.0 : unit_for(wanted, unit).factor;
  } catch (const InvalidInput& error) {
    for (const Issue& issue : error.issues()) {
      if (!given.value.empty())
        issues.add(given.location, given.path + ": " + issue.what + " (" + wanted.owner + ")", issue.why,
                   "write a unit such as " + wanted.unit);
      else
        issues.add(title, "column '" + in_file.name + "' (" + wanted.owner + "): " + issue.what, issue.why,
                   understood(wanted, in_file.unit) || wanted.unit_key.empty()
                       ? "choose another column or correct its title"
                       : "state it in " + wanted.unit_key);
    }
    return 1.0;
  }
}

namespace {

using Eigen::Index;

/// A table in the units of its file.
struct RawRecord {
  Record record;
  SourceLocation titles;       ///< where names and units stand
  Eigen::VectorXd times = {};  ///< of the samples [s], where they are uneven
};

std::vector<std::string> columns_of(const std::vector<WantedChannel>& wanted) {
  std::vector<std::string> columns;
  for (const auto& channel : wanted) columns.push_back(channel.column);
  return columns;
}

/// Row of each wanted channel. Throws InvalidInput with every one that the file does not have.
std::vector<Index> rows_of(const std::vector<Channel>& channels, const std::vector<WantedChannel>& wanted,
                           const SourceLocation& titles) {
  std::vector<std::string> known;
  std::string all;
  for (const auto& channel : channels) {
    known.push_back(channel.name);
    all += (all.empty() ? "" : ", ") + channel.name;
  }
  IssueList issues;
  std::vector<Index> rows;
  for (const auto& each : wanted) {
    rows.push_back(find_channel(channels, each.column));
    if (rows.back() < 0)
      issues.add(titles, "there is no channel '" + each.column + "'" + did_you_mean(each.column, known), "",
                 "the file has: " + all);
  }
  issues.raise();
  return rows;
}

/// The rows of these numbers, in their order.
Record with_rows(Record record, const std::vector<Index>& rows) {
  std::vector<Index> all(static_cast<std::size_t>(record.values.rows()));
  std::iota(all.begin(), all.end(), Index{0});
  if (rows == all) return record;
  const auto channels = std::move(record.channels);
  record.channels.clear();
  for (const Index row : rows) record.channels.push_back(channels[static_cast<std::size_t>(row)]);
  record.values = record.values(rows, Eigen::all).eval();
  return record;
}

RawRecord selected(Record record, const std::vector<WantedChannel>& wanted, SourceLocation titles) {
  const auto rows = rows_of(record.channels, wanted, titles);
  return {with_rows(std::move(record), rows), std::move(titles)};
}

double rate_of(const Hdf5File& file, const std::string& dataset, std::optional<double> given, const std::string& path) {
  if (given) return *given;
  for (const char* name : {"sample_rate", "sampling_rate", "fs_Hz", "fs", "sample_rate_Hz"})
    if (file.has_attribute(dataset, name)) return file.number_attribute(dataset, name);
  throw InvalidInput({{path, 0},
                      "the dataset '" + dataset + "' does not state its sampling rate",
                      "it has no attribute sample_rate, fs or fs_Hz",
                      "give its sampling rate (sample_rate)"});
}

/// Column by its number, as it is asked for.
Index column_number(const std::string& channel, Index columns, const std::string& path) {
  Index number = -1;
  const auto [end, error] = std::from_chars(channel.data(), channel.data() + channel.size(), number);
  if (error != std::errc() || end != channel.data() + channel.size() || number < 0 || number >= columns)
    throw InvalidInput({{path, 0},
                        "there is no column '" + channel + "'",
                        "the columns of this dataset are numbered 0 to " + std::to_string(columns - 1),
                        "give one of these numbers"});
  return number;
}

/// Units of a dataset's columns: one for all, one each, or none.
std::vector<std::string> units_of(const Hdf5File& file, const std::string& dataset, Index columns,
                                  const std::string& path) {
  const auto count = static_cast<std::size_t>(columns);
  for (const char* name : {"unit", "units"}) {
    if (!file.has_attribute(dataset, name)) continue;
    auto units = file.texts_attribute(dataset, name);
    if (units.size() == 1) units.resize(count, std::string(units.front()));
    if (units.size() == count) return units;
    throw InvalidInput({{path, 0},
                        "the attribute '" + std::string(name) + "' of '" + dataset + "' holds " +
                            std::to_string(units.size()) + " units",
                        "the dataset has " + std::to_string(columns) + " columns",
                        "write one value for all columns, or one per column"});
  }
  return std::vector<std::string>(count);
}

RawRecord read_hdf5(const std::string& path, const std::vector<WantedChannel>& wanted,
                    const RecordFileOptions& options) {
  const auto file = Hdf5File::open(path);
  const std::string& dataset = options.dataset;
  if (!file.contains(dataset) || dataset.empty()) {
    const auto known = file.datasets();
    std::string all;
    for (std::size_t i = 0; i < std::min<std::size_t>(known.size(), 12); ++i) all += (i ? ", " : "") + known[i];
    throw InvalidInput({{path, 0},
                        "there is no dataset '" + dataset + "'" + did_you_mean(dataset, known),
                        "",
                        "the file has: " + all});
  }
  Record record{.sample_rate = rate_of(file, dataset, options.sample_rate, path)};
  const auto shape = file.shape(dataset);
  const Index columns = shape.size() == 2 ? shape[1] : 1;
  const auto units = units_of(file, dataset, columns, path);
  std::vector<Index> numbers;
  for (const auto& each : wanted) {
    numbers.push_back(column_number(each.column, columns, path));
    record.channels.push_back({each.column, units[static_cast<std::size_t>(numbers.back())]});
  }
  record.values = file.read_columns(dataset, numbers);
  return {std::move(record), {path, 0}};
}

RawRecord read_raw(const std::filesystem::path& file, const std::vector<WantedChannel>& wanted,
                   const RecordFileOptions& options) {
  const std::string path = file.string(), ending = file.extension().string();
  if (ending == ".h5" || ending == ".hdf5") return read_hdf5(path, wanted, options);
  CsvOptions csv;
  csv.columns = columns_of(wanted);
  csv.sample_rate = options.sample_rate;
  csv.missing = options.missing;
  csv.uneven = true;
  csv.notes = options.notes;
  auto [record, title_line, times] = read_csv_record(file, csv);
  RawRecord raw = selected(std::move(record), wanted, {path, title_line});
  raw.times = std::move(times);
  return raw;
}

/// A table of uneven times on the grid that they need. Its values are in SI already.
Record on_grid(const RawRecord& raw, const std::vector<WantedChannel>& wanted, const RecordFileOptions& options,
               const std::filesystem::path& file) {
  MeasuredFile measured{.format = "table of text"};
  std::vector<WantedChannel> in_order;
  for (std::size_t j = 0; j < wanted.size(); ++j) {
    const auto& name = raw.record.channels[j].name;
    if (std::ranges::find(measured.channels, name, &MeasuredChannel::name) == measured.channels.end())
      measured.channels.push_back(
          {.name = name, .times = raw.times, .values = raw.record.values.row(static_cast<Index>(j)).transpose()});
    in_order.push_back({.column = name, .owner = wanted[j].owner, .unit = wanted[j].unit});
  }
  return select_record(measured, in_order, options, file);
}

bool is_hdf5(const std::filesystem::path& file) { return file.extension() == ".h5" || file.extension() == ".hdf5"; }

Record selected_from_all(const std::filesystem::path& file, const std::vector<WantedChannel>& wanted,
                         const RecordFileOptions& options) {
  const MeasuredFile measured = read_measured_file(file, {.channels = columns_of(wanted)});
  if (options.notes != nullptr)
    options.notes->insert(options.notes->end(), measured.notes.begin(), measured.notes.end());
  return select_record(measured, wanted, options, file);
}

}  // namespace

// Files that hold many things are read as a whole, and the channels are chosen from them. Plain tables are read in
// their own units, only the columns that are wanted, and each row is scaled to SI.
Record read_record_file(const std::filesystem::path& file, const std::vector<WantedChannel>& wanted,
                        const RecordFileOptions& options) {
  const bool by_dataset = is_hdf5(file) && !options.dataset.empty();
  if (measured_format(file) != nullptr || (!by_dataset && (is_hdf5(file) || !is_plain_table(file))))
    return selected_from_all(file, wanted, options);
  RawRecord raw = read_raw(file, wanted, options);
  auto& [record, titles, times] = raw;
  IssueList issues;
  Eigen::VectorXd factors(record.values.rows());
  for (std::size_t j = 0; j < wanted.size(); ++j) {
    factors[static_cast<Index>(j)] = factor_to_si(wanted[j], record.channels[j], titles, issues);
    record.channels[j] = {wanted[j].column, wanted[j].unit};
  }
  issues.raise();
  record.values.array().colwise() *= factors.array();
  return times.size() > 0 ? on_grid(raw, wanted, options, file) : std::move(record);
}

}  // namespace kalfem
