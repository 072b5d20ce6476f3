// SPDX-License-Identifier: Apache-2.0
#include "chain.hpp"

// A live filter whose covariance becomes indefinite by rounding in modal coordinates.

namespace kalfem {
namespace {

/// Two oscillators next to critical damping, almost alike and almost uncoupled: four poles within 5 % of each other, a
/// basis of modes with a condition number of 1e4.
Structure nearly_defective_pair() {
  const double k = 1000.0, c = 63.308798756570944;
  Structure s;
  s.add(lumped("s")
            .mass("a", 1.0)
            .mass("b", 1.0)
            .spring("k1", "ground", "a", k, c)
            .spring("k2", "ground", "b", 1.001 * k, c)
            .spring("k3", "a", "b", 1e-3));
  s.connect("n", "s.a", "s.b", law("cubic", {{"k3", 1e3}}));
  s.force("f", "s.a", make_random({.rms = 10.0, .lower = 0.5, .upper = 30.0, .duration = 2.0, .seed = 7}));
  return s;
}

EstimateOptions precise_sensor_and_unknown_start() {
  return {.sensors = {{"x", acceleration("s.b"), 1e-6}},
          .unknowns = {{"n.k3", {.initial = 500.0, .std = 300.0}}},
          .initial_state = {{"all", {.displacement_std = 10.0, .velocity_std = 1e-6}}},
          .step_order = 2};
}

TEST(OnlineFilter, GoesOnInPhysicalCoordinatesWhereRoundingSpoilsTheModalOnes) {
  const Structure s = nearly_defective_pair();
  const EstimateOptions options = precise_sensor_and_unknown_start();
  const auto record =
      simulate(s, {.sensors = options.sensors, .duration = 1.0, .sample_rate = 500.0, .seed = 1}).record;
  // The whole run starts again in physical coordinates.
  const auto expected = estimate(s, record, options);
  ASSERT_TRUE(expected.usable());
  ASSERT_THAT(expected.filter, testing::HasSubstr("rounding errors in modal ones"));

  OnlineFilter filter(s, record.sample_rate, options);
  ASSERT_FALSE(filter.in_physical_coordinates());
  filter.update(record.values.col(0));
  for (Eigen::Index k = 1; k < record.samples(); ++k) {
    ASSERT_TRUE(filter.predict()) << filter.failure()->reason;
    ASSERT_TRUE(filter.update(record.values.col(k))) << filter.failure()->reason;
  }
  EXPECT_TRUE(filter.in_physical_coordinates());
  const auto found = filter.parameter("n.k3");
  EXPECT_NEAR(found.mean, 1e3, 4.0 * found.std);
  EXPECT_NEAR(found.mean, expected.parameters[0].mean, 3.0 * expected.parameters[0].std);
  EXPECT_LT(found.std, 30.0);
}

TEST(OnlineFilter, StaysInModalCoordinatesWhereTheyServe) {
  OnlineFilter filter(driven_chain(), chain_record().sample_rate, {.sensors = chain_sensors()});
  for (Eigen::Index k = 0; k < 100; ++k) {
    if (k > 0) ASSERT_TRUE(filter.predict());
    ASSERT_TRUE(filter.update(chain_record().values.col(k)));
  }
  EXPECT_FALSE(filter.in_physical_coordinates());
}

}  // namespace
}  // namespace kalfem
