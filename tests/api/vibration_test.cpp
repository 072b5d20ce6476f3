// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/vibration.hpp"

#include <numbers>

#include "chain.hpp"

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
