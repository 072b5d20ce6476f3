// SPDX-License-Identifier: Apache-2.0
#include "quarter_car.hpp"

namespace kalfem::quarter_car {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

TEST(LiveRoad, FindsTheStiffnessFromValuesAlone) {
  const auto road = road_of(80.0);
  const Record record = drive(80.0, road);
  EXPECT_LT(deviations_off(after(record, road)), 3.0);
  EXPECT_LT(deviations_off(after(record, road, {.input_delay = 2})), 3.0);
  EXPECT_GT(deviations_off(after(record, road, {.input_delay = 0})), 100.0);  // a staircase of velocity
}

TEST(LiveRoad, IsAsGoodAsTheWholeRecordsSpline) {
  const auto road = road_of(20.0);
  const Record record = drive(20.0, road);
  LiveFilter live = after(record, road);
  const Samples samples{road->sample(0.0, 1.0 / rate, record.samples()).col(0).matrix(), rate};
  const auto whole =
      estimate(structure(2e6).base_displacement("road", "wheel.ground", samples), record,
               {.sensors = sensors, .unknowns = {{"strut.k3", {.std = 2e6}}}, .substeps = 8, .diagnose = false});
  const auto& expected = whole.parameter("strut.k3");
  EXPECT_NEAR(live.filter().parameter("strut.k3").mean, expected.mean, 1e-2 * expected.std);
  EXPECT_NEAR(live.filter().time(), 20.0, 1e-9);
}

TEST(LiveRoad, StaysBehindItsInputs) {
  const auto road = road_of(2.0);
  const Record record = drive(2.0, road);
  const VectorXd values = road->sample(0.0, 1.0 / rate, record.samples()).col(0).matrix();
  OnlineFilter filter(structure(2e6).base_displacement("road", "wheel.ground"), rate,
                      {.sensors = sensors, .unknowns = {{"strut.k3", {.std = 2e6}}}}, {.input_delay = 5});
  filter.start(values.head(1));
  for (Index k = 0; k < 100; ++k) {
    if (k > 0) ASSERT_TRUE(filter.predict_values(values.segment(k, 1)));
    ASSERT_TRUE(filter.update(record.values.col(k)));
    ASSERT_NEAR(filter.time(), static_cast<double>(std::max<Index>(0, k - 5)) / rate, 1e-12);
  }
  EXPECT_THAT(refusal_of([&] { filter.predict({{0.0, 0.0, 0.0}}); }), testing::HasSubstr("call finish() first"));
  ASSERT_TRUE(filter.finish());
  EXPECT_NEAR(filter.time(), 99 / rate, 1e-12);
  EXPECT_TRUE(filter.predict({{0.0, 0.0, 0.0}}));
  EXPECT_THAT(refusal_of([&] {
                OnlineFilter(structure(2e6).base_displacement("road", "wheel.ground"), rate, {.sensors = sensors},
                             {.input_delay = -1, .window = 3});
              }),
              testing::AllOf(testing::HasSubstr("input_delay: -1"), testing::HasSubstr("window: 3")));
}

TEST(LiveRoad, IsNotUsableWhileASensorIsDead) {
  const auto road = road_of(60.0);
  Record record = drive(60.0, road);
  EXPECT_TRUE(after(record, road).filter().usable());
  record.values.row(0).tail(20000).setConstant(record.values(0, 10000));
  LiveFilter live = after(record, road);
  EXPECT_TRUE(live.filter().running());
  EXPECT_FALSE(live.filter().usable());
  ASSERT_FALSE(live.filter().verdict().reasons().empty());
  EXPECT_THAT(live.filter().verdict().reasons().front().subject, testing::AnyOf("wheel", "all sensors"));
  const auto consistency = live.filter().consistency();
  EXPECT_EQ(consistency.expected_nis, 2.0);
  EXPECT_GT(consistency.mean_nis, 20.0);
}

}  // namespace
}  // namespace kalfem::quarter_car
