// SPDX-License-Identifier: Apache-2.0
#include <numbers>

#include "base/scratch_folder.hpp"
#include "casefile/damping_of_unknowns.hpp"
#include "kalfem/identification/parameterised_structure.hpp"
#include "kalfem/study/study.hpp"
#include "kalfem/updating/frf_residual.hpp"

// How a case's frequency responses reach the residual.

namespace kalfem::test {
namespace {

const std::string two_floors = R"(kalfem: 1
substructures:
  frame:
    masses: {1: 5 kg, 2: 5 kg}
    springs: [{name: a, from: ground, to: 1, stiffness: 50 kN/m}, {name: b, from: 1, to: 2, stiffness: 50 kN/m}]
    damping: {modal: 1 %}
update:
  parameters: {frame.a.stiffness: {}}
  compare:
    tap:
      frf: frame
      inputs: [{force: 1, file: FILE}]
      outputs: [1, 2]
      KEYS
)";

class FrfComparison : public testing::Test {
protected:
  FrfComparison() {
    std::ofstream decibel(folder_ / "db.csv"), complex(folder_ / "complex.csv");
    for (int k = 1; k < 40; ++k) {
      const Eigen::Vector2cd h = accelerance(k);
      decibel << k << "," << 20.0 * std::log10(std::abs(h[0])) << "," << 20.0 * std::log10(std::abs(h[1])) << "\n";
      complex << k;
      for (const auto& each : h) complex << "," << each.real() << std::showpos << each.imag() << std::noshowpos << "j";
      complex << "\n";
    }
  }

  /// Of the frame per force at its first floor at a frequency [Hz], the responses 1.3 and 0.8 times too large.
  static Eigen::Vector2cd accelerance(double frequency) {
    const double omega = 2.0 * std::numbers::pi * frequency;
    const Eigen::Matrix2d stiffness = 5e4 * (Eigen::Matrix2d() << 2.0, -1.0, -1.0, 1.0).finished();
    const Eigen::Matrix2cd dynamic = std::complex(1.0, 1e-4 * omega) * stiffness.cast<std::complex<double>>() -
                                     omega * omega * 5.0 * Eigen::Matrix2cd::Identity();
    const Eigen::Vector2cd unit = dynamic.inverse().col(0);
    return -omega * omega * Eigen::Vector2cd(1.3 * unit[0], 0.8 * unit[1]);
  }

  std::shared_ptr<const FrfResidual> residual(const std::string& file, const std::string& keys) const {
    const Study study = study_of(with(with(two_floors, "FILE", file), "KEYS", keys));
    const auto& comparisons = study.updating_plan->comparisons;
    return std::dynamic_pointer_cast<const FrfResidual>(comparisons.at(0).continuation_steps.back());
  }
  std::string decibel() const { return "'" + (folder_ / "db.csv").string() + "', values: dB"; }
  std::string complex() const { return "'" + (folder_ / "complex.csv").string() + "'"; }

  ScratchFolder folder_{"frf-comparison"};
};

TEST_F(FrfComparison, ComparesMagnitudesAloneWithAFreeScale) {
  const auto magnitudes = residual(decibel(), "compare: log_magnitude\n      scale: per_response");
  EXPECT_EQ(magnitudes->size(), 39 * 2);
  EXPECT_TRUE(magnitudes->has_free_scale());
  // the table of decibels is written with six digits
  EXPECT_NEAR(std::abs(magnitudes->compared()[0].values(9, 0)) / std::abs(accelerance(10.0)[0]), 1.0, 1e-6);
}

TEST_F(FrfComparison, EachKeyReachesTheResidual) {
  const auto scales_of = [&](const std::string& keys) {
    const auto one = residual(complex(), keys);
    return one->scales(one->model_responses(Eigen::VectorXd::Constant(1, 5e4)))[0];
  };
  EXPECT_EQ(residual(complex(), "compare: logarithm")->size(), 2 * 39 * 2);
  EXPECT_EQ(residual(complex(), "compare: log_magnitude")->size(), 39 * 2);
  EXPECT_EQ(scales_of("scale: fixed"), Eigen::Vector2d::Ones());
  const Eigen::Vector2d per_input = scales_of("scale: per_input"), per_response = scales_of("scale: per_response");
  EXPECT_NE(per_input[0], 1.0);
  EXPECT_EQ(per_input[0], per_input[1]);
  // found .048 and .033: the model's damping is 1 %, the table's 1e-4 omega
  EXPECT_NEAR(per_response[0], 1.3, 0.05);  // damping differs
  EXPECT_NEAR(per_response[1], 0.8, 0.05);
}

TEST_F(FrfComparison, MagnitudesWithoutPhasesSayHowTheyAreCompared) {
  try {
    residual(decibel(), "scale: per_input");
    FAIL() << "it was accepted";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("compare: log_magnitude"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace kalfem::test
