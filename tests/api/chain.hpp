// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kalfem/kalfem.hpp"
#include "kalfem/system/signals/random_signal.hpp"

namespace kalfem {

inline Law suspension_law(double mu_k1) {
  return law("saturating",
             {{"k", 5e3}, {"mu_k1", mu_k1}, {"mu_k2", 2e-3}, {"c", 10.0}, {"mu_c1", 10.0}, {"mu_c2", 0.05}});
}

/// A wheel on a moving ground, a nonlinear suspension, and a body of a few masses; its road is told online.
inline Structure chain_structure(double mu_k1 = 20.0) {
  Structure s;
  s.add(lumped("wheel").mass("w", 1.5).spring("k_w", "ground", "w", 2e4));
  s.add(chain("body", 4, 1.0, 3e4).modal_damping(0.01));
  s.connect("suspension", "wheel.w", "body.1", suspension_law(mu_k1));
  return s;
}

inline SignalPtr road() { return make_random({.rms = 3e-3, .lower = 0.5, .upper = 30.0, .duration = 4.0, .seed = 7}); }

/// The same with a road.
inline Structure driven_chain(double mu_k1 = 20.0) {
  return chain_structure(mu_k1).base_displacement("road", "wheel.ground", road());
}

inline std::vector<SensorDescription> chain_sensors() {
  return {{"a3", acceleration("body.2"), 0.3}, {"a5", acceleration("body.4"), 0.3}};
}

/// What the sensors show, with noise.
inline const Record& chain_record() {
  static const Record record =
      simulate(driven_chain(), {.sensors = chain_sensors(), .duration = 2.0, .sample_rate = 500.0, .seed = 1}).record;
  return record;
}

/// The messages of the InvalidInput that `call` throws; fails where it throws none.
template <class Call>
std::string refusal_of(const Call& call) {
  try {
    static_cast<void>(call());
  } catch (const InvalidInput& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was refused";
  return "";
}

}  // namespace kalfem
