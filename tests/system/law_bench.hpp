// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include "kalfem/system/connector_law.hpp"

namespace kalfem {

/// A law with a parameter set under which it is passive, at the amplitude that it is made for.
struct LawCase {
  std::string label;
  ConnectorLawPtr law;
  std::vector<double> parameters;
  double deformation = 1e-3;  ///< [m]
  double rate = 0.1;          ///< [m/s]
  bool force_at_rest = false;
};

inline void PrintTo(const LawCase& of, std::ostream* stream) { *stream << of.label; }

/// Arrays for N points of one law, all parameters alike.
struct LawBench {
  Eigen::ArrayXXd parameters, begin_states, states;
  Eigen::ArrayXd begin_deformation, begin_rate, deformation, rate, acceleration, force, stiffness, damping, inertance;

  explicit LawBench(const LawCase& of, Eigen::Index points = 1) : law_(of.law) {
    const auto state_count = static_cast<Eigen::Index>(of.law->states().size());
    parameters.resize(points, static_cast<Eigen::Index>(of.parameters.size()));
    for (Eigen::Index j = 0; j < parameters.cols(); ++j) parameters.col(j) = of.parameters[static_cast<std::size_t>(j)];
    for (auto* array : {&begin_deformation, &begin_rate, &deformation, &rate, &acceleration, &force, &stiffness,
                        &damping, &inertance})
      array->setZero(points);
    begin_states.setZero(points, state_count);
    states.setZero(points, state_count);
  }

  void respond(double duration) {
    law_->respond({duration, parameters, begin_deformation, begin_rate, begin_states, deformation, rate, acceleration},
                  {force, stiffness, damping, inertance, states});
  }

  /// Advances one point to the motion (d, v, a) and makes that the next interval's beginning.
  double step(double duration, double d, double v, double a = 0.0) {
    deformation = d;
    rate = v;
    acceleration = a;
    respond(duration);
    begin_deformation = deformation;
    begin_rate = rate;
    begin_states = states;
    return force[0];
  }

private:
  ConnectorLawPtr law_;
};

/// Work over the second of two cycles d = A sin(w t), by the trapezoidal rule.
inline double cycle_work(const LawCase& of, double amplitude, double angular_frequency, int steps = 20000) {
  LawBench bench(of);
  const double h = 2.0 * M_PI / angular_frequency / steps;
  double work = 0.0, last_force = 0.0, last_d = 0.0;
  bench.begin_rate = amplitude * angular_frequency;
  for (int i = 1; i <= 2 * steps; ++i) {
    const double phase = 2.0 * M_PI * (i % steps) / steps, w = angular_frequency;
    const double d = amplitude * std::sin(phase);
    const double f = bench.step(h, d, amplitude * w * std::cos(phase), -d * w * w);
    if (i > steps) work += 0.5 * (f + last_force) * (d - last_d);
    last_force = f;
    last_d = d;
  }
  return work;
}

}  // namespace kalfem
