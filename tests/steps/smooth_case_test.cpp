// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "casefile/case_run.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/study_results.hpp"

namespace kalfem::test {
namespace {

/// Three masses under a force that was not measured; connectors and further keys of the force as given.
std::string chain_with(const std::string& connectors, const std::string& unknown, const std::string& unknowns) {
  return R"(kalfem: 1
substructures:
  c:
    masses: {m1: 10 kg, m2: 10 kg, m3: 10 kg}
    springs:
      - {name: k1, from: ground, to: m1, stiffness: 40 kN/m}
      - {name: k2, from: m1, to: m2, stiffness: 40 kN/m}
      - {name: k3, from: m2, to: m3, stiffness: 40 kN/m}
    damping: {modal: 1 %}
)" + connectors +
         R"(
excitation:
  f: {force: c.m3, random: {rms: 20 N, band: [1, 20 Hz], seed: 3}, unknown: )" +
         unknown + R"(}
sensors:
  a1: {acceleration: c.m1, noise: 5 %}
  a2: {acceleration: c.m2, noise: 5 %}
  a3: {acceleration: c.m3, noise: 5 %}
simulate: {duration: 4 s, sample_rate: 500 Hz, seed: 1}
estimate: {smooth: true, diagnose: false)" +
         unknowns + "}\n";
}

/// The smoothed input is there, and nearer to the truth than the filter's.
void expect_smoothed(const std::string& text) {
  const auto results = results_of(text, "estimate");
  ASSERT_TRUE(results.has<EstimationOutcome>()) << results.failure;
  const auto& outcome = results.get<EstimationOutcome>();
  ASSERT_TRUE(outcome.smoothed.has_value());
  EXPECT_TRUE(std::ranges::none_of(
      results.warnings, [](const std::string& each) { return each.find("estimate.smooth") != std::string::npos; }));
  ASSERT_EQ(outcome.smoothed_inputs.size(), 1u);
  const auto &filtered = outcome.inputs.front(), &smoothed = outcome.smoothed_inputs.front();
  EXPECT_TRUE(smoothed.mean.allFinite() && smoothed.deviation.allFinite());
  const Eigen::Index tail = smoothed.deviation.size() / 2;
  EXPECT_LT(smoothed.deviation.segment(tail / 2, tail).mean(),
            1.001 * filtered.deviation.segment(tail / 2, tail).mean());
}

TEST(SmoothOfACase, IsDeliveredWithAnUnknownInput) {
  expect_smoothed(chain_with("", "{std: 30 N, correlation_time: 20 ms}", ""));
  expect_smoothed(chain_with("connectors: {n: {from: c.m2, to: c.m3, law: cubic, parameters: {k3: 1e8}}}",
                             "{std: 30 N, correlation_time: 20 ms}", ""));
  expect_smoothed(chain_with("", "{std: 30 N, correlation_time: 20 ms}",
                             ", unknown: {c.k1.stiffness: {initial: 38 kN/m, std: 10 %}}"));
}

}  // namespace
}  // namespace kalfem::test
