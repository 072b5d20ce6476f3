// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/stated_times.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kalfem/base/units.hpp"
#include "kalfem/records/time_stamps.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double gap = 1.5;              ///< usual intervals
constexpr double coarsest = 0.2;         ///< unit of the stamps' last decimal, in usual intervals
constexpr Index fewest = 5;              ///< stamps that tell a usual interval
constexpr double restart = 0.5;          ///< of the span: a time that falls by more starts again
constexpr double rate_agreement = 0.01;  ///< relative, of jittering stamps and a rate that is given

/// Samples that stand behind a later one.
Index displaced(const VectorXd& stamps) {
  Index count = 0;
  for (Index k = 1; k < stamps.size(); ++k) count += stamps[k] < stamps[k - 1] ? 1 : 0;
  return count;
}

/// Whether rounding may have moved the stamps by more than a tenth of an interval. Whole units were not rounded.
bool is_rounded_off(const VectorXd& stamps, double usual) {
  const double unit = resolution(stamps);
  if (unit <= (1.0 + 1e-9) * coarsest * usual) return false;
  const double units = usual / unit;
  return std::round(units) < 1.0 || std::abs(units - std::round(units)) > 1e-6;
}

/// Whether stamps in ascending order can be the times of samples, each of its own.
bool are_times(const VectorXd& stamps, const TimeAxisOptions& options, bool missing) {
  const double usual = typical_interval(stamps);
  if (!(usual > 0.0) || is_rounded_off(stamps, usual)) return false;
  if (options.sample_rate && std::abs(usual * *options.sample_rate - 1.0) > rate_agreement) return false;
  const VectorXd intervals = stamps.tail(stamps.size() - 1) - stamps.head(stamps.size() - 1);
  return intervals.minCoeff() > 0.0 && (missing || intervals.maxCoeff() <= gap * usual);
}

bool starts_again(const VectorXd& stamps, const VectorXd& ordered) {
  const double span = ordered[ordered.size() - 1] - ordered[0];
  for (Index k = 1; k < stamps.size(); ++k)
    if (stamps[k - 1] - stamps[k] > restart * span) return true;
  return false;
}

std::vector<int> in_order(const std::vector<int>& lines, const std::vector<Index>& order) {
  std::vector<int> ordered;
  for (const Index k : order) ordered.push_back(lines[static_cast<std::size_t>(k)]);
  return ordered;
}

}  // namespace

StatedTimes stated_times(const VectorXd& stamps, const std::vector<int>& lines, const TimeAxisOptions& options,
                         bool missing, FileProblems& problems, std::vector<std::string>* notes) {
  StatedTimes stated{.times = {.count = stamps.size()}, .order = {}};
  const Index back = displaced(stamps);
  const bool sorts = stamps.allFinite() && stamps.size() > 2 && back > 0;
  VectorXd sorted_stamps;
  std::vector<int> sorted_lines;
  if (sorts) {
    stated.order.resize(static_cast<std::size_t>(stamps.size()));
    std::iota(stated.order.begin(), stated.order.end(), Index{0});
    std::ranges::stable_sort(stated.order, {}, [&](Index k) { return stamps[k]; });
    sorted_stamps = stamps(stated.order);
    sorted_lines = in_order(lines, stated.order);
    if (starts_again(stamps, sorted_stamps)) {
      time_axis(stamps, lines, options, problems);
      return stated;
    }
  }
  const VectorXd& ordered = sorts ? sorted_stamps : stamps;
  const std::vector<int>& own_lines = sorts ? sorted_lines : lines;
  FileProblems as_even(problems.file());
  const TimeAxis axis = time_axis(ordered, own_lines, options, as_even);
  if (as_even.empty()) {
    stated.times.start = axis.start;
    stated.times.interval = 1.0 / axis.sample_rate;
  } else if (stamps.size() >= fewest && ordered.allFinite() && are_times(ordered, options, missing)) {
    stated.times.start = ordered[0];
    stated.times.times = ordered;
  } else {
    time_axis(ordered, own_lines, options, problems);
    return stated;
  }
  if (sorts && notes != nullptr)
    notes->push_back(problems.file() + ": the samples of '" + options.column +
                     "' are sorted by time, which runs back " + std::to_string(back) +
                     (back == 1 ? " time" : " times") + ", first at line " +
                     std::to_string(lines[static_cast<std::size_t>(
                         std::ranges::adjacent_find(stamps, std::greater<>()) - stamps.begin() + 1)]));
  return stated;
}

}  // namespace kalfem
