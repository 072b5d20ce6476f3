// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/channel_preparation.hpp"

#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/records/resampling.hpp"
#include "kalfem/records/zero_phase_filter.hpp"

namespace kalfem {

using Eigen::ArrayXd;
using Eigen::Index;

namespace {

/// Value with four digits, for the words of a preparation.
std::string in_words(double value) {
  const double unit = value == 0.0 ? 1.0 : std::pow(10.0, std::floor(std::log10(std::abs(value))) - 3.0);
  return shortest(unit < 1.0 ? std::round(value / unit) / std::round(1.0 / unit) : std::round(value / unit) * unit);
}

std::string with_unit(double value, const std::string& unit) {
  return in_words(value) + (unit.empty() ? "" : " " + unit);
}

/// Mean of the finite samples; NaN where there is none.
double mean_of_present(const ArrayXd& values) {
  const auto present = values.isFinite();
  return present.select(values, 0.0).sum() / static_cast<double>(present.count());
}

void subtract_offset(PreparedRecord& prepared, const RecordPart& part) {
  Record& record = prepared.record;
  const double from = part.from.value_or(record.start), to = part.to.value_or(record.end());
  const Record quiet = cut(record, from, to);
  std::string words;
  IssueList issues;
  for (Index j = 0; j < record.values.rows(); ++j) {
    const Channel& channel = record.channels[static_cast<std::size_t>(j)];
    const double offset = mean_of_present(quiet.values.row(j).transpose());
    if (!std::isfinite(offset))
      issues.add({},
                 "channel '" + channel.name + "' has no sample from " + shortest(from) + " s to " + shortest(to) + " s",
                 "its offset is the mean over that part", "choose another part");
    record.values.row(j).array() -= offset;
    words += (j > 0 ? ", " : "") + channel.name + " " + with_unit(offset, channel.unit);
  }
  issues.raise();
  prepared.preparation.push_back("offsets subtracted, means from " + in_words(from) + " s to " + in_words(to) +
                                 " s: " + words);
}

/// Change of a channel's straight line of least squares from the first sample to the last, and subtracts the line.
double subtract_line(Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> samples) {
  const ArrayXd values = samples.transpose().array();
  const ArrayXd time = ArrayXd::LinSpaced(values.size(), -0.5, 0.5);
  const auto present = values.isFinite();
  const double count = static_cast<double>(present.count());
  if (count < 2.0) return 0.0;
  const double middle = present.select(time, 0.0).sum() / count, mean = mean_of_present(values);
  const ArrayXd t = present.select(time - middle, 0.0), y = present.select(values - mean, 0.0);
  const double slope = (t * y).sum() / t.square().sum();
  samples -= (mean + slope * (time - middle)).matrix().transpose();
  return slope;
}

void subtract_trend(PreparedRecord& prepared) {
  Record& record = prepared.record;
  std::string words;
  for (Index j = 0; j < record.values.rows(); ++j) {
    const Channel& channel = record.channels[static_cast<std::size_t>(j)];
    const double drift = subtract_line(record.values.row(j));
    words += (j > 0 ? ", " : "") + channel.name + " " + with_unit(drift, channel.unit);
  }
  prepared.preparation.push_back("straight lines subtracted, from the first sample to the last: " + words);
}

/// One limit of a filter, below half of the sampling rate.
void check_limit(double limit, double sample_rate, const std::string& name) {
  if (limit < 0.5 * sample_rate) return;
  throw InvalidInput("the " + name + " at " + shortest(limit) + " Hz is not below half of the sampling rate, " +
                         shortest(sample_rate) + " Hz",
                     "the record holds no higher frequency", "choose a lower limit, or leave it out");
}

void filter(PreparedRecord& prepared, const ZeroPhaseFilter& options) {
  Record& record = prepared.record;
  if (options.high_pass > 0.0) check_limit(options.high_pass, record.sample_rate, "high-pass");
  if (options.low_pass > 0.0) check_limit(options.low_pass, record.sample_rate, "low-pass");
  if (options.low_pass > 0.0 && options.high_pass >= options.low_pass)
    throw InvalidInput("the high-pass, " + shortest(options.high_pass) + " Hz, is not below the low-pass, " +
                           shortest(options.low_pass) + " Hz",
                       "nothing would be left of the record", "exchange them, or leave one out");
  for (Index j = 0; j < record.values.rows(); ++j)
    record.values.row(j) = filtered(record.values.row(j).transpose(), record.sample_rate, options).transpose();
  const std::string high = options.high_pass > 0.0 ? "high-pass " + in_words(options.high_pass) + " Hz" : "",
                    low = options.low_pass > 0.0 ? "low-pass " + in_words(options.low_pass) + " Hz" : "";
  prepared.preparation.push_back("filtered without phase: " + high + (high.empty() || low.empty() ? "" : ", ") + low +
                                 " (Butterworth of order " + std::to_string(options.order) + ")");
}

}  // namespace

void prepare_channels(PreparedRecord& prepared, const ChannelPreparation& asked) {
  if (asked.offset) subtract_offset(prepared, *asked.offset);
  if (asked.trend) subtract_trend(prepared);
  if (asked.high_pass > 0.0 || asked.low_pass > 0.0)
    filter(prepared, {.high_pass = asked.high_pass, .low_pass = asked.low_pass});
  if (!asked.sample_rate) return;
  const double old_rate = prepared.record.sample_rate;
  prepared.record = resampled(prepared.record, *asked.sample_rate);
  prepared.preparation.push_back("resampled from " + in_words(old_rate) + " Hz to " + in_words(*asked.sample_rate) +
                                 " Hz behind an anti-alias filter (pass band up to " +
                                 in_words(0.4 * *asked.sample_rate) + " Hz)");
}

}  // namespace kalfem
