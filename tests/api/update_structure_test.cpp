// SPDX-License-Identifier: Apache-2.0
#include "cantilever.hpp"

namespace kalfem {
namespace {

using testing::HasSubstr;

UpdateOptions measured_beam() {
  const double truth = first_frequency(210e9);
  return {
      .substructure = "beam", .frequencies = {{truth, 0.001 * truth}}, .parameters = {{"beam.steel.youngs_modulus"}}};
}

TEST(UpdateStructure, FindsTheModulusThatHasTheMeasuredFrequency) {
  Structure s;
  s.add(cantilever(180e9));
  const auto result = update(s, measured_beam());
  EXPECT_TRUE(result.converged) << result.reason;
  EXPECT_NEAR(result.parameters[0].value, 210e9, 1e-3 * 210e9);
  EXPECT_NEAR(result.parameters[0].std, 2e-3 * 210e9, 2e-5 * 210e9);  // dE / E = 2 df / f
  EXPECT_NEAR(result.frequencies[0].before, first_frequency(180e9), 1e-3 * first_frequency());
  EXPECT_NEAR(result.frequencies[0].after, first_frequency(210e9), 1e-4 * first_frequency());
}

TEST(UpdateStructure, WeighsThePriorAgainstTheMeasurement) {
  Structure s;
  s.add(cantilever(180e9));
  UpdateOptions options = measured_beam();
  options.parameters[0].range.std = 1e5;  // known far better than the frequency tells
  EXPECT_NEAR(update(s, options).parameters[0].value, 180e9, 1e6);
}

TEST(UpdateStructure, WrongArgumentsAreNamedByTheirPlace) {
  Structure s = chain_structure();
  s.add(cantilever());
  const auto refused = [&](UpdateOptions options) { return refusal_of([&] { return update(s, options); }); };
  UpdateOptions options = measured_beam();
  options.parameters = {{"beam.steel.young"}, {"suspension.k"}, {"beam.steel.density", {.initial = -1.0}}};
  const auto message = refused(options);
  EXPECT_THAT(message, HasSubstr("parameters[0] 'beam.steel.young': there is no parameter 'beam.steel.young'"));
  EXPECT_THAT(message, HasSubstr("parameters[1] 'suspension.k': the modes of 'beam' do not depend on it"));
  EXPECT_THAT(message, HasSubstr("parameters[2] 'beam.steel.density': "));
  options = measured_beam();
  options.frequencies = {{0.0, 1.0}};
  EXPECT_THAT(refused(options), HasSubstr("frequencies[0]: 0 Hz"));
  options.frequencies.clear();
  EXPECT_THAT(refused(options), HasSubstr("frequencies: the list is empty"));
  options.parameters.clear();
  EXPECT_THAT(refused(options), HasSubstr("parameters: the list is empty"));
}

}  // namespace
}  // namespace kalfem
