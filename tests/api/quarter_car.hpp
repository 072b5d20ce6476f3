// SPDX-License-Identifier: Apache-2.0
// A moved ground of which a live filter gets values alone.
#pragma once

#include "chain.hpp"

namespace kalfem::quarter_car {

constexpr double rate = 500.0;

/// A quarter car whose suspension stiffens, on a road that is known to 12 Hz.
inline Structure structure(double k3) {
  Structure s;
  s.add(lumped("wheel").mass("w", 40.0).spring("tyre", "ground", "w", 1.8e5, 200.0));
  s.add(lumped("body").mass("b", 300.0));
  s.connect("strut", "wheel.w", "body.b", law("polynomial", {{"k1", 2e4}, {"k3", k3}, {"c1", 1.2e3}}));
  return s;
}

inline const std::vector<SensorDescription> sensors = {{"wheel", acceleration("wheel.w"), 0.05},
                                                       {"body", acceleration("body.b"), 0.02}};

inline Record drive(double duration, const SignalPtr& road) {
  return simulate(structure(3e6).base_displacement("road", "wheel.ground", road),
                  {.sensors = sensors, .duration = duration, .sample_rate = rate, .seed = 2})
      .record;
}

inline SignalPtr road_of(double duration) {
  return make_random({.rms = 8e-3, .lower = 0.5, .upper = 12.0, .duration = duration, .seed = 4});
}

/// The filter after all samples of a drive, a second at a time.
inline LiveFilter after(const Record& record, const SignalPtr& road, const OnlineOptions& online = {}) {
  const Eigen::VectorXd values = road->sample(0.0, 1.0 / rate, record.samples()).col(0).matrix();
  LiveFilter live(structure(2e6).base_displacement("road", "wheel.ground"), rate,
                  {.sensors = sensors, .unknowns = {{"strut.k3", {.std = 2e6}}}}, {.filter = online});
  const Eigen::Index block = 500;
  for (Eigen::Index first = 0; first < record.samples(); first += block) {
    const Eigen::Index count = std::min(block, record.samples() - first);
    const double time = static_cast<double>(first) / rate;
    live.push("road", time, values.segment(first, count));
    for (Eigen::Index i = 0; i < 2; ++i)
      live.push(sensors[static_cast<std::size_t>(i)].name, time,
                record.values.row(i).segment(first, count).transpose());
  }
  live.flush();
  return live;
}

/// Deviations between the estimate of k3 and the truth.
inline double deviations_off(LiveFilter live) {
  const auto k3 = live.filter().parameter("strut.k3");
  return std::abs(k3.mean - 3e6) / k3.std;
}

}  // namespace kalfem::quarter_car
