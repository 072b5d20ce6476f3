// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/gap_bridge.hpp"

#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/records/common_grid.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// Without the digits that rounding leaves behind.
std::string seconds(double time) { return shortest(std::round(time * 1e9) / 1e9) + " s"; }

std::vector<Index> present_samples(const Record& record, Index row) {
  std::vector<Index> present;
  for (Index k = 0; k < record.samples(); ++k)
    if (std::isfinite(record.values(row, k))) present.push_back(k);
  return present;
}

/// Adds an issue for everything that the spline must not fill.
void check_gaps(const Record& record, Index row, const std::vector<Index>& present, double longest, IssueList& issues) {
  const std::string channel = "the channel '" + record.channels[static_cast<std::size_t>(row)].name + "'";
  const std::string fix = "use the part of the record where the input was measured, or make the input unknown";
  if (present.size() < 2 || present.front() > 0 || present.back() + 1 < record.samples()) {
    issues.add({}, channel + " has no value at its first or last sample", "a gap is bridged between two samples", fix);
    return;
  }
  for (std::size_t i = 1; i < present.size(); ++i) {
    const double from = record.time(present[i - 1]), length = record.time(present[i]) - from;
    if (present[i] - present[i - 1] > 1 && length > longest * (1.0 + 1e-9))
      issues.add({}, channel + " has a gap of " + seconds(length) + " at " + seconds(from),
                 "the longest gap to be bridged is " + seconds(longest), fix);
  }
}

}  // namespace

void bridge_gaps(PreparedRecord& prepared, double longest) {
  Record& record = prepared.record;
  IssueList issues;
  for (Index row = 0; row < record.values.rows(); ++row)
    check_gaps(record, row, present_samples(record, row), longest, issues);
  issues.raise();
  for (Index row = 0; row < record.values.rows(); ++row) {
    const auto present = present_samples(record, row);
    const auto filled = record.samples() - std::ssize(present);
    if (filled == 0) continue;
    SampleTimes times{.times = Eigen::VectorXd(std::ssize(present)), .count = std::ssize(present)};
    for (Index i = 0; i < times.count; ++i) times.times[i] = record.time(present[static_cast<std::size_t>(i)]);
    const Eigen::VectorXd values = record.values(row, present).transpose();
    const Eigen::VectorXd even = evenly_interpolated(times, values, record.sample_rate);
    for (Index k = 0; k < record.samples(); ++k)
      if (!std::isfinite(record.values(row, k))) record.values(row, k) = even[std::min(k, even.size() - 1)];
    prepared.preparation.push_back(std::to_string(filled) + " missing samples of '" +
                                   record.channels[static_cast<std::size_t>(row)].name + "' bridged by a spline");
  }
}

}  // namespace kalfem
