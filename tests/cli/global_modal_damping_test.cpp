// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "command.hpp"

namespace kalfem::test {
namespace {

/// A heavily damped structure, so that its damping shows in everything: a wheel that is as heavy as the body's masses.
const std::string damped_case = R"(kalfem: 1
substructures:
  wheel: {masses: {w: 2 kg}, springs: [{from: ground, to: w, stiffness: 20 kN/m}]}
  body: {chain: {masses: 4, mass: 1 kg, stiffness: 30 kN/m}}
damping: {modal: 8 %}
connectors:
  suspension:
    {from: wheel.w, to: body.1, law: saturating, parameters: {k: 5 kN/m, mu_k1: 20 N, mu_k2: 2 mm, c: 0, mu_c1: 0 N, mu_c2: 0.05 m/s}}
excitation:
  road: {base_displacement: wheel.ground, random: {rms: 3 mm, band: [0.5, 30 Hz], seed: 3}}
sensors:
  a2: {acceleration: body.2, noise: 1 %}
  a4: {acceleration: body.4, noise: 1 %}
simulate: {duration: 10 s, sample_rate: 1 kHz, tolerance: 1e-4}
estimate: {unknown: {suspension.mu_k1: {initial: 20 N, std: 4 N}}, settle: 2 s}
predict: {substructure: body}
)";

TEST(GlobalModalDamping, IsInTheSimulationTheFilterAndThePrediction) {
  const ScratchFolder folder("global-modal-damping");
  std::ofstream(folder / "case.yaml") << damped_case;
  const auto outcome = run_command("run " + (folder / "case.yaml").string(), folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const auto summary = read_summary(folder / "case.kalfem-out");
  const auto& found = summary["parameters"]["suspension.mu_k1"];
  EXPECT_NEAR(found["estimate"].get<double>(), 20.0, 0.02);  // five standard deviations: the step's bias is there too
  EXPECT_NEAR(summary["estimation"]["nis"]["mean"].get<double>(), 2.0, 0.066);  // three standard errors of 0.022
  // The body alone: with its share of the damping, and dragged at by the wheel and the ground: as good as with modal
  // damping of its own.
  for (const auto& [point, errors] : summary["prediction"]["body"].items())
    EXPECT_LE(errors["acceleration_nrmse"].get<double>(), 0.004) << point;
}

}  // namespace
}  // namespace kalfem::test
