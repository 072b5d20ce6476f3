// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/vibration.hpp"

#include <numbers>

#include "cantilever.hpp"

namespace kalfem {
namespace {

using testing::HasSubstr;

constexpr double pi = std::numbers::pi;

/// ground - k, c - 1 (2 kg) - mount - 2 (1 kg).
Structure two_masses() {
  Structure s;
  s.add(lumped("m").mass("1", 2.0).mass("2", 1.0).spring("k", "ground", "1", 3e3, 4.0));
  s.connect("mount", "m.1", "m.2", expression("k*x + k3*x^3 + c*v", {{"k", 1e3}, {"k3", 1e9}, {"c", 2.0}}));
  s.base_displacement("road", "m.ground");
  return s;
}

TEST(Modes, AreThoseOfTheStructureWithItsConnectorsAtRest) {
  const auto found = modes(two_masses());
  ASSERT_EQ(found.dofs, (std::vector<std::string>{"m.1", "m.2"}));
  // det(K - lambda M) = 2 lambda^2 - 6000 lambda + 3e6
  const double root = std::sqrt(6000.0 * 6000.0 - 8.0 * 3e6);
  for (const auto& [i, lambda] : {std::pair{0, (6000.0 - root) / 4.0}, std::pair{1, (6000.0 + root) / 4.0}}) {
    EXPECT_NEAR(found.frequencies[i], std::sqrt(lambda) / (2 * pi), 1e-12 * found.frequencies[i]);
    const Eigen::Vector2d shape = found.shapes.col(i);
    EXPECT_NEAR(2 * shape[0] * shape[0] + shape[1] * shape[1], 1.0, 1e-12);
    const double damping = 4 * shape[0] * shape[0] + 2 * std::pow(shape[1] - shape[0], 2);
    EXPECT_NEAR(found.damping[i], damping / (2 * std::sqrt(lambda)), 1e-12);
  }
}

TEST(Modes, OfASubstructureHaveNoConnectors) {
  const auto found = modes_of(two_masses(), "m");
  EXPECT_EQ(found.frequencies[0], 0.0);
  EXPECT_NEAR(found.frequencies[1], std::sqrt(3e3 / 2.0) / (2 * pi), 1e-12 * found.frequencies[1]);
  EXPECT_THAT(refusal_of([] { return modes_of(two_masses(), "n"); }), HasSubstr("no substructure 'n'"));
}

TEST(FrequencyResponses, SolveTheEquationsOfMotion) {
  Eigen::VectorXd lines(3);
  lines << 0.0, 4.0, 9.0;
  const std::vector<OutputDescription> outputs{displacement("m.1"), acceleration("m.2")};
  const auto of_force = frequency_responses(two_masses(), lines, "m.2", outputs);
  const auto of_road = frequency_responses(two_masses(), lines, "road", outputs);
  for (int i = 0; i < 3; ++i) {
    const std::complex<double> s(0.0, 2 * pi * lines[i]);
    Eigen::Matrix2cd dynamic;
    const auto mount = 1e3 + 2.0 * s, spring = 3e3 + 4.0 * s;
    dynamic << spring + mount + 2.0 * s * s, -mount, -mount, mount + s * s;
    const Eigen::Vector2cd force = dynamic.inverse() * Eigen::Vector2cd(0.0, 1.0);
    const Eigen::Vector2cd road = dynamic.inverse() * Eigen::Vector2cd(spring, 0.0);
    EXPECT_NEAR(std::abs(of_force(i, 0) - force[0]), 0.0, 1e-10 * std::abs(force[0]));
    EXPECT_NEAR(std::abs(of_force(i, 1) - s * s * force[1]), 0.0, 1e-10 * std::abs(s * s * force[1]) + 1e-15);
    EXPECT_NEAR(std::abs(of_road(i, 0) - road[0]), 0.0, 1e-10 * std::abs(road[0]));
  }
}

/// m x'' + c x' + k x = F: one peak at the natural frequency, with its damping, and 1 / (k 2 zeta sqrt(1 - zeta^2))
/// high.
TEST(FrequencyResponses, HaveThePeaksOfTheirModes) {
  Structure s;
  s.add(lumped("m").mass("1", 2.0).spring("k", "ground", "1", 2e3, 4.0));
  s.base_displacement("road", "m.ground");
  const double omega = std::sqrt(1e3), damping = 4.0 / (2.0 * 2.0 * omega);
  const auto found = frequency_responses(s, {.frequencies = Eigen::VectorXd::LinSpaced(1901, 0.5, 10.0),
                                             .inputs = {"m.1", "road"},
                                             .outputs = {displacement("m.1"), acceleration("m.1")}});
  ASSERT_EQ(found.responses.size(), 4U);
  const auto& force = found.responses[0];
  EXPECT_EQ(force.unit, "m/N");
  EXPECT_EQ(found.responses[1].unit, "(m/s^2)/N");
  EXPECT_EQ(found.responses[3].input, "road");
  EXPECT_EQ(force.reduced.size(), 0);
  ASSERT_EQ(force.peaks.size(), 1U);
  // one pole is fitted without its conjugate, which is of the order of the damping ratio squared, .001
  EXPECT_NEAR(force.peaks[0].frequency, omega / (2.0 * pi), 2e-3 * omega / (2.0 * pi));
  EXPECT_NEAR(force.peaks[0].damping.value(), damping, 2e-3 * damping);
  const double highest = 1.0 / (2e3 * 2.0 * damping * std::sqrt(1.0 - damping * damping));
  EXPECT_NEAR(force.peaks[0].magnitude, highest, 1e-3 * highest);
  // of the ground: (k + c s) / (k + c s + m s^2)
  const std::complex<double> line(0.0, 2.0 * pi * 0.5);
  const auto expected = (2e3 + 4.0 * line) / (2e3 + 4.0 * line + 2.0 * line * line);
  EXPECT_NEAR(std::abs(found.responses[2].full[0] - expected), 0.0, 1e-12);
}

/// Both methods and, where the superelement holds the modes of the band, both models agree.
TEST(FrequencyResponses, OfFiniteElementsFullAndReduced) {
  Structure s;
  s.add(cantilever().modal_damping({0.01}, 2000.0).reduce({.modes = {.count = 12, .cutoff = 2000.0}}, {"tip"}));
  FrequencyResponseOptions options{.frequencies = Eigen::VectorXd::LinSpaced(400, 1.0, 100.0),
                                   .inputs = {"beam.tip.z"},
                                   .outputs = {acceleration("beam.tip.z")},
                                   .model = ResponseModel::both};
  const auto modal = frequency_responses(s, options).responses.at(0);
  EXPECT_LT(modal.difference.value().at_resonances.value(), 1e-3);
  EXPECT_LT(modal.difference.value().between.value(), 0.01);
  EXPECT_FALSE(modal.peaks.empty());
  options.method = ResponseMethod::direct;
  const auto direct = frequency_responses(s, options).responses.at(0);
  EXPECT_LT((direct.full - modal.full).norm(), 1e-6 * direct.full.norm());
  options.model = ResponseModel::reduced;
  const auto reduced = frequency_responses(s, options);
  EXPECT_EQ(reduced.responses[0].full.size(), 0);
  EXPECT_FALSE(reduced.full);
  EXPECT_GT(reduced.reduced.value().dofs, 12);
}

TEST(FrequencyResponses, TellEveryWrongArgument) {
  const Eigen::Vector2d descending(2.0, 1.0);
  const auto message = refusal_of([&] {
    return frequency_responses(two_masses(), {.frequencies = descending,
                                              .inputs = {"m.7"},
                                              .outputs = {displacement("m.1"), connector_force("mount")},
                                              .model = ResponseModel::both});
  });
  EXPECT_THAT(message, HasSubstr("frequencies: they do not ascend"));
  EXPECT_THAT(message, HasSubstr("'m.7'"));
  EXPECT_THAT(message, HasSubstr("outputs[1]: output 'mount' is of a connector"));
  EXPECT_THAT(message, HasSubstr("model: there are no finite elements to reduce"));
  Structure full;
  full.add(cantilever());
  EXPECT_THAT(refusal_of([&] {
                return frequency_responses(full, {.frequencies = Eigen::VectorXd::Ones(1),
                                                  .inputs = {"beam.tip.z"},
                                                  .outputs = {displacement("beam.tip.z")},
                                                  .model = ResponseModel::reduced});
              }),
              HasSubstr("model: 'beam' is not to be reduced"));
}

TEST(FrequencyResponses, RefuseWhatIsNoMotionOfAPoint) {
  const Eigen::VectorXd lines = Eigen::VectorXd::Ones(1);
  const auto of = [&](const OutputDescription& output) {
    return frequency_responses(two_masses(), lines, "m.1", {output});
  };
  EXPECT_THAT(refusal_of([&] { return of(connector_force("mount")); }), HasSubstr("is of a connector"));
  EXPECT_THAT(refusal_of([&] { return of(acceleration("m.3")); }), HasSubstr("'m.3'"));
  EXPECT_THAT(refusal_of([&] { return frequency_responses(two_masses(), -lines, "m.1", {displacement("m.1")}); }),
              HasSubstr("frequencies"));
}

TEST(FrequencyResponses, RefuseWhatIsInfinite) {
  Structure s;
  s.add(lumped("free").mass("1", 2.0).mass("2", 2.0).spring("k", "1", "2", 100.0));
  const auto at = [&](double line) {
    return refusal_of(
        [&] { return frequency_responses(s, Eigen::VectorXd::Constant(1, line), "free.1", {displacement("free.2")}); });
  };
  EXPECT_THAT(at(0.0), HasSubstr("can move as a rigid body"));
  EXPECT_THAT(at(10.0 / (2.0 * std::numbers::pi)), HasSubstr("an undamped mode resonates there"));
}

}  // namespace
}  // namespace kalfem
