// SPDX-License-Identifier: Apache-2.0
#include "chain.hpp"

namespace kalfem {
namespace {

using testing::HasSubstr;

const EstimateOptions options{.sensors = chain_sensors(),
                              .unknowns = {{"suspension.mu_k1", {.initial = 10.0, .std = 5.0}}},
                              .outputs = {{"force", connector_force("suspension")}},
                              .substeps = 4,
                              .diagnose = false};

TEST(OnlineFilter, GivesWhatAWholeRunOverTheRecordGives) {
  Record record = chain_record();
  record.values(0, 100) = record.values(0, 101) = record.values(1, 101) = std::nan("");
  const auto expected = estimate(driven_chain(), record, options);
  OnlineFilter filter(driven_chain(), record.sample_rate, options);
  for (Eigen::Index k = 0; k < record.samples(); ++k) {
    if (k > 0) ASSERT_TRUE(filter.predict());
    ASSERT_TRUE(filter.update(record.values.col(k)));
    if (std::isfinite(expected.nis[k])) ASSERT_NEAR(filter.nis(), expected.nis[k], 1e-8 * (1.0 + expected.nis[k]));
  }
  const auto& parameter = expected.parameters[0];
  EXPECT_NEAR(filter.parameter("suspension.mu_k1").mean, parameter.mean, 1e-9 * parameter.mean);
  EXPECT_NEAR(filter.parameters()[0].std, parameter.std, 1e-9 * parameter.std);
  const auto& force = expected.output("force");
  EXPECT_NEAR(filter.state("force").mean, force.mean[record.samples() - 1], 1e-7);
  EXPECT_NEAR(filter.state("force").std, force.std[record.samples() - 1], 1e-7);
  EXPECT_NEAR(filter.time(), static_cast<double>(record.samples() - 1) / record.sample_rate, 1e-12);
}

TEST(OnlineFilter, FollowsTheLinearPartAsAWholeRunDoes) {
  // The damping of the body's modes follows a released spring: the filter's model is relinearised on the way.
  EstimateOptions of_spring = options;
  of_spring.unknowns = {{"body.2-3.stiffness", {.initial = 2e4, .std = 8e3}}};
  const auto& record = chain_record();
  const auto expected = estimate(driven_chain(), record, of_spring);
  OnlineFilter filter(driven_chain(), record.sample_rate, of_spring);
  filter.update(record.values.col(0));
  for (Eigen::Index k = 1; k < record.samples(); ++k) {
    ASSERT_TRUE(filter.predict());
    ASSERT_TRUE(filter.update(record.values.col(k)));
  }
  EXPECT_NEAR(filter.parameters()[0].mean, expected.parameters[0].mean, 1e-7 * expected.parameters[0].mean);
}

TEST(OnlineFilter, IsToldItsInputsAsTheyCome) {
  const auto& record = chain_record();
  const auto samples = road()->sample(0.0, 1.0 / record.sample_rate, record.samples());
  for (const auto substeps : {std::optional<int>(4), std::optional<int>(), std::optional<int>(16)}) {
    EstimateOptions with_substeps = options;
    with_substeps.substeps = substeps;
    OnlineFilter filter(chain_structure().base_displacement("road", "wheel.ground"), record.sample_rate, with_substeps);
    filter.start({{samples(0, 0), samples(0, 1), samples(0, 2)}});
    filter.update(record.values.col(0));
    for (Eigen::Index k = 1; k < record.samples(); ++k) {
      ASSERT_TRUE(filter.predict({{samples(k, 0), samples(k, 1), samples(k, 2)}}));
      ASSERT_TRUE(filter.update(record.values.col(k)));
    }
    const auto estimate = filter.parameter("suspension.mu_k1");
    EXPECT_NEAR(estimate.mean, 20.0, 3.0 * estimate.std) << substeps.value_or(8);
  }
}

TEST(OnlineFilter, RefusesWhatItCannotUse) {
  const Structure live = chain_structure().base_displacement("road", "wheel.ground");
  OnlineFilter filter(live, 500.0, options);
  EXPECT_THAT(refusal_of([&] { filter.predict(); }), HasSubstr("input 'road' has no signal"));
  EXPECT_THAT(refusal_of([&] { filter.predict({}); }), HasSubstr("0 inputs are given"));
  EXPECT_THAT(refusal_of([&] { filter.predict({{std::nan("")}}); }), HasSubstr("inputs[0] is not finite"));
  EXPECT_THAT(refusal_of([&] { filter.update(Eigen::VectorXd::Zero(3)); }), HasSubstr("update() is given 3 values"));
  EXPECT_THAT(refusal_of([&] { return filter.parameter("suspension.mu_k2"); }),
              HasSubstr("(did you mean 'suspension.mu_k1'?)"));
  EXPECT_THAT(refusal_of([&] { return filter.state("forse"); }), HasSubstr("(did you mean 'force'?)"));
  EstimateOptions of_record = options;
  of_record.initial_state_from_record = true;
  EXPECT_THAT(refusal_of([&] { OnlineFilter(live, 500.0, of_record); }),
              HasSubstr("initial_state_from_record needs a whole record"));
  EXPECT_THAT(refusal_of([&] { OnlineFilter(live, 0.0, options); }), HasSubstr("the sampling rate is 0 Hz"));
}

}  // namespace
}  // namespace kalfem
