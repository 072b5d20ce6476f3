// SPDX-License-Identifier: Apache-2.0
#include "chain.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using testing::HasSubstr;

/// ground - k1 - 1 (2 kg) - k2 - 2 (1 kg), damped by 4 N s/m at the ground.
Structure tower(double k1, double k2) {
  Structure s;
  s.add(lumped("t").mass("1", 2.0).mass("2", 1.0).spring("k1", "ground", "1", k1, 4.0).spring("k2", "1", "2", k2, 2.0));
  return s;
}

constexpr double k1 = 3e3, k2 = 1e3;

UpdateOptions of(std::vector<UpdateComparison> comparisons) {
  return {.parameters = {{"t.k1.stiffness"}, {"t.k2.stiffness"}}, .comparisons = std::move(comparisons)};
}

void expect_truth(const UpdateResult& found, double tolerance) {
  EXPECT_TRUE(found.converged) << found.reason;
  EXPECT_TRUE(found.usable());
  EXPECT_NEAR(found.parameters.at(0).value, k1, tolerance * k1);
  EXPECT_NEAR(found.parameters.at(1).value, k2, tolerance * k2);
}

/// A force F at the top: u1 = F / k1, u2 - u1 = F / k2, each with its deviation s: dk1 / k1 = s / u1.
TEST(UpdateComparisons, StaticDeflectionsGiveTheSprings) {
  const double force = 10.0, std = 1e-5;
  const MeasuredDeflections measured{
      .forces = {{"t.2", force}}, .displacements = {{"t.1", force / k1}, {"t.2", force / k1 + force / k2}}, .std = std};
  const auto found = update(tower(2.5e3, 1.2e3), of({{.name = "pull", .what = measured}}));
  expect_truth(found, 1e-6);
  EXPECT_NEAR(found.parameters[0].std, std * k1 * k1 / force, 1e-3 * found.parameters[0].std);
  EXPECT_NEAR(found.parameters[1].std, std::sqrt(2.0) * std * k2 * k2 / force, 1e-3 * found.parameters[1].std);
  ASSERT_EQ(found.comparisons.size(), 1U);
  EXPECT_EQ(found.comparisons[0].name, "pull");
  EXPECT_EQ(found.comparisons[0].size, 2);
  EXPECT_GT(found.comparisons[0].rms_before, 1.0);
  EXPECT_LT(found.comparisons[0].rms_after, 1e-3);
}

TEST(UpdateComparisons, FrequencyResponsesGiveTheSprings) {
  const Eigen::VectorXd lines = Eigen::VectorXd::LinSpaced(120, 1.0, 13.0);
  MeasuredResponses measured{
      .input = "t.2", .outputs = {acceleration("t.1"), acceleration("t.2")}, .frequencies = lines};
  measured.values = frequency_responses(tower(k1, k2), lines, measured.input, measured.outputs);
  const auto found = update(tower(2.6e3, 1.1e3), of({{.name = "taps", .what = measured}}));
  expect_truth(found, 1e-6);
  EXPECT_EQ(found.comparisons.at(0).size, 2 * 2 * 120);
  // Peaks that do not overlap: the wide ones do.
  measured.smoothing = 2.0;
  expect_truth(update(tower(1.2e3, 2e3), of({{.name = "taps", .what = measured}})), 1e-6);
}

TEST(UpdateComparisons, ModesWithShapesAreRecognisedByThem) {
  const auto truth = modes(tower(k1, k2));
  MeasuredModes measured{.substructure = "t", .points = {"t.1", "t.2"}, .shapes = truth.shapes};
  for (Index i = 0; i < 2; ++i) measured.frequencies.push_back({truth.frequencies[i], 1e-3 * truth.frequencies[i]});
  measured.shapes.col(1) *= -7.0;
  std::swap(measured.frequencies[0], measured.frequencies[1]);
  measured.shapes.col(0).swap(measured.shapes.col(1));
  const auto found = update(tower(2.5e3, 1.2e3), of({{.name = "modes", .what = measured}}));
  expect_truth(found, 1e-6);
  EXPECT_EQ(found.comparisons.at(0).size, 6);
  ASSERT_EQ(found.frequencies.size(), 2U);
  EXPECT_NEAR(found.frequencies[0].after, truth.frequencies[1], 1e-6 * truth.frequencies[1]);
}

/// The chain's record against its simulation: the stiffness that the record was simulated with, within three
/// deviations.
TEST(UpdateComparisons, ARecordGivesAStiffness) {
  const MeasuredRecord measured{.record = chain_record(), .sensors = chain_sensors(), .settle = 0.1};
  Structure start = driven_chain().at({{"body.2-3.stiffness", 2.8e4}});
  const auto found =
      update(start, {.parameters = {{"body.2-3.stiffness"}}, .comparisons = {{.name = "ride", .what = measured}}});
  EXPECT_TRUE(found.converged) << found.reason;
  EXPECT_NEAR(found.parameters.at(0).value, 3e4, 3.0 * found.parameters[0].std);
  EXPECT_LT(found.parameters[0].std, 0.02 * 3e4);
  EXPECT_NEAR(found.comparisons.at(0).rms_after, 1.0, 0.1);  // noise alone is left
  EXPECT_GT(found.comparisons[0].rms_before, found.comparisons[0].rms_after);
}

/// Weights are inverse variances: four times the weight is half of the deviation.
TEST(UpdateComparisons, WeighLikeVariances) {
  const auto pull = [](double k, double std) {
    return MeasuredDeflections{.forces = {{"t.1", 10.0}}, .displacements = {{"t.1", 10.0 / k}}, .std = std};
  };
  const auto with = [&](double weight, double std) {
    return update(tower(2.9e3, k2), {.parameters = {{"t.k1.stiffness"}},
                                     .comparisons = {{.name = "one", .what = pull(3e3, 1e-5)},
                                                     {.name = "other", .what = pull(3.1e3, std), .weight = weight}}})
        .parameters.at(0)
        .value;
  };
  EXPECT_NEAR(with(4.0, 1e-5), with(1.0, 0.5e-5), 1e-3);
  EXPECT_GT(with(4.0, 1e-5), with(1.0, 1e-5) + 1.0);
}

TEST(UpdateComparisons, RefuseWhatDoesNotFitByItsPlace) {
  const auto refused = [](UpdateOptions options) { return refusal_of([&] { return update(tower(k1, k2), options); }); };
  const MeasuredDeflections pull{.forces = {{"t.2", 1.0}}, .displacements = {{"t.22", 1e-3}}, .std = 1e-5};
  const MeasuredResponses taps{.input = "t.1",
                               .outputs = {acceleration("body.1")},
                               .frequencies = Eigen::VectorXd::Ones(1),
                               .values = Eigen::MatrixXcd::Ones(1, 1)};
  const MeasuredModes shapes{.substructure = "t", .frequencies = {{5.0, 0.1}}, .points = {"t.1"}};
  const auto message = refused(of({{.name = "a", .what = pull},
                                   {.name = "b", .what = taps},
                                   {.name = "c", .what = shapes},
                                   {.name = "d", .what = MeasuredRecord{.record = chain_record(), .sensors = {}}},
                                   {.name = "e", .what = pull, .weight = 0.0}}));
  EXPECT_THAT(message, HasSubstr("comparisons[0] 'a': there is no point '22'"));
  EXPECT_THAT(message, HasSubstr("comparisons[1] 'b': 'body.1' is not a point of 't'"));
  EXPECT_THAT(message, HasSubstr("comparisons[2] 'c': shapes: 0 x 0 values"));
  EXPECT_THAT(message, HasSubstr("comparisons[3] 'd': sensors: the list is empty"));
  EXPECT_THAT(message, HasSubstr("comparisons[4] 'e': weight: it is 0"));
  // A force at the lower mass leaves the upper spring unloaded.
  const MeasuredDeflections low{.forces = {{"t.1", 1.0}}, .displacements = {{"t.1", 1e-3}}, .std = 1e-5};
  EXPECT_THAT(refused(of({{.name = "low", .what = low}})), HasSubstr("no comparison depends on 't.k2.stiffness'"));
}

}  // namespace
}  // namespace kalfem
