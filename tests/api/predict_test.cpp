// SPDX-License-Identifier: Apache-2.0
#include "cantilever.hpp"

namespace kalfem {
namespace {

using testing::HasSubstr;
constexpr auto of_displacement = ObservedQuantity::displacement, of_acceleration = ObservedQuantity::acceleration;

PredictOptions chain_prediction() {
  return {.estimate = {.sensors = chain_sensors(),
                       .unknowns = {{"suspension.mu_k1", {.initial = 15.0, .std = 5.0}}},
                       .outputs = {{"top", acceleration("body.4")}},
                       .substeps = 8},
          .substructure = "body"};
}

/// The body, driven by the estimated motion of its lowest mass, moves as in the simulation that the record is from.
TEST(Predict, GivesTheMotionThatWasNotMeasured) {
  const auto found = predict(driven_chain(), chain_record(), chain_prediction());
  EXPECT_EQ(found.failure, "");
  ASSERT_EQ(found.predicted.size(), 8U);  // two of each mass
  EXPECT_EQ(found.estimate.outputs.size(), 1U);
  const std::vector<SensorDescription> truth = {{"x", displacement("body.3")}, {"a", acceleration("body.3")}};
  const auto record =
      simulate(driven_chain(), {.sensors = truth, .duration = 2.0, .sample_rate = 500.0, .tolerance = 1e-4}).record;
  const auto& x = found.at("body.3", of_displacement);
  EXPECT_EQ(x.unit, "m");
  EXPECT_LT(nrmse(x.values, record.values.row(0).transpose()), 0.05);
  EXPECT_LT(nrmse(found.at("body.3", of_acceleration).values, record.values.row(1).transpose()), 0.05);
  // The boundary itself moves as it was estimated.
  const auto& boundary = found.at("body.1", of_displacement).values;
  EXPECT_LT(nrmse(boundary, found.estimate.state("body.1.displacement").mean), 1e-12);
  EXPECT_THAT(refusal_of([&] { return found.at("wheel.w", of_displacement).values; }), HasSubstr("'wheel.w'"));
}

/// The same estimates as without the prediction.
TEST(Predict, DoesNotChangeTheEstimates) {
  const auto options = chain_prediction();
  const auto alone = estimate(driven_chain(), chain_record(), options.estimate);
  const auto found = predict(driven_chain(), chain_record(), options);
  EXPECT_EQ(found.estimate.parameter("suspension.mu_k1").mean, alone.parameter("suspension.mu_k1").mean);
  EXPECT_LT(nrmse(found.estimate.output("top").mean, alone.output("top").mean), 1e-9);
}

TEST(Predict, RefusesWrongArgumentsByTheirPlace) {
  PredictOptions options = chain_prediction();
  options.substructure = "bodi";
  options.steps = 0;
  const auto message = refusal_of([&] { return predict(driven_chain(), chain_record(), options); });
  EXPECT_THAT(message, HasSubstr("substructure: there is no 'bodi' (did you mean 'body'?)"));
  EXPECT_THAT(message, HasSubstr("steps: 0"));
  options = chain_prediction();
  options.substructure = "wheel";  // one mass, at which the suspension ends
  EXPECT_THAT(refusal_of([&] { return predict(driven_chain(), chain_record(), options); }),
              HasSubstr("substructure: "));
  options = chain_prediction();
  options.estimate.unknowns[0].name = "suspension.mu_k9";
  EXPECT_THAT(refusal_of([&] { return predict(driven_chain(), chain_record(), options); }),
              HasSubstr("unknowns[0] 'suspension.mu_k9'"));
}

}  // namespace
}  // namespace kalfem
