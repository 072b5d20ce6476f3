// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/channel_gate.hpp"

#include <cmath>
#include <limits>

namespace kalfem {

using Eigen::Index;

namespace {

enum Row : Index { measured, predicted, variance, normalised, left_out, rows };

constexpr double moved = 4.0;             ///< deviations between predictions that a working sensor would have shown
constexpr double good_mean_square = 4.0;  ///< of normalised innovations, expected 1
constexpr double infinity = std::numeric_limits<double>::infinity();

double variance_of(const auto& values) { return (values.array() - values.mean()).square().mean(); }

}  // namespace

ChannelGate::ChannelGate(const GateOptions& options, double noise)
    : options_(options),
      noise_(noise),
      memory_(Eigen::MatrixXd::Zero(rows, options.memory)),
      last_(std::numeric_limits<double>::quiet_NaN()),
      lowest_(infinity),
      highest_(-infinity) {}

void ChannelGate::miss() {
  if (missing_ < options_.silence) ++missing_;
}

std::optional<FilterEventKind> ChannelGate::see(const ExpectedValue& value, bool was_left_out) {
  missing_ = 0;
  memory_.col(count_ % options_.memory) << value.measured, value.predicted, value.variance, value.normalised,
      was_left_out ? 1.0 : 0.0;
  ++count_;
  if (const auto fault = same_value_fault(value)) return fault;
  const bool dead_is_due = count_ % std::max(1, options_.memory / 4) == 0;
  if ((dead_is_due || was_left_out || fault_) && is_dead()) return FilterEventKind::dead;
  const Index held = std::min<Index>(count_, options_.memory);
  if (memory_.row(left_out).head(held).sum() >= options_.suspend_after) return FilterEventKind::off;
  return {};
}

/// The same value again and again, while the prediction has moved by more than it could err.
std::optional<FilterEventKind> ChannelGate::same_value_fault(const ExpectedValue& value) {
  if (value.measured != last_) {
    same_ = 0;
    lowest_prediction_ = highest_prediction_ = value.predicted;
  }
  last_ = value.measured;
  ++same_;
  lowest_prediction_ = std::min(lowest_prediction_, value.predicted);
  highest_prediction_ = std::max(highest_prediction_, value.predicted);
  const bool at_an_end = value.measured <= lowest_ || value.measured >= highest_;
  lowest_ = std::min(lowest_, value.measured);
  highest_ = std::max(highest_, value.measured);
  const double range = highest_prediction_ - lowest_prediction_;
  if (same_ < options_.stuck || range < moved * std::sqrt(value.variance)) return {};
  const bool beyond = value.measured >= highest_ ? value.predicted > value.measured : value.predicted < value.measured;
  return at_an_end && beyond && lowest_ < highest_ ? FilterEventKind::saturated : FilterEventKind::stuck;
}

/// Its values vary as noise alone, those that are expected of it far more.
bool ChannelGate::is_dead() const {
  if (count_ < options_.memory) return false;
  const double seen = variance_of(memory_.row(measured)), expected = variance_of(memory_.row(predicted));
  const double error = memory_.row(variance).mean();
  return seen < 4.0 * noise_ * noise_ && expected > moved * moved * error && seen < 0.1 * expected;
}

double ChannelGate::mean_square() const {
  const Index held = std::min<Index>(count_, options_.memory);
  return held == 0 ? 1.0 : memory_.row(normalised).head(held).squaredNorm() / static_cast<double>(held);
}

bool ChannelGate::is_good() const {
  if (count_ < options_.memory || missing_ > 0 || same_ >= options_.stuck || is_dead()) return false;
  const double seen = variance_of(memory_.row(measured)), expected = variance_of(memory_.row(predicted));
  return memory_.row(normalised).cwiseAbs().maxCoeff() <= options_.limit && mean_square() <= good_mean_square &&
         seen > 0.25 * (expected + noise_ * noise_);
}

void ChannelGate::readmit() {
  fault_.reset();
  memory_.row(left_out).setZero();
}

}  // namespace kalfem
