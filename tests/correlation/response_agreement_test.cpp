// SPDX-License-Identifier: Apache-2.0
#include "kalfem/correlation/response_agreement.hpp"

#include <gtest/gtest.h>

#include <complex>
#include <numbers>

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXcd;

/// Receptance of an oscillator of 1 kg.
VectorXcd oscillator(double frequency, double damping) {
  VectorXcd response(200);
  for (Index i = 0; i < response.size(); ++i) {
    const double ratio = 0.1 * static_cast<double>(i + 1) / frequency;
    response[i] = 1.0 / std::complex<double>(1.0 - ratio * ratio, 2.0 * damping * ratio);
  }
  return response;
}

TEST(ResponseAgreement, IsFreeOfTheScale) {
  const VectorXcd measured = oscillator(5.0, 0.02);
  const auto found = agreement_of("tip", measured, -2.0 * measured, false);
  EXPECT_NEAR(found.frac, 1.0, 1e-14);
  EXPECT_NEAR(found.size, 2.0, 1e-14);
  EXPECT_NEAR(std::abs(*found.phase), std::numbers::pi, 1e-12);
  EXPECT_TRUE(found.is_turned());
}

/// cos^2 of the angle between (1, i) and (1, 0).
TEST(ResponseAgreement, IsTheSquaredCosine) {
  VectorXcd measured(2), model(2);
  measured << 1.0, std::complex<double>(0.0, 1.0);
  model << 1.0, 0.0;
  const auto found = agreement_of("tip", measured, model, false);
  EXPECT_NEAR(found.frac, 0.5, 1e-15);
  EXPECT_NEAR(found.size, std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(*found.phase, 0.0, 1e-15);
}

/// Neither a resonance elsewhere nor magnitudes alone look like a sign.
TEST(ResponseAgreement, TellsASignFromAnotherResonance) {
  for (const double frequency : {3.0, 4.0, 4.7, 5.3, 6.0, 9.0})
    EXPECT_FALSE(agreement_of("tip", oscillator(5.0, 0.02), oscillator(frequency, 0.02), false).is_turned());
  const auto magnitudes =
      agreement_of("tip", oscillator(5.0, 0.02).cwiseAbs().cast<std::complex<double>>(), -oscillator(5.0, 0.02), true);
  EXPECT_NEAR(magnitudes.frac, 1.0, 1e-12);
  EXPECT_FALSE(magnitudes.phase);
}

TEST(ResponseAgreement, OfNoMotionIsNone) {
  const auto found = agreement_of("tip", VectorXcd::Zero(3), VectorXcd::Ones(3), false);
  EXPECT_EQ(found.frac, 0.0);
  EXPECT_FALSE(found.is_turned());
}

TEST(ResponseAgreement, NamesWhatIsTurned) {
  const auto all = [](int turned) {
    std::vector<ResponseAgreement> responses;
    for (int i = 0; i < 4; ++i)
      responses.push_back({.name = "a" + std::to_string(i), .frac = 0.9, .phase = i < turned ? 3.1 : 0.1});
    return turned_ones(responses);
  };
  EXPECT_TRUE(all(0).empty());
  EXPECT_EQ(all(1), std::vector<std::string>{"a0 is turned: it agrees with the model against its direction"});
  ASSERT_EQ(all(4).size(), 1U);
  EXPECT_EQ(all(4)[0].substr(0, 19), "the input is turned");
}

}  // namespace
}  // namespace kalfem
