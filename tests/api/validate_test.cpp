// SPDX-License-Identifier: Apache-2.0
#include "chain.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using testing::HasSubstr;
using testing::IsEmpty;

/// One and a half seconds of the chain's record, from the middle of a motion.
Record later_part() { return cut(chain_record(), 0.5, 2.0); }

double mean_square(const VectorXd& values) { return values.squaredNorm() / static_cast<double>(values.size()); }

/// At the true parameters nothing but the noise is left, in open loop and one sample ahead.
TEST(Validate, LeavesTheNoiseAtTheTruth) {
  const auto found = validate(driven_chain(), chain_record(), {.sensors = chain_sensors(), .from_rest = true});
  EXPECT_EQ(found.failure, "");
  EXPECT_EQ(found.verdict.state(), VerdictState::consistent);
  ASSERT_EQ(found.sensors.size(), 2U);
  for (const auto& sensor : found.sensors) {
    EXPECT_EQ(sensor.unit, "m/s^2");
    // the rms of 1,001 samples of noise is known to 2.2 %
    EXPECT_NEAR(sensor.nrmse / sensor.noise, 1.0, 0.07) << sensor.sensor;
    EXPECT_NEAR(sensor.one_step / sensor.noise, 1.0, 0.07) << sensor.sensor;
  }
}

/// In the middle of a motion the start comes from the lead-in. What is wrong in it dies out slowly, by the damping of
/// the body's modes; from rest the error is that of the start.
TEST(Validate, FindsTheStartInTheLeadIn) {
  const auto found = validate(driven_chain(), later_part(), {.sensors = chain_sensors()});
  EXPECT_DOUBLE_EQ(found.compared_from, 0.65);  // a tenth is the lead-in
  EXPECT_EQ(found.verdict.state(), VerdictState::consistent);
  const auto resting = validate(driven_chain(), later_part(), {.sensors = chain_sensors(), .from_rest = true});
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_LT(found.sensors.at(j).nrmse / found.sensors[j].noise, 1.5);
    EXPECT_GT(resting.sensors.at(j).nrmse / found.sensors[j].noise, 3.0);
  }
}

/// The definitions: rms(simulated - measured) and the noise over rms(measured about its mean), behind the lead-in.
TEST(Validate, ErrorsAreRelativeToTheMotionAboutItsMean) {
  const Record record = later_part();
  const auto found = validate(driven_chain(15.0), record, {.sensors = chain_sensors(), .lead_in = 0.5});
  const Index first = 250, count = record.samples() - first;
  EXPECT_DOUBLE_EQ(found.compared_from, record.time(first));
  for (Index j = 0; j < 2; ++j) {
    const VectorXd measured = record.values.row(j).tail(count), simulated = found.simulated.row(j).tail(count);
    const double size = std::sqrt(mean_square(measured.array() - measured.mean()));
    const auto& sensor = found.sensors[static_cast<std::size_t>(j)];
    EXPECT_NEAR(sensor.nrmse, std::sqrt(mean_square(simulated - measured)) / size, 1e-12);
    EXPECT_NEAR(sensor.noise, 0.3 / size, 1e-12);
    EXPECT_GT(sensor.nrmse, 1.5 * sensor.noise);
  }
}

/// A record of three times the motion under the same road: the error is 2/3 of it.
TEST(Validate, FromRestIsTheSimulationItself) {
  const SimulateOptions options{.sensors = chain_sensors(), .duration = 2.0, .sample_rate = 500.0};
  Record record = simulate(driven_chain(), options).record;
  const Eigen::MatrixXd motion = record.values;
  record.values *= 3.0;
  const auto found = validate(driven_chain(), record, {.sensors = chain_sensors(), .from_rest = true});
  EXPECT_DOUBLE_EQ(found.compared_from, 0.0);
  for (Index j = 0; j < 2; ++j) {
    const VectorXd x = motion.row(j).transpose();
    const double size = std::sqrt(mean_square(x.array() - x.mean()));
    EXPECT_NEAR(found.sensors[static_cast<std::size_t>(j)].nrmse, 2.0 / 3.0 * std::sqrt(mean_square(x)) / size, 2e-3);
  }
}

/// Values of parameters are those of the structure at them.
TEST(Validate, TakesValuesOfParameters) {
  const auto values =
      validate(driven_chain(10.0), later_part(), {.sensors = chain_sensors(), .values = {{"suspension.mu_k1", 20.0}}});
  const auto own = validate(driven_chain(20.0), later_part(), {.sensors = chain_sensors()});
  EXPECT_TRUE(values.simulated == own.simulated);
  EXPECT_EQ(values.sensors[0].one_step, own.sensors[0].one_step);
}

TEST(Validate, AWrongStructureIsAReason) {
  const auto found =
      validate(driven_chain(), later_part(), {.sensors = chain_sensors(), .values = {{"body.2-3.stiffness", 3e3}}});
  ASSERT_THAT(found.verdict.reasons(), testing::Not(IsEmpty()));
  EXPECT_THAT(found.verdict.reasons()[0].code, testing::StartsWith("validation_error"));
  EXPECT_GT(found.sensors[1].nrmse, 0.8);
}

/// A dashpot that drives: the simulation leaves every bound.
TEST(Validate, AnUnstableStructureIsAFailure) {
  Structure s;
  s.add(lumped("m").mass("1", 1.0));
  s.connect("mount", "m.1", "ground", expression("k*x + c*v", {{"k", 1e3}, {"c", 2.0}}));
  s.force("push", "m.1", road());
  const std::vector<SensorDescription> sensors = {{"x", displacement("m.1"), 1e-6}};
  const auto record = simulate(s, {.sensors = sensors, .duration = 2.0, .sample_rate = 500.0, .seed = 1}).record;
  const auto found = validate(s, record, {.sensors = sensors, .values = {{"mount.c", -50.0}}, .from_rest = true});
  EXPECT_NE(found.failure, "");
  EXPECT_EQ(found.verdict.reasons().at(0).code, "validation_failed");
  EXPECT_TRUE(std::isnan(found.sensors.at(0).nrmse));
}

TEST(Validate, RefusesWrongArgumentsByTheirPlace) {
  ValidateOptions options{.sensors = chain_sensors(), .values = {{"suspension.mu_k9", 1.0}}, .lead_in = 4.0};
  options.sensors[1].output = acceleration("body.44");
  const auto message = refusal_of([&] { return validate(driven_chain(), later_part(), options); });
  EXPECT_THAT(message, HasSubstr("values: at 'suspension.mu_k9': there is no parameter of that name"));
  EXPECT_THAT(message, HasSubstr("lead_in: it is 4 s, but the record is 1.5 s long"));
  EXPECT_THAT(message, HasSubstr("sensors[1] 'a5'"));
  options = {.sensors = {{"a9", acceleration("body.2"), 0.3}}};
  EXPECT_THAT(refusal_of([&] {
                return validate(chain_structure().base_displacement("road", "wheel.ground"), later_part(), options);
              }),
              testing::AllOf(HasSubstr("no channel of that name"), HasSubstr("input 'road' has no signal")));
  options = {.sensors = chain_sensors(), .lead_in = 0.1, .from_rest = true};
  EXPECT_THAT(refusal_of([&] { return validate(driven_chain(), later_part(), options); }),
              HasSubstr("lead_in: it is given with from_rest"));
}

/// The road is known for a second only.
TEST(Validate, AnInputMustLastAsLongAsTheRecord) {
  const auto structure =
      chain_structure().base_displacement("road", "wheel.ground", Samples{VectorXd::Zero(501), 500.0, 0.0});
  EXPECT_THAT(refusal_of([&] { return validate(structure, later_part(), {.sensors = chain_sensors()}); }),
              HasSubstr("input 'road'"));
}

}  // namespace
}  // namespace kalfem
