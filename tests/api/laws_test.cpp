// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/laws.hpp"

#include "chain.hpp"

namespace kalfem {
namespace {

using testing::HasSubstr;

/// Force and tangents of a law without states at some points.
Eigen::ArrayXXd response_of(const Law& law) {
  const Eigen::Index count = 4;
  Eigen::ArrayXd d(count), v(count);
  d << -3e-3, -1e-5, 2e-3, 0.1;
  v << 0.2, -0.01, 0.0, -3.0;
  const Eigen::ArrayXd zero = Eigen::ArrayXd::Zero(count);
  const Eigen::ArrayXXd parameters = law.values.transpose().replicate(count, 1).array(), none(count, 0);
  Eigen::ArrayXd force(count), stiffness(count), damping(count), inertance(count);
  Eigen::ArrayXXd states(count, 0);
  law.law->respond({0.0, parameters, zero, zero, none, d, v, zero}, {force, stiffness, damping, inertance, states});
  Eigen::ArrayXXd all(count, 3);
  all << force, stiffness, damping;
  return all;
}

// Of central differences: rounding of the force over the step, 1e-16 * 20 N / 6e-9 m.
TEST(OwnLaws, AFunctionActsAsTheSameLawOfTheLibrary) {
  const Law own = law("own", {{"k", 5e3}, {"mu", 20.0}, {"width", 2e-3}, {"c", 10.0}},
                      [](double d, double v, std::span<const double> p) {
                        return p[0] * d + p[1] * d / (p[2] + std::abs(d)) + p[3] * v;
                      });
  const auto expected =
      response_of(law("saturating", {{"k", 5e3}, {"mu_k1", 20.0}, {"mu_k2", 2e-3}, {"c", 10.0}, {"mu_c2", 1.0}}));
  const auto actual = response_of(own);
  EXPECT_LT(((actual - expected) / (1.0 + expected.abs())).abs().maxCoeff(), 2e-7);
  const auto formula = response_of(
      expression("k*x + mu*x/(width + abs(x)) + c*v", {{"k", 5e3}, {"mu", 20.0}, {"width", 2e-3}, {"c", 10.0}}));
  EXPECT_LT(((formula - expected) / (1.0 + expected.abs())).abs().maxCoeff(), 2e-7);
}

TEST(OwnLaws, ParametersThatMayBeZeroAreZeroByDefault) {
  const Law given = law("jenkins", {{"k_stick", 5e3}});
  EXPECT_EQ(given.values, (Eigen::VectorXd(4) << 5e3, 0.0, 0.0, 0.0).finished());
}

TEST(OwnLaws, ATermOfTheSaturatingLawThatIsLeftOutIsAbsent) {
  const Law given = law("saturating", {{"k", 5e3}, {"mu_k1", 20.0}});
  EXPECT_EQ(given.values, (Eigen::VectorXd(6) << 5e3, 20.0, 2e-3, 0.0, 0.0, 0.05).finished());
  const auto without_terms = response_of(law("saturating", {{"k", 5e3}, {"c", 10.0}}));
  EXPECT_TRUE((without_terms == response_of(law("linear", {{"k", 5e3}, {"c", 10.0}}))).all());
}

TEST(OwnLaws, AWrongParameterIsNamed) {
  const auto refused = [](const NamedValues& values) { return refusal_of([&] { return law("saturating", values); }); };
  EXPECT_THAT(refusal_of([] {
                return law("jenkins", {{"f_slip", 10.0}});
              }),
              HasSubstr("law 'jenkins': the parameter 'k_stick' is missing"));
  EXPECT_THAT(refused({{"mu_k3", 5e3}, {"mu_k2", 1.0}, {"mu_c2", 1.0}}),
              HasSubstr("law 'saturating': there is no parameter 'mu_k3' (did you mean 'mu_k"));
  EXPECT_THAT(refused({{"k", -5e3}, {"mu_k2", 1.0}, {"mu_c2", 1.0}}), HasSubstr("law 'saturating': parameter 'k'"));
  EXPECT_THAT(refused({{"k", 1.0}, {"k", 2.0}, {"mu_k2", 1.0}, {"mu_c2", 1.0}}),
              HasSubstr("law 'saturating': the parameter 'k' is given twice"));
}

TEST(OwnLaws, AnUnknownNameAnEmptyFunctionAndAnEmptyPointerAreRefused) {
  EXPECT_THAT(refusal_of([] { return law("saturated"); }), HasSubstr("saturated"));
  EXPECT_THAT(refusal_of([] {
                return law("own", {{"k", 1.0}}, ForceFunction());
              }),
              HasSubstr("law 'own': the force function is empty"));
  EXPECT_THAT(refusal_of([] { return law(ConnectorLawPtr(), {}); }), HasSubstr("law: the pointer is empty"));
}

}  // namespace
}  // namespace kalfem
