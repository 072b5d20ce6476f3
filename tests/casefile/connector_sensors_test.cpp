// SPDX-License-Identifier: Apache-2.0
#include "casefile/case_run.hpp"

#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/simulation/outcome.hpp"
#include "kalfem/steps/updating/outcome.hpp"

// Sensors of several connectors with weights, in the record, the filter and an updating.

namespace kalfem::test {
namespace {

using enum ObservedQuantity;

const std::string struts = R"(kalfem: 1
substructures:
  frame:
    masses: {1: 2 kg, 2: 1 kg}
    springs: [{name: s, from: ground, to: 1, stiffness: 4 kN/m, damping: 10}, {from: 1, to: 2, stiffness: 3 kN/m, damping: 5}]
connectors:
  p: {from: frame.ground, to: frame.1, law: cubic, parameters: {k: 1 kN/m, k3: 1e8}}
  q: {from: frame.1, to: frame.2, law: cubic, parameters: {k: 2 kN/m, k3: 2e8}}
  r: {from: frame.ground, to: frame.2, law: linear, parameters: {k: 1 kN/m, c: 20}}
excitation:
  road: {base_displacement: frame.ground, random: {rms: 3 mm, band: [0.5, 15 Hz]}}
sensors:
  f: {force: {p: 1, q: -2.5, r: 0.5}, noise: 1 %}
  d: {deformation: {q: 3, p: 2}, noise: 1 %}
  v: {rate: {r: -1, p: 1}, noise: 1 %}
  one: {force: q, noise: 1 %}
simulate: {duration: 3 s, sample_rate: 500 Hz, tolerance: 1e-4}
)";

TEST(ConnectorSensors, AddUpTheirConnectorsByWeight) {
  const auto results = results_of(struts, "simulate");
  ASSERT_TRUE(results.complete()) << results.failure;
  const auto of = [&](const char* connector, ObservedQuantity quantity) {
    return simulated(results, connector, quantity);
  };
  const auto& sensors = results.get<SimulationOutcome>().reference.sensors;
  const Eigen::VectorXd force =
      of("p", connector_force) - 2.5 * of("q", connector_force) + 0.5 * of("r", connector_force);
  // sums of three terms: rounding
  EXPECT_LT(difference(sensors.row(0).transpose(), force), 5e-15);
  EXPECT_LT(difference(sensors.row(1).transpose(),
                       3.0 * of("q", connector_deformation) + 2.0 * of("p", connector_deformation)),
            5e-15);
  EXPECT_LT(difference(sensors.row(2).transpose(), of("p", connector_rate) - of("r", connector_rate)), 5e-15);
  EXPECT_LT(difference(sensors.row(3).transpose(), of("q", connector_force)), 1e-15);
}

TEST(ConnectorSensors, AreWhatTheFilterCompares) {
  const auto results = results_of(struts +
                                  "estimate: {unknown: {p.k: {initial: 1.2 kN/m, std: 0.2 kN/m}, q.k3: "
                                  "{initial: 1.5e8, std: 5e7}}, settle: 0.5 s, substeps: 8}\n");
  ASSERT_TRUE(results.complete()) << results.failure;
  const auto& unknowns = results.get<EstimationOutcome>().result.unknowns;
  const Eigen::Index last = unknowns.mean.cols() - 1;
  // four deviations of one record; found .6 and .3 of one
  EXPECT_NEAR(unknowns.mean(0, last), 1000.0, 4.0 * unknowns.deviation(0, last));
  EXPECT_NEAR(unknowns.mean(1, last), 2e8, 4.0 * unknowns.deviation(1, last));
  EXPECT_GT(unknowns.deviation(0, last), 0.3);
  EXPECT_LT(unknowns.deviation(0, last), 1.3);  // found .66
  // two standard errors of some 2000 samples: found .003
  EXPECT_NEAR(results.get<EstimationOutcome>().consistency.mean_nis, 4.0, 0.12);
}

TEST(ConnectorSensors, AreWhatAnUpdatingSimulates) {
  const auto results =
      results_of(struts +
                     "update: {parameters: {frame.s.stiffness: {initial: 3 kN/m, std: 20 %}}, compare: "
                     "{record: {simulation: [f, d, v]}}}\n",
                 "update");
  ASSERT_TRUE(results.complete()) << results.failure;
  // found 6e-4
  EXPECT_NEAR(results.get<UpdatingOutcome>().values[0] / 4000.0, 1.0, 2e-3);
}

TEST(ConnectorSensors, EveryConnectorMustExist) {
  const auto found = problems_of(changed(struts, "{q: 3, p: 2}", "{q: 3, pp: 2}"));
  EXPECT_NE(found.find("case.yaml:14: sensors.d.deformation: there is no connector 'pp' (did you mean 'p'?)"),
            std::string::npos)
      << found;
}

}  // namespace
}  // namespace kalfem::test
