// SPDX-License-Identifier: Apache-2.0
#include <sstream>

#include "chain.hpp"

// What a reader of docs/library.md writes first, and laws of their own in it.

namespace kalfem {
namespace {

using testing::HasSubstr;

constexpr double rate = 500.0, duration = 2.0;

/// The displacement of the road as samples with their rate.
Samples sampled_road() {
  const auto count = static_cast<Eigen::Index>(rate * (duration + 0.1));
  return {make_random({.rms = 3e-3, .lower = 0.5, .upper = 30.0, .duration = 4.0, .seed = 7})
              ->sample(0.0, 1.0 / rate, count)
              .col(0)
              .matrix(),
          rate};
}

/// The body's record over that road.
Record record_of(const Law& suspension) {
  Structure s;
  s.add(lumped("wheel").mass("w", 1.5).spring("k_w", "ground", "w", 2e4));
  s.add(chain("body", 10, 1.0, 3e4).modal_damping(0.01));
  s.connect("suspension", "wheel.w", "body.1", suspension);
  s.base_displacement("road", "wheel.ground", sampled_road());
  return simulate(
             s,
             {.sensors = {{"a3", acceleration("body.2"), 0.3}}, .duration = duration, .sample_rate = rate, .seed = 1})
      .record;
}

TEST(FirstProgram, FindsTheParameterOfTheSuspension) {
  const Samples road = sampled_road();
  const Record record = record_of(law("saturating", {{"k", 5e3}, {"mu_k1", 20.0}}));
  std::ostringstream out;

  Structure s;
  s.add(lumped("wheel").mass("w", 1.5).spring("k_w", "ground", "w", 2e4));
  s.add(chain("body", 10, 1.0, 3e4).modal_damping(0.01));
  s.connect("suspension", "wheel.w", "body.1", law("saturating", {{"k", 5e3}, {"mu_k1", 20.0}}));
  s.base_displacement("road", "wheel.ground", road);
  const auto result = estimate(s, record,
                               {.sensors = {{"a3", acceleration("body.2"), 0.3}},
                                .unknowns = {{"suspension.mu_k1", {.initial = 10, .std = 5}}}});
  for (const auto& p : result.parameters) out << p.name << ' ' << p.mean << " +- " << p.std << '\n';

  EXPECT_THAT(out.str(), HasSubstr("suspension.mu_k1 "));
  // Two substeps are not enough: noise is next to none, and the road has but 17 samples in its shortest wave.
  // The usual filter steps end before the bias of the substeps is small; the interval holds what is left of it.
  EXPECT_LT(result.parameters[0].interval_95.lower, 20.0);
  EXPECT_GT(result.parameters[0].interval_95.upper, 20.0);
  EXPECT_LT(result.parameters[0].std, 0.01);
  EXPECT_GE(result.substeps, 4);
}

/// A spring with a term of third order and exact tangents.
class HardeningSpring final : public ConnectorLaw {
public:
  [[nodiscard]] std::string name() const override { return "hardening"; }
  [[nodiscard]] const std::vector<LawQuantity>& parameters() const override { return parameters_; }
  [[nodiscard]] const std::vector<LawQuantity>& states() const override { return states_; }
  [[nodiscard]] bool uses_acceleration() const override { return false; }
  void respond(const LawPoints& points, LawResponse response) const override {
    const auto k = points.parameters.col(0), k3 = points.parameters.col(1), c = points.parameters.col(2);
    const auto& d = points.deformation;
    response.force = k * d + k3 * d.cube() + c * points.rate;
    response.stiffness = k + 3.0 * k3 * d.square();
    response.damping = c;
    response.inertance.setZero();
  }

private:
  std::vector<LawQuantity> parameters_ = {{"k", "N/m"}, {"k3", "N/m^3"}, {"c", "N s/m"}}, states_;
};

TEST(FirstProgram, EstimatesAnUnknownOfALawThatIsAClassOfTheUsers) {
  const auto own = std::make_shared<const HardeningSpring>();
  const auto suspension = [&](double k3) { return law(own, {{"k", 5e3}, {"k3", k3}, {"c", 10.0}}); };
  const auto record = record_of(suspension(5e7));
  Structure s;
  s.add(lumped("wheel").mass("w", 1.5).spring("k_w", "ground", "w", 2e4));
  s.add(chain("body", 10, 1.0, 3e4).modal_damping(0.01));
  s.connect("suspension", "wheel.w", "body.1", suspension(2e7));
  s.base_displacement("road", "wheel.ground", sampled_road());
  const EstimateOptions options{.sensors = {{"a3", acceleration("body.2"), 0.3}},
                                .unknowns = {{"suspension.k3", {.initial = 2e7, .std = 3e7}}}};
  const auto result = estimate(s, record, options);
  ASSERT_TRUE(result.usable());
  EXPECT_EQ(result.parameters[0].unit, "N/m^3");
  EXPECT_NEAR(result.parameters[0].mean, 5e7, 3.0 * result.parameters[0].std);
  EXPECT_LT(result.parameters[0].std, 5e6);
  // The library's law of the same force gives the same.
  Structure same;
  same.add(lumped("wheel").mass("w", 1.5).spring("k_w", "ground", "w", 2e4));
  same.add(chain("body", 10, 1.0, 3e4).modal_damping(0.01));
  same.connect("suspension", "wheel.w", "body.1", law("cubic", {{"k", 5e3}, {"k3", 2e7}, {"c", 10.0}}));
  same.base_displacement("road", "wheel.ground", sampled_road());
  const auto expected = estimate(same, record, options);
  EXPECT_NEAR(result.parameters[0].mean, expected.parameters[0].mean, 1e-6 * expected.parameters[0].mean);
}

/// A spring that lets go with more and more force: the motion runs away.
TEST(FirstProgram, ASimulationThatCannotGoOnSaysSoInItsResult) {
  Structure s;
  s.add(lumped("mass").mass("m", 1.0));
  s.connect("spring", "mass.m", "ground", law("cubic", {{"k", 1e3}, {"k3", -1e9}}));
  s.force("push", "mass.m", {Eigen::VectorXd::Constant(101, 100.0), 100.0});
  const auto result = simulate(s, {.sensors = {{"x", displacement("mass.m")}}, .duration = 0.9, .sample_rate = 100.0});
  ASSERT_TRUE(result.failure.has_value());
  EXPECT_FALSE(result.usable());
  EXPECT_GT(result.failure->time, 0.0);
  EXPECT_FALSE(result.failure->reason.empty());
  EXPECT_EQ(result.record.samples(), 0);
  EXPECT_EQ(result.record.channels.at(0).name, "x");
}

}  // namespace
}  // namespace kalfem
