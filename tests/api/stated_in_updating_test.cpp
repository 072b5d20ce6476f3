// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <random>

#include "chain.hpp"

// Numbers that an updating holds fixed, and that are known to a stated deviation.

namespace kalfem {
namespace {

using Eigen::Index;
using testing::HasSubstr;

struct Given {
  double mass = 2.0, damping = 4.0, gain = 1.0;  ///< of the lower mass [kg]; of its dashpot [N s/m]; of a response
};

/// ground - k1 - 1 - k2 - 2 (1 kg).
Structure tower(double k1, double k2, const Given& given = {}) {
  Structure s;
  s.add(lumped("t")
            .mass("1", given.mass)
            .mass("2", 1.0)
            .spring("k1", "ground", "1", k1, given.damping)
            .spring("k2", "1", "2", k2, 2.0));
  return s;
}

constexpr double k1 = 3e3, k2 = 1e3;

MeasuredModes measured_modes(const Structure& truth) {
  const auto found = modes(truth);
  MeasuredModes measured{.substructure = "t", .points = {"t.1", "t.2"}, .shapes = found.shapes};
  for (const double f : found.frequencies) measured.frequencies.push_back({f, 2e-3 * f});
  return measured;
}

MeasuredResponses measured_responses(const Structure& truth, double gain = 1.0) {
  MeasuredResponses measured{.input = "t.2",
                             .outputs = {acceleration("t.1"), acceleration("t.2")},
                             .frequencies = Eigen::VectorXd::LinSpaced(120, 1.0, 13.0)};
  measured.values = frequency_responses(truth, measured.frequencies, measured.input, measured.outputs);
  measured.values.col(0) *= gain;
  return measured;
}

UpdateResult updated(const UpdateComparison& comparison, const Given& model, std::vector<KnownTo> known_to) {
  return update(tower(2.9e3, 1.02e3, model), {.parameters = {{"t.k1.stiffness"}, {"t.k2.stiffness"}},
                                              .comparisons = {comparison},
                                              .known_to = std::move(known_to),
                                              .tolerance = 1e-10});
}

const StatedNumber& stated(const UpdateResult& result, const std::string& name) {
  return *std::ranges::find(result.stated_numbers, name, &StatedNumber::name);
}

/// d(estimate)/d(number) against whole updatings beside it. Great weights make the searches end close to their minima.
TEST(StatedInUpdating, ShiftsAreThoseOfWholeUpdatings) {
  constexpr double great = 1e10;
  const std::vector<UpdateComparison> comparisons{
      {.name = "modes", .what = measured_modes(tower(k1, k2)), .weight = great},
      {.name = "taps", .what = measured_responses(tower(k1, k2)), .weight = great}};
  constexpr double h = 1e-3;
  for (const auto& comparison : comparisons) {
    const auto found = updated(comparison, {}, {{.name = "t.1.mass", .deviation = 0.01}});
    const auto above = updated(comparison, {.mass = 2.0 * (1.0 + h)}, {}),
               below = updated(comparison, {.mass = 2.0 * (1.0 - h)}, {});
    ASSERT_EQ(found.stated_numbers.size(), 1U);
    EXPECT_DOUBLE_EQ(found.stated_numbers[0].known_to, 0.02);
    const double size = std::abs(found.stated_numbers[0].shift[0]);  // the larger one
    for (std::size_t j = 0; j < 2; ++j) {
      const double shift = (above.parameters[j].value - below.parameters[j].value) / (4.0 * h);
      EXPECT_NEAR(found.stated_numbers[0].shift[j], shift, 5e-3 * size) << comparison.name;
      const auto& parameter = found.parameters[j];
      const double added = std::abs(found.stated_numbers[0].shift[j]) * 0.02;
      EXPECT_NEAR(parameter.std_considered, std::hypot(parameter.std, added), 1e-9 * parameter.std_considered);
      const double half = 0.5 * (parameter.interval_95.upper - parameter.interval_95.lower);
      EXPECT_GE(half, 1.959 * parameter.std_considered);
    }
  }
}

/// A response's gain alone: r depends on it as on its logarithm.
TEST(StatedInUpdating, GainsOfResponsesAreNumbers) {
  constexpr double h = 1e-3;
  const auto with = [&](double gain) {
    return updated({.name = "taps", .what = measured_responses(tower(k1, k2), gain)}, {},
                   {{.name = "1.gain", .deviation = 0.02}});
  };
  const auto found = with(1.0), above = with(1.0 + h), below = with(1.0 - h);
  for (std::size_t j = 0; j < 2; ++j) {
    const double shift = (above.parameters[j].value - below.parameters[j].value) / (2.0 * h);
    EXPECT_NEAR(stated(found, "1.gain").shift[j], shift, 5e-3 * std::abs(shift) + 1e-6);
  }
}

/// A mass 1 % heavier than stated is no misfit where it is known to 1 %, and the data ask for it.
TEST(StatedInUpdating, AFitWithinWhatIsStatedIsNoMisfit) {
  const auto truth = tower(k1, k2, {.mass = 2.03});
  UpdateComparison both{.name = "modes", .what = measured_modes(truth)};
  UpdateOptions options{
      .parameters = {{"t.k1.stiffness"}},
      .comparisons = {both},
      .known_to = {{.name = "masses", .deviation = 0.015}, {.name = "t.k2.stiffness", .deviation = 1e-4}}};
  const auto considered = update(tower(2.9e3, k2), options);
  options.known_to.clear();
  const auto exact = update(tower(2.9e3, k2), options);
  EXPECT_LT(considered.comparisons[0].rms_after, 0.5 * exact.comparisons[0].rms_after);
  EXPECT_NEAR(considered.parameters[0].value, exact.parameters[0].value, 1e-9 * k1);  // the estimates do not move
  EXPECT_LT(considered.parameters[0].interval_95.lower, k1);
  EXPECT_GT(considered.parameters[0].interval_95.upper, k1);
}

TEST(StatedInUpdating, RefusesWhatCannotBeStated) {
  const auto message = refusal_of([&] {
    return updated({.name = "modes", .what = measured_modes(tower(k1, k2))}, {},
                   {{.name = "t.3.mass", .deviation = 0.01},
                    {.name = "t.k1.stiffness", .deviation = 0.01},
                    {.name = "masses", .deviation = 0.0},
                    {.name = "damping", .deviation = 1.2}});
  });
  EXPECT_THAT(message, HasSubstr("known_to.t.3.mass: no fixed number has this name (did you mean 't."));
  EXPECT_THAT(message, HasSubstr("known_to.t.k1.stiffness: it is estimated"));
  EXPECT_THAT(message, HasSubstr("known_to.masses: it is 0"));
  EXPECT_THAT(message, HasSubstr("known_to.damping: it is 120 %"));
}

}  // namespace
}  // namespace kalfem
