// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/record.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/units.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

std::vector<std::string> names_of(const Record& record) {
  std::vector<std::string> names;
  for (const auto& channel : record.channels) names.push_back(channel.name);
  return names;
}

}  // namespace

Index Record::find(const std::string& name) const {
  const auto found = std::ranges::find(channels, name, &Channel::name);
  return found == channels.end() ? -1 : static_cast<Index>(found - channels.begin());
}

VectorXd Record::noise() const {
  VectorXd deviations(static_cast<Index>(channels.size()));
  std::ranges::transform(channels, deviations.begin(), &Channel::noise);
  return deviations;
}

Record make_record(double sample_rate, const std::vector<std::pair<std::string, VectorXd>>& channels, double start) {
  Record record{.sample_rate = sample_rate, .start = start};
  const Index samples = channels.empty() ? 0 : channels.front().second.size();
  record.values.resize(static_cast<Index>(channels.size()), samples);
  IssueList issues;
  for (const auto& [name, series] : channels) {
    if (series.size() == samples)
      record.values.row(static_cast<Index>(record.channels.size())) = series.transpose();
    else
      issues.add({}, "channel '" + name + "' has " + std::to_string(series.size()) + " samples",
                 "'" + channels.front().first + "' has " + std::to_string(samples),
                 "give every channel as many samples; write NaN where one is missing");
    record.channels.push_back({name});
  }
  issues.raise();
  return record;
}

Record select_channels(const Record& record, const std::vector<std::string>& names) {
  std::vector<Index> rows;
  IssueList issues;
  for (const auto& name : names) {
    rows.push_back(record.find(name));
    if (rows.back() < 0)
      issues.add({}, "the record has no channel '" + name + "'" + did_you_mean(name, names_of(record)), "",
                 "name one of its own");
  }
  issues.raise();
  Record selected{record.sample_rate, record.start, {}, record.values(rows, Eigen::all), record.used};
  for (const Index row : rows) selected.channels.push_back(record.channels[static_cast<std::size_t>(row)]);
  return selected;
}

// Keeps the samples k with from <= start + k / rate <= to. Times in a case file are rounded decimals: a sample within
// 1e-6 of an interval beyond either limit still belongs to the part. The count of samples that a filter learns from
// moves with the first sample.
Record cut(Record record, double from, double to) {
  constexpr double rounding = 1e-6;  // of an interval, in the times that are given
  const double first_time = (from - record.start) * record.sample_rate,
               last_time = (to - record.start) * record.sample_rate;
  const auto first = std::max<Index>(0, static_cast<Index>(std::ceil(first_time - rounding)));
  const auto last = std::min(record.samples() - 1, static_cast<Index>(std::floor(last_time + rounding)));
  if (last <= first)
    throw InvalidInput("the record has no samples between " + shortest(from) + " s and " + shortest(to) + " s",
                       "the record runs from " + shortest(record.start) + " s to " + shortest(record.end()) + " s",
                       "choose a part of it");
  if (first == 0 && last + 1 == record.samples()) return record;
  const Index count = last - first + 1;
  record.start = record.time(first);
  record.values = record.values.middleCols(first, count).eval();
  if (record.used) record.used = std::clamp<Index>(*record.used - first, 0, count);
  return record;
}

double rms(const Eigen::Ref<const VectorXd>& signal) {
  return signal.size() == 0 ? 0.0 : signal.norm() / std::sqrt(static_cast<double>(signal.size()));
}

double rms_of_present(const Eigen::Ref<const VectorXd>& channel) {
  const auto present = channel.array().isFinite();
  const double count = std::max(1.0, static_cast<double>(present.count()));
  return std::sqrt(present.select(channel, 0.0).squaredNorm() / count);
}

double nrmse(const Eigen::Ref<const VectorXd>& estimate, const Eigen::Ref<const VectorXd>& reference) {
  const double error = rms(estimate - reference), scale = rms(reference);
  if (scale > 0.0) return error / scale;
  return error == 0.0 ? 0.0 : std::numeric_limits<double>::infinity();
}

}  // namespace kalfem
