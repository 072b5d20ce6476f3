// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tables/lvm_segments.hpp"

#include "kalfem/records/time_stamps.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

VectorXd stamps_of(const LvmChannel& each) {
  if (each.stamps.size() > 0) return each.stamps;
  const Index count = each.channel.values.size();
  return VectorXd::LinSpaced(count, each.channel.start, each.channel.start + each.channel.interval * double(count - 1));
}

/// Whether the segment holds the same channels, each behind the end of the one before.
bool goes_on(const std::vector<LvmChannel>& before, const std::vector<LvmChannel>& segment) {
  if (before.size() != segment.size()) return false;
  for (std::size_t j = 0; j < segment.size(); ++j) {
    const auto &a = before[j].channel, &b = segment[j].channel;
    if (a.name != b.name || a.unit != b.unit || a.values.size() == 0 || b.values.size() == 0) return false;
    const VectorXd ends = stamps_of(before[j]).tail(1), starts = stamps_of(segment[j]).head(1);
    if (!(starts[0] > ends[0])) return false;
  }
  return true;
}

VectorXd joined(const VectorXd& a, const VectorXd& b) {
  VectorXd both(a.size() + b.size());
  both << a, b;
  return both;
}

void append(std::vector<LvmChannel>& to, const std::vector<LvmChannel>& segment) {
  for (std::size_t j = 0; j < to.size(); ++j) {
    to[j].stamps = joined(stamps_of(to[j]), stamps_of(segment[j]));
    to[j].channel.values = joined(to[j].channel.values, segment[j].channel.values);
    to[j].lines.insert(to[j].lines.end(), segment[j].lines.begin(), segment[j].lines.end());
    set_times(to[j].channel, to[j].stamps);
  }
}

/// The channels of all segments; those that go on are joined, the others numbered.
std::vector<LvmChannel> all_channels(std::vector<std::vector<LvmChannel>> segments) {
  std::vector<std::vector<LvmChannel>> parts;
  for (auto& segment : segments) {
    if (!parts.empty() && goes_on(parts.back(), segment))
      append(parts.back(), segment);
    else
      parts.push_back(std::move(segment));
  }
  std::vector<LvmChannel> all;
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (auto& each : parts[i]) {
      if (parts.size() > 1) each.channel.name += " (segment " + std::to_string(i + 1) + ")";
      all.push_back(std::move(each));
    }
  return all;
}

MeasuredFunction function_of(const LvmChannel& each) {
  MeasuredFunction function{.name = each.channel.name, .unit = each.channel.unit, .lines = stamps_of(each)};
  function.values = each.channel.values.cast<std::complex<double>>();
  return function;
}

}  // namespace

void add_segments(std::vector<std::vector<LvmChannel>> segments, MeasuredFile& file) {
  for (auto& each : all_channels(std::move(segments))) {
    if (each.of_frequency)
      file.functions.push_back(function_of(each));
    else
      file.channels.push_back(std::move(each.channel));
  }
}

}  // namespace kalfem
