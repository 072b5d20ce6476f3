// SPDX-License-Identifier: Apache-2.0
#include "quarter_car.hpp"

namespace kalfem::quarter_car {
namespace {

TEST(LiveRoadSoak, FindsTheStiffnessInAnHourOfValues) {
  const auto road = road_of(4000.0);
  LiveFilter live = after(drive(4000.0, road), road);
  const auto k3 = live.filter().parameter("strut.k3");
  EXPECT_LT(k3.std, 300.0);
  EXPECT_NEAR(k3.mean, 3e6, 3.0 * k3.std);
  RecordProperty("deviations_off", std::to_string(deviations_off(std::move(live))));
}

}  // namespace
}  // namespace kalfem::quarter_car
