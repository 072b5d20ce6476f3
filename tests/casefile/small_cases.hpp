// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

// Beginnings of cases of one mass, to which a test adds the steps.

namespace kalfem::test {

/// A mass on a hardening spring under a random force: simulated for 2 s, measured by its displacement.
inline const std::string cubic_oscillator = R"(kalfem: 1
substructures:
  s: {masses: {m: 2 kg}, springs: [{name: k, from: ground, to: m, stiffness: 4 kN/m, damping: 3 N s/m}]}
connectors:
  c: {from: s.m, to: s.ground, law: cubic, parameters: {k: 100 N/m, k3: 2e7}}
excitation:
  f: {force: s.m, random: {rms: 10 N, band: [1, 15 Hz], fade_in: 0.2 s, seed: 2}}
sensors:
  x: {displacement: s.m, noise: 2 %}
simulate: {duration: 2 s, sample_rate: 200 Hz, tolerance: 1e-4, seed: 3}
)";

/// A mass that rattles between stops: a change of stiffness in the tenth digit moves the impacts.
inline const std::string rattling_mass = R"(kalfem: 1
substructures:
  body: {masses: {x: 1 kg}, springs: [{name: k, from: ground, to: x, stiffness: 10 N/m, damping: 0.05}]}
connectors:
  stop: {from: body.ground, to: body.x, law: gap, parameters: {k_stop: 1e5, c_stop: 2, gap_upper: 1 mm, gap_lower: 1 mm}}
excitation:
  f: {force: body.x, sine: {amplitude: 1 N, frequency: 1.7}}
sensors:
  a: {displacement: body.x, noise: 1 %}
)";

}  // namespace kalfem::test
