// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/sensor_gate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "kalfem/base/units.hpp"
#include "kalfem/live/three_digits.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

std::string seconds(double time) { return shortest(std::round(time * 1e4) / 1e4) + " s"; }

std::string sentence_of(FilterEventKind fault, double value, const std::string& unit) {
  switch (fault) {
    case FilterEventKind::stuck:
      return "it gives " + three_digits(value) + " " + unit + " again and again while the structure moves";
    case FilterEventKind::saturated:
      return "it stays at " + three_digits(value) + " " + unit +
             ", an end of its range, while the structure moves beyond";
    case FilterEventKind::dead:
      return "it gives noise alone while the structure moves";
    case FilterEventKind::missing:
      return "it gives no value";
    default:
      return "it does not follow the filter's prediction";
  }
}

}  // namespace

GatedInnovation gate(const Innovation& innovation, const std::vector<bool>& trusted, double limit) {
  const Eigen::MatrixXd covariance = innovation.covariance.selfadjointView<Eigen::Lower>();
  const Index count = innovation.value.size();
  const VectorXd alone = innovation.value.cwiseQuotient(covariance.diagonal().cwiseSqrt());
  std::vector<Index> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), Index{0});
  std::ranges::stable_sort(order, [&](Index a, Index b) {
    const bool first = trusted[static_cast<std::size_t>(a)], second = trusted[static_cast<std::size_t>(b)];
    return first != second ? first : std::abs(alone[a]) < std::abs(alone[b]);
  });
  GatedInnovation gated{VectorXd(count), std::vector<bool>(static_cast<std::size_t>(count))};
  // L^-1 [S nu] of the channels that were taken, row by row: what they say of every other one.
  Eigen::MatrixXd rows(count, count + 1);
  Index taken = 0;
  for (const Index i : order) {
    const auto before = rows.topRows(taken);
    const double variance = covariance(i, i) - before.col(i).squaredNorm();
    const double value = innovation.value[i] - before.col(i).dot(before.col(count));
    const double deviation = std::sqrt(std::max(variance, 1e-12 * covariance(i, i)));
    gated.normalised[i] = value / deviation;
    if (!trusted[static_cast<std::size_t>(i)] || !(std::abs(gated.normalised[i]) <= limit)) continue;
    gated.taken[static_cast<std::size_t>(i)] = true;
    rows.row(taken).head(count) = (covariance.row(i) - before.col(i).transpose() * before.leftCols(count)) / deviation;
    rows(taken, count) = gated.normalised[i];
    ++taken;
  }
  return gated;
}

SensorGate::SensorGate(const GateOptions& options, std::vector<GatedSensor> sensors)
    : options_(options), sensors_(std::move(sensors)), log_(options.most_events) {
  for (const auto& each : sensors_) channels_.emplace_back(options_, each.noise);
  since_ = VectorXd::Zero(std::ssize(sensors_));
}

std::vector<Index> SensorGate::refused(double time, const VectorXd& values, const Innovation& innovation) {
  std::vector<bool> trusted;
  for (const Index channel : innovation.channels) trusted.push_back(trusts(channel));
  const bool warm = !warms_up();
  const auto [normalised, taken] = gate(innovation, trusted, warm ? options_.limit : infinity);
  std::vector<Index> out;
  for (std::size_t i = 0; i < trusted.size(); ++i) {
    const Index channel = innovation.channels[i], row = static_cast<Index>(i);
    auto& known = channels_[static_cast<std::size_t>(channel)];
    const ExpectedValue value{values[channel], values[channel] - innovation.value[row], innovation.covariance(row, row),
                              normalised[row]};
    const bool was_missing = known.is_missing();
    const auto fault = known.see(value, trusted[i] && !taken[i]);
    if (was_missing) log_.add({time, FilterEventKind::back, sensor(channel).name, "it gives values again"});
    const bool broken = fault && *fault != FilterEventKind::off;
    if (trusted[i]) {
      if (fault) suspend(time, channel, *fault);
      if (!fault && !taken[i]) leave_out_once(time, channel, value);
    } else if (broken) {
      suspend(time, channel, *fault);
    } else if (known.is_good()) {
      bring_back(time, channel);
    } else if (std::abs(value.normalised) > options_.limit) {
      known.suspend(FilterEventKind::off);  // whatever it was, it moves again, but not as expected
    }
    if (!trusted[i] || !taken[i] || known.fault()) out.push_back(channel);
  }
  for (Index channel = 0; channel < values.size(); ++channel)
    if (!std::isfinite(values[channel])) {
      auto& known = channels_[static_cast<std::size_t>(channel)];
      const bool before = known.is_missing();
      known.miss();
      if (known.is_missing() && !before)
        log_.add({time, FilterEventKind::missing, sensor(channel).name,
                  sentence_of(FilterEventKind::missing, 0.0, "") + "; the filter goes on without it"});
    }
  count_contradictions(innovation);
  if (warms_up() && !innovation.channels.empty()) ++warm_;
  return out;
}

void SensorGate::miss(double time) {
  refused(time, VectorXd::Constant(std::ssize(sensors_), std::numeric_limits<double>::quiet_NaN()), Innovation{});
}

/// Most channels that work contradict the filter.
void SensorGate::count_contradictions(const Innovation& innovation) {
  Index working = 0, off = 0;
  for (const Index channel : innovation.channels) {
    const auto& known = channels_[static_cast<std::size_t>(channel)];
    if (known.is_broken()) continue;
    ++working;
    if (known.fault()) ++off;
  }
  if (working == 0) return;
  contradicted_ = 2 * off > working ? std::min(contradicted_ + 1, options_.patience) : 0;
}

void SensorGate::leave_out_once(double time, Index channel, const ExpectedValue& value) {
  const auto& [name, unit, noise] = sensor(channel);
  log_.add({time, FilterEventKind::spike, name,
            three_digits(value.measured) + " " + unit + " where " + three_digits(value.predicted) + " " + unit +
                " was expected, " + three_digits(std::abs(value.normalised)) + " deviations off; left out"});
}

/// Takes it out, or gives another reason why it is out; a reason that was the last one told is not told again.
void SensorGate::suspend(double time, Index channel, FilterEventKind fault) {
  auto& known = channels_[static_cast<std::size_t>(channel)];
  if (!known.fault()) {
    since_[channel] = time;
    ++changes_;
  }
  known.suspend(fault);
  const auto& [name, unit, noise] = sensor(channel);
  if (const auto* told = log_.latest(name); told && told->kind == fault) return;
  log_.add({time, fault, name, sentence_of(fault, known.last(), unit) + "; left out until it follows the prediction"});
}

void SensorGate::bring_back(double time, Index channel) {
  channels_[static_cast<std::size_t>(channel)].readmit();
  ++changes_;
  log_.add({time, FilterEventKind::back, sensor(channel).name,
            "it follows the prediction again after " + seconds(time - since_[channel]) + "; taken again"});
}

void SensorGate::filter_was_changed(double time, FilterEventKind how, const std::string& text) {
  log_.add({time, how, "", text});
  for (auto& channel : channels_)
    if (channel.fault() == FilterEventKind::off) channel.readmit();
  warm_ = contradicted_ = 0;
  ++changes_;
}

bool SensorGate::is_silent() const { return std::ranges::all_of(channels_, &ChannelGate::is_missing); }

bool SensorGate::trusts_any() const {
  return std::ranges::any_of(channels_, [](const auto& each) { return !each.fault(); });
}

bool SensorGate::trusts_all() const {
  return std::ranges::all_of(channels_, [](const auto& each) { return !each.fault(); });
}

double SensorGate::contradiction() const {
  double sum = 0.0, count = 0.0;
  for (const auto& channel : channels_)
    if (channel.fault() == FilterEventKind::off) {
      sum += channel.mean_square();
      count += 1.0;
    }
  return count > 0.0 ? sum / count : 1.0;
}

std::vector<Reason> SensorGate::reasons() const {
  std::vector<Reason> reasons;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const auto& fault = channels_[i].fault();
    if (!fault) continue;
    reasons.push_back({"sensor_" + to_string(*fault), sensors_[i].name,
                       "sensor '" + sensors_[i].name + "' is left out since " + seconds(since_[static_cast<Index>(i)]) +
                           ": " + sentence_of(*fault, channels_[i].last(), sensors_[i].unit),
                       "look at the sensor and its cable", VerdictState::suspicious, infinity});
  }
  return reasons;
}

}  // namespace kalfem
