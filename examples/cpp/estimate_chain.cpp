// SPDX-License-Identifier: Apache-2.0
// Estimates two parameters of a nonlinear suspension from four accelerations and the road below it.
// Usage: estimate_chain chain.csv   (t, road, a3, a5, a7, a11 in s, m and m/s^2)
#include <cmath>
#include <iostream>

#include "kalfem/formats/tables/csv.hpp"
#include "kalfem/kalfem.hpp"

using namespace kalfem;

int main(int, char** argv) try {
  const Record record = read_csv(argv[1]);

  Structure s;  // a wheel on the road, a suspension, and a body of ten masses
  s.add(lumped("wheel").mass("w", 1.5).spring("k_w", "ground", "w", 2e4));
  s.add(chain("body", 10, 1.0, 3e4).modal_damping(0.01));
  s.connect("suspension", "wheel.w", "body.1",
            law("saturating", {{"k", 5e3}, {"mu_k1", 20}, {"mu_k2", 2e-3}, {"c", 10}, {"mu_c1", 10}, {"mu_c2", 0.05}}));
  s.base_displacement("road", "wheel.ground", channel(record, "road"));

  const auto result = estimate(
      s, record,
      {.sensors = {{"a3", acceleration("body.2"), 2.0},
                   {"a5", acceleration("body.4"), 2.0},
                   {"a7", acceleration("body.6"), 2.0},
                   {"a11", acceleration("body.10"), 2.0}},
       .unknowns = {{"suspension.mu_k1", {.initial = 10, .std = 5}}, {"suspension.mu_c1", {.initial = 16, .std = 8}}}});
  if (result.failure) {
    std::cerr << "the filter stopped at " << result.failure->time << " s: " << result.failure->reason << '\n';
    return 1;
  }
  for (const auto& p : result.parameters)
    std::cout << p.name << ' ' << p.interval_95.lower << " to " << p.interval_95.upper << ' ' << p.unit << '\n';
  std::cout << "mean NIS " << result.mean_nis(0.5) << ", 4 expected\nverdict: " << to_string(result.verdict.state())
            << '\n';
  for (const auto& reason : result.verdict.reasons()) std::cout << reason.text << "; " << reason.remedy << '\n';

  // The record was simulated with mu_k1 = 20 N and mu_c1 = 10 N.
  const auto& [k, c] = std::tie(result.parameters[0], result.parameters[1]);
  const bool right = std::abs(k.mean - 20) < 3 * k.std && std::abs(c.mean - 10) < 3 * c.std && k.std < 2;
  return right && result.verdict.state() == VerdictState::consistent ? 0 : 1;
} catch (const InvalidInput& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
