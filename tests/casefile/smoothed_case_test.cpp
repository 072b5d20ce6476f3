// SPDX-License-Identifier: Apache-2.0
#include "casefile/case_run.hpp"

#include "kalfem/steps/estimation/outcome.hpp"

// The fixed-interval smoother of a case: what must hold of it whatever the structure.

namespace kalfem::test {
namespace {

/// Three storeys with an unknown mass and an unknown spring: modal coordinates change with every relinearisation.
const std::string storeys = R"(kalfem: 1
substructures:
  s:
    masses: {1: 2 kg, 2: 1 kg, 3: 1 kg}
    springs:
      - {name: low, from: ground, to: 1, stiffness: 8 kN/m, damping: 20}
      - {name: high, from: 1, to: 2, stiffness: 5 kN/m, damping: 10}
      - {name: top, from: 2, to: 3, stiffness: 6 kN/m, damping: 10}
excitation:
  quake: {base_acceleration: all, random: {rms: 3 m/s^2, band: [1, 20 Hz], seed: 4}}
sensors:
  a1: {acceleration: s.1, noise: 5 %}
  a2: {acceleration: s.3, noise: 5 %}
simulate: {duration: 3 s, sample_rate: 500 Hz, tolerance: 1e-4}
estimate: {settle: 0.5 s, substeps: 4, smooth: true, unknown: {s.2.mass: {initial: 1.4 kg, std: 30 %}, s.high.stiffness: {initial: 6 kN/m, std: 20 %}}}
)";

/// From the whole record a constant has one estimate, the filter's last, at every sample.
TEST(SmoothedCase, ConstantsHaveTheirLastEstimateThroughoutTheRecord) {
  const auto results = results_of(storeys);
  ASSERT_TRUE(results.complete()) << results.failure;
  const auto& outcome = results.get<EstimationOutcome>();
  ASSERT_GT(outcome.result.linearisations, 3);
  ASSERT_TRUE(outcome.smoothed.has_value());
  const auto& [mean, deviation] = outcome.result.unknowns;
  const Eigen::Index last = mean.cols() - 1;
  for (Eigen::Index i = 0; i < mean.rows(); ++i)
    for (Eigen::Index k = 0; k <= last; ++k) {
      ASSERT_NEAR(outcome.smoothed->unknowns.mean(i, k), mean(i, last), 1e-3 * deviation(i, last)) << i << " " << k;
      ASSERT_NEAR(outcome.smoothed->unknowns.deviation(i, k), deviation(i, last), 1e-3 * deviation(i, last));
    }
}

/// The beginning, which the filter passes with wrong parameters, gains most.
TEST(SmoothedCase, StatesComeNearerToTheTruth) {
  const auto results = results_of(storeys);
  ASSERT_TRUE(results.get<EstimationOutcome>().smoothed.has_value());
  for (const auto& point : results.get<EstimationOutcome>().points)
    if (point.nrmse && point.quantity != ObservedQuantity::acceleration) {
      const auto* smoothed =
          find_quantity(results.get<EstimationOutcome>().smoothed_points, point.point, point.quantity);
      ASSERT_NE(smoothed, nullptr);
      EXPECT_LT(smoothed->nrmse.value(), point.nrmse.value()) << point.point;
    }
}

}  // namespace
}  // namespace kalfem::test
