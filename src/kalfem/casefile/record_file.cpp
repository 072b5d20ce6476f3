#include "kalfem/casefile/record_file.hpp"

#include <algorithm>
#include <charconv>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/csv.hpp"
#include "kalfem/formats/hdf5_file.hpp"
#include "kalfem/formats/lvm.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// Channels of a table in the order asked for.
TimeSeries select(const TimeSeries& table, const std::vector<std::string>& channels, const std::string& file) {
  TimeSeries selected{
      table.sample_rate, table.start, {}, Eigen::MatrixXd(table.samples(), static_cast<Index>(channels.size()))};
  std::vector<std::string> known;
  for (const auto& channel : table.channels) known.push_back(channel.name);
  IssueList issues;
  for (std::size_t j = 0; j < channels.size(); ++j) {
    const Index column = table.find(channels[j]);
    if (column < 0) {
      std::string all;
      for (const auto& name : known) all += (all.empty() ? "" : ", ") + name;
      issues.add({file, 0}, "there is no channel '" + channels[j] + "'" + did_you_mean(channels[j], known), "",
                 "the file has: " + all);
      continue;
    }
    selected.channels.push_back(table.channels[static_cast<std::size_t>(column)]);
    selected.values.col(static_cast<Index>(j)) = table.values.col(column);
  }
  issues.raise();
  return selected;
}

double rate_of(const Hdf5File& file, const std::string& dataset, std::optional<double> given, const std::string& path) {
  if (given) return *given;
  for (const char* name : {"sample_rate", "sampling_rate", "fs_Hz", "fs", "sample_rate_Hz"})
    if (file.has_attribute(dataset, name)) return file.number_attribute(dataset, name);
  throw InvalidInput({{path, 0},
                      "the dataset '" + dataset + "' does not say its sampling rate",
                      "it has no attribute sample_rate, fs or fs_Hz",
                      "give sample_rate in the case"});
}

/// Column by its number, as written in the case.
Index column_number(const std::string& channel, Index columns, const std::string& path) {
  Index number = -1;
  const auto [end, error] = std::from_chars(channel.data(), channel.data() + channel.size(), number);
  if (error != std::errc() || end != channel.data() + channel.size() || number < 0 || number >= columns)
    throw InvalidInput({{path, 0},
                        "there is no column '" + channel + "'",
                        "columns of a dataset are numbered 0 to " + std::to_string(columns - 1),
                        "give such a number"});
  return number;
}

TimeSeries read_hdf5(const std::string& path, const std::vector<std::string>& channels,
                     std::optional<double> sample_rate, const std::string& dataset) {
  const auto file = Hdf5File::open(path);
  if (!file.contains(dataset) || dataset.empty()) {
    const auto known = file.datasets();
    std::string all;
    for (std::size_t i = 0; i < std::min<std::size_t>(known.size(), 12); ++i) all += (i ? ", " : "") + known[i];
    throw InvalidInput({{path, 0},
                        "there is no dataset '" + dataset + "'" + did_you_mean(dataset, known),
                        "",
                        "the file has: " + all});
  }
  const auto values = file.read_matrix(dataset);
  TimeSeries series{rate_of(file, dataset, sample_rate, path),
                    0.0,
                    {},
                    Eigen::MatrixXd(values.rows(), static_cast<Index>(channels.size()))};
  for (std::size_t j = 0; j < channels.size(); ++j) {
    series.channels.push_back({channels[j], ""});
    series.values.col(static_cast<Index>(j)) = values.col(column_number(channels[j], values.cols(), path));
  }
  return series;
}

}  // namespace

TimeSeries read_record_file(const std::filesystem::path& file, const std::vector<std::string>& channels,
                            std::optional<double> sample_rate, const std::string& dataset) {
  const std::string path = file.string(), ending = file.extension().string();
  if (ending == ".h5" || ending == ".hdf5") return read_hdf5(path, channels, sample_rate, dataset);
  if (ending == ".lvm") return select(read_lvm(file), channels, path);
  CsvOptions options;
  options.columns = channels;
  options.sample_rate = sample_rate;
  return select(read_csv(file, options), channels, path);
}

}  // namespace kalfem
