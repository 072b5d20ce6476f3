// SPDX-License-Identifier: Apache-2.0
// Updates Young's modulus of a frame by natural frequencies that were measured on it.
// Usage: update_frame frame.bdf
#include <cmath>
#include <iostream>

#include "kalfem/formats/deck.hpp"
#include "kalfem/kalfem.hpp"

using namespace kalfem;

int main(int, char** argv) try {
  Structure s;
  s.add(FiniteElements("frame", read_deck(argv[1]).model));
  for (const auto& name : s.parameters()) std::cout << "may be refined: " << name << '\n';

  UpdateOptions options{.substructure = "frame", .parameters = {{"frame.mat1.youngs_modulus"}}};
  for (const double frequency : {6.769, 10.826, 12.880, 19.502, 24.751})
    options.frequencies.push_back({frequency, 0.002 * frequency});  // [Hz]
  const auto result = update(s, options);

  std::cout << result.reason << '\n';
  for (const auto& f : result.frequencies)
    std::cout << "measured " << f.measured << " Hz, model " << f.before << " Hz, updated " << f.after << " Hz\n";
  const auto& modulus = result.parameters[0];
  std::cout << modulus.name << ' ' << modulus.value << " +- " << modulus.std << ' ' << modulus.unit << '\n';
  std::cout << "verdict: " << to_string(result.verdict.state()) << '\n';
  for (const auto& reason : result.verdict.reasons()) std::cout << reason.text << "; " << reason.remedy << '\n';

  // The frame that was measured has 210 GPa.
  const bool right = std::abs(modulus.value - 210e9) < 3 * modulus.std;
  return right && result.verdict.state() == VerdictState::consistent ? 0 : 1;
} catch (const InvalidInput& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
