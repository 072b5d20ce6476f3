// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/innovation_window.hpp"

#include <algorithm>
#include <limits>

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr Index parts = 20;           ///< of a window: a new verdict after each
constexpr Index fewest_samples = 50;  ///< of which a verdict is formed

}  // namespace

InnovationWindow::InnovationWindow(const std::vector<Sensor>& sensors, double sample_rate, Index length) {
  const Index count = std::ssize(sensors);
  ring_.sample_rate = sample_rate;
  ring_.noise.resize(count);
  for (Index i = 0; i < count; ++i) {
    const auto& sensor = sensors[static_cast<std::size_t>(i)];
    ring_.sensors.push_back(sensor.name);
    ring_.units.push_back(sensor.unit);
    ring_.noise[i] = sensor.noise;
  }
  ring_.innovation.setConstant(count, length, not_a_number);
  ring_.deviation.setConstant(count, length, not_a_number);
  ring_.nis.setConstant(length, not_a_number);
  ring_.measured.setZero(length);
}

bool InnovationWindow::add(double time, const Innovation& innovation) {
  const Index length = ring_.nis.size(), at = count_ % length;
  ring_.innovation.col(at).setConstant(not_a_number);
  ring_.deviation.col(at).setConstant(not_a_number);
  ring_.measured[at] = static_cast<int>(innovation.channels.size());
  ring_.nis[at] = not_a_number;
  if (ring_.measured[at] > 0) {
    ring_.innovation.col(at)(innovation.channels) = innovation.value;
    ring_.deviation.col(at)(innovation.channels) = innovation.covariance.diagonal().cwiseSqrt();
    ring_.nis[at] = innovation.nis;
  }
  ++count_;
  latest_ = time;
  if (count_ < fewest_samples || count_ % std::max<Index>(1, length / parts) != 0) return false;
  reasons_ = innovation_reasons(record());
  return judges_ = true;
}

InnovationRecord InnovationWindow::record() const {
  const Index length = ring_.nis.size(), held = std::min(count_, length);
  const Index oldest = count_ < length ? 0 : count_ % length;
  std::vector<Index> order(static_cast<std::size_t>(held));
  for (Index k = 0; k < held; ++k) order[static_cast<std::size_t>(k)] = (oldest + k) % length;
  InnovationRecord record{.sensors = ring_.sensors, .units = ring_.units, .noise = ring_.noise};
  record.sample_rate = ring_.sample_rate;
  record.start = latest_ - static_cast<double>(held - 1) / ring_.sample_rate;
  record.innovation = ring_.innovation(Eigen::all, order);
  record.deviation = ring_.deviation(Eigen::all, order);
  record.nis = ring_.nis(order);
  record.measured = ring_.measured(order);
  return record;
}

ConsistencySummary InnovationWindow::consistency() const {
  const InnovationRecord held = record();
  return summarise_consistency(held.nis, held.measured, held.innovation, held.noise, 0);
}

}  // namespace kalfem
