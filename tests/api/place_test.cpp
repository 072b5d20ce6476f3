// SPDX-License-Identifier: Apache-2.0
#include "chain.hpp"

namespace kalfem {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

PlaceOptions chain_question() {
  PlaceOptions options{.count = 2, .duration = 2.0, .sample_rate = 500.0};
  for (const std::string mass : {"1", "2", "3", "4"})
    options.candidates.push_back({"a" + mass, acceleration("body." + mass), 0.3});
  options.unknowns = {{"suspension.mu_k1", {.initial = 20.0, .std = 5.0}},
                      {"body.3-4.stiffness", {.initial = 3e4, .std = 5e3}}};
  return options;
}

TEST(PlaceSensors, RanksEverySetByWhatItTells) {
  const auto found = place(driven_chain(), chain_question());
  EXPECT_TRUE(found.exact);
  EXPECT_EQ(found.best.size(), 6U);
  EXPECT_THAT(found.parameters, ElementsAre("suspension.mu_k1", "body.3-4.stiffness"));
  for (Eigen::Index i = 0; i < 2; ++i) EXPECT_LT(found.best[0].std[i], found.prior[i]);
  // The bound of the best set by an estimation from its sensors: both know the excitation and rest at the start.
  EstimateOptions estimation{.unknowns = chain_question().unknowns, .substeps = 8};
  for (const auto& name : found.best[0].sensors)
    for (const auto& each : chain_question().candidates)
      if (each.name == name) estimation.sensors.push_back(each);
  const auto record =
      simulate(driven_chain(), {.sensors = estimation.sensors, .duration = 2.0, .sample_rate = 500.0, .seed = 3})
          .record;
  const auto estimated = estimate(driven_chain(), record, estimation);
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_NEAR(estimated.parameters[i].std / found.best[0].std[static_cast<Eigen::Index>(i)], 1.0, 0.2);
}

TEST(PlaceSensors, KeepsThoseThatStay) {
  PlaceOptions options = chain_question();
  options.keep = {"a1"};
  options.count = 1;
  const auto found = place(driven_chain(), options);
  EXPECT_EQ(found.best.size(), 3U);
  for (const auto& set : found.best) EXPECT_EQ(set.sensors.front(), "a1");
}

TEST(PlaceSensors, KnowsWellWhatItIsAskedFor) {
  PlaceOptions options = chain_question();
  options.parameters = {"body.3-4.stiffness"};
  options.count = 1;
  const auto found = place(driven_chain(), options);
  EXPECT_THAT(found.parameters, ElementsAre("body.3-4.stiffness"));
  for (std::size_t i = 1; i < found.best.size(); ++i) EXPECT_GE(found.best[i].std[0], found.best[0].std[0]);
}

/// A neighbouring stiffness that is known to 5 % only leaves more in the one that is asked for, as an unknown with that
/// prior does.
TEST(PlaceSensors, HoldsWhatIsKnownOfFixedNumbers) {
  PlaceOptions options = chain_question();
  options.unknowns = {{"body.3-4.stiffness", {.initial = 3e4, .std = 5e3, .transform = ParameterTransform{}}}};
  options.count = 1;
  const auto exact = place(driven_chain(), options);
  options.known_to = {{.name = "body.2-3.stiffness", .deviation = 0.05}};
  const auto stated = place(driven_chain(), options);
  EXPECT_THAT(stated.parameters, ElementsAre("body.3-4.stiffness"));
  options.known_to.clear();
  options.unknowns.push_back(
      {"body.2-3.stiffness", {.std = 0.05 * 3e4, .transform = ParameterTransform(TransformKind::log)}});
  options.parameters = {"body.3-4.stiffness"};
  const auto unknown = place(driven_chain(), options);
  EXPECT_EQ(stated.best[0].sensors, unknown.best[0].sensors);
  EXPECT_NEAR(stated.best[0].std[0], unknown.best[0].std[0], 1e-6 * unknown.best[0].std[0]);
  EXPECT_GT(stated.best[0].std[0], exact.best[0].std[0]);
}

TEST(PlaceSensors, RefusesWrongArgumentsByTheirPlace) {
  PlaceOptions options = chain_question();
  options.keep = {"a9"};
  options.count = 4;
  options.duration = 0.0;
  options.parameters = {"body.3-4.stifness"};
  const auto message = refusal_of([&] { return place(driven_chain(), options); });
  EXPECT_THAT(message, HasSubstr("keep: there is no 'a9'"));
  EXPECT_THAT(message,
              HasSubstr("count: 4 sensors are to be placed, but there are 3 candidates beside those of `keep`"));
  EXPECT_THAT(message, HasSubstr("duration: it is 0 s"));
  EXPECT_THAT(message, HasSubstr("did you mean 'body.3-4.stiffness'?"));
  EXPECT_THAT(
      refusal_of([&] { return place(chain_structure().base_displacement("road", "wheel.ground"), chain_question()); }),
      HasSubstr("road"));
}

}  // namespace
}  // namespace kalfem
