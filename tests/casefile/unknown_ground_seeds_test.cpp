// SPDX-License-Identifier: Apache-2.0
#include <iostream>

#include "casefile/case_run.hpp"

#include "kalfem/steps/estimation/outcome.hpp"

// The paper's chain on a ground whose motion nobody measured: errors and bands over 40 roads and 40 draws of the noise.

namespace kalfem::test {
namespace {

std::string chain(int seed) {
  const std::string number = std::to_string(seed);
  return R"(kalfem: 1
substructures:
  wheel: {masses: {w: 1.5 kg}, springs: [{name: k_w, from: ground, to: w, stiffness: 20 kN/m}]}
  body: {chain: {masses: 10, mass: 1 kg, stiffness: 30 kN/m}, damping: {modal: 1 %}}
connectors:
  suspension:
    {from: wheel.w, to: body.1, law: saturating, parameters: {k: 5 kN/m, mu_k1: 20 N, mu_k2: 2 mm, c: 10 N s/m, mu_c1: 10 N, mu_c2: 0.05 m/s}}
excitation:
  road:
    base_displacement: wheel.ground
    random: {rms: 3 mm, band: [0.5, 30 Hz], seed: )" +
         number + R"(}
    unknown: {std: 3 mm, correlation_time: 10 ms}
sensors:
  d2: {displacement: body.1, noise: 1 %}
  a3: {acceleration: body.2, noise: 1 %}
  a5: {acceleration: body.4, noise: 1 %}
  a7: {acceleration: body.6, noise: 1 %}
  a11: {acceleration: body.10, noise: 1 %}
simulate: {duration: 8 s, sample_rate: 1 kHz, tolerance: 1e-3, seed: )" +
         number + R"(}
estimate: {settle: 2 s, smooth: true}
)";
}

/// Part of the samples after 2 s with the truth in the 95 % band.
double coverage(const PointQuantity& point) {
  const Eigen::Index count = point.mean.size() - 2000;
  return ((point.mean - point.truth).tail(count).array().abs() <= 1.96 * point.deviation.tail(count).array())
      .cast<double>()
      .mean();
}

/// Next to the sensors: displacement and velocity of the masses that carry one.
TEST(UnknownGround, StatesNextToSensorsAreKnownWithHonestBandsOver40Seeds) {
  const int seeds = 40;
  double covered = 0.0, covered_smoothed = 0.0, input = 0.0, worst = 0.0;
  int named = 0;
  double filtered_error = 0.0, smoothed_error = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const auto results = results_of(chain(seed));
    ASSERT_TRUE(results.complete()) << seed << " " << results.failure;
    const auto& outcome = results.get<EstimationOutcome>();
    int count = 0;
    double of_run = 0.0, smoothed_of_run = 0.0;
    for (const char* name : {"body.1", "body.2", "body.4", "body.6", "body.10"})
      for (const auto quantity : {ObservedQuantity::displacement, ObservedQuantity::velocity}) {
        const auto& point = *find_quantity(outcome.points, name, quantity);
        const auto& smoothed = *find_quantity(outcome.smoothed_points, name, quantity);
        worst = std::max(worst, point.nrmse.value());
        of_run += coverage(point);
        smoothed_of_run += coverage(smoothed);
        filtered_error += point.nrmse.value();
        smoothed_error += smoothed.nrmse.value();
        ++count;
      }
    covered += of_run / count / seeds;
    covered_smoothed += smoothed_of_run / count / seeds;
    input += outcome.inputs.at(0).coverage.value() / seeds;
    named += std::ranges::count(outcome.hardly_known, "road") > 0;
  }
  std::cout << "largest NRMSE next to sensors " << worst << ", coverage of 95 % bands " << covered << ", of the road "
            << input << ", smoothed " << covered_smoothed << "; NRMSE smoothed / filtered "
            << smoothed_error / filtered_error << "; road named as hardly known in " << named << " of " << seeds
            << "\n";
  EXPECT_LT(worst, 0.05);
  EXPECT_GT(covered, 0.90);
  EXPECT_LT(covered, 0.99);
  EXPECT_GT(covered_smoothed, 0.90);
  EXPECT_LT(covered_smoothed, 0.99);
  EXPECT_GT(input, 0.90);
  EXPECT_LT(input, 0.99);
  EXPECT_EQ(named, seeds);
  EXPECT_LT(smoothed_error, 0.6 * filtered_error);
}

}  // namespace
}  // namespace kalfem::test
