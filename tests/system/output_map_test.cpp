// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/sensors/output_map.hpp"

#include <gtest/gtest.h>

#include "kalfem/base/random.hpp"
#include "system/small_systems.hpp"

namespace kalfem {
namespace {

struct Instant {
  Eigen::VectorXd z, v, a, r, r_rate, r_acceleration, f;
};

Instant random_instant(const LocallyNonlinearSystem& system) {
  RandomStream random(3, "instant");
  const auto draw = [&](Eigen::Index n) {
    return Eigen::VectorXd::NullaryExpr(n, [&] { return random.normal(); }).eval();
  };
  const auto n = system.size(), u = system.input_count();
  return {draw(n), draw(n), draw(n), draw(u), draw(u), draw(u), draw(system.connector_count())};
}

double output(const OutputMap& map, Eigen::Index row, const Instant& at) {
  return map.displacement.row(row).dot(at.z) + map.velocity.row(row).dot(at.v) + map.acceleration.row(row).dot(at.a) +
         map.input_value.row(row).dot(at.r) + map.input_rate.row(row).dot(at.r_rate) +
         map.input_acceleration.row(row).dot(at.r_acceleration) + map.force.row(row).dot(at.f);
}

CoupledModel model_on_road() {
  return quarter_chain(2,
                       {{"strut", "wheel.w", "body.1", make_law("linear"), values({5e3, 1.0})},
                        {"stop", "wheel.ground", "body.2", make_law("linear"), values({1e3, 0.0})}},
                       {{"road", InputKind::base_displacement, "wheel.ground"}, {"F", InputKind::force, "body.2"}});
}

TEST(OutputMap, EveryQuantityOfAPointAndOfAConnector) {
  const auto model = model_on_road();
  using Q = ObservedQuantity;
  const auto map = make_outputs(model, {{"d", Q::displacement, {{"body.1", 1.0}}},
                                        {"v", Q::velocity, {{"body.1", 1.0}}},
                                        {"a", Q::acceleration, {{"body.1", 1.0}}},
                                        {"g", Q::acceleration, {{"wheel.ground", 1.0}}},
                                        {"across", Q::displacement, {{"body.2", 1.0}, {"wheel.ground", -1.0}}},
                                        {"force", Q::connector_force, {{"stop", 1.0}}},
                                        {"stroke", Q::connector_deformation, {{"stop", 1.0}}},
                                        {"rate", Q::connector_rate, {{"stop", 1.0}}}});
  const auto at = random_instant(model.system());
  EXPECT_EQ(output(map, 0, at), at.z[1]);
  EXPECT_EQ(output(map, 1, at), at.v[1]);
  EXPECT_EQ(output(map, 2, at), at.a[1]);
  EXPECT_EQ(output(map, 3, at), at.r_acceleration[0]);
  EXPECT_EQ(output(map, 4, at), at.z[2] - at.r[0]);
  EXPECT_EQ(output(map, 5, at), at.f[1]);
  EXPECT_EQ(output(map, 6, at), at.z[2] - at.r[0]);
  EXPECT_EQ(output(map, 7, at), at.v[2] - at.r_rate[0]);
  EXPECT_EQ(map.units, (std::vector<std::string>{"m", "m/s", "m/s^2", "m/s^2", "m", "N", "m", "m/s"}));
}

TEST(OutputMap, SeveralConnectorsAddUpByTheirWeights) {
  const auto model = model_on_road();
  using Q = ObservedQuantity;
  const auto map = make_outputs(model, {{"force", Q::connector_force, {{"stop", 2.0}, {"strut", -3.0}}},
                                        {"stroke", Q::connector_deformation, {{"stop", 2.0}, {"strut", -3.0}}},
                                        {"rate", Q::connector_rate, {{"stop", 0.5}}}});
  const auto at = random_instant(model.system());
  // sums of three terms
  EXPECT_NEAR(output(map, 0, at), 2.0 * at.f[1] - 3.0 * at.f[0], 1e-14);
  EXPECT_NEAR(output(map, 1, at), 2.0 * (at.z[2] - at.r[0]) - 3.0 * (at.z[1] - at.z[0]), 1e-14);
  EXPECT_NEAR(output(map, 2, at), 0.5 * (at.v[2] - at.r_rate[0]), 1e-14);
}

TEST(OutputMap, AccelerationUnderBaseAccelerationIsAbsoluteUnlessAskedOtherwise) {
  const auto model = oscillator(1.0, 1.0, 1e3, {}, {{"quake", InputKind::base_acceleration, ""}});
  const auto map = make_outputs(model, {{"absolute", ObservedQuantity::acceleration, {{"body.x", 1.0}}},
                                        {"relative", ObservedQuantity::acceleration, {{"body.x", 1.0}}, true}});
  const auto at = random_instant(model.system());
  EXPECT_EQ(output(map, 0, at), at.a[0] + at.r[0]);
  EXPECT_EQ(output(map, 1, at), at.a[0]);
}

TEST(OutputMap, EveryUnknownPointIsNamedWithItsSensor) {
  try {
    make_outputs(model_on_road(), {{"s1", ObservedQuantity::acceleration, {{"body.11", 1.0}}},
                                   {"s2", ObservedQuantity::connector_force, {{"struts", 1.0}}},
                                   {"s3", ObservedQuantity::displacement, {}}});
    FAIL() << "accepted";
  } catch (const InvalidInput& error) {
    const std::string message = error.what();
    for (const char* part :
         {"sensor 's1'", "did you mean 'body.1'?", "sensor 's2'", "did you mean 'strut'?", "sensor 's3'"})
      EXPECT_NE(message.find(part), std::string::npos) << part << "\n" << message;
  }
}

}  // namespace
}  // namespace kalfem
