// SPDX-License-Identifier: Apache-2.0
#include "casefile/blow_trials.hpp"

// Frequency responses of records that a case compares by their spectra: damping without the bias of a window.

namespace kalfem::test {
namespace {

const BlowChain three_floors{Eigen::Vector3d::Constant(5.2), Eigen::Vector3d(43e3, 48e3, 38e3), 0.01, 0};

class BlowRecords : public testing::Test {
protected:
  DampingTrial damping(const BlowTest& test, const std::string& more = "", std::uint64_t seed = 1) const {
    const std::string file = (folder_ / "record.csv").string();
    write_csv(file, record_of(three_floors, test, seed));
    const std::string quantity = test.derivative == 0   ? "      quantity: displacement\n"
                                 : test.derivative == 1 ? "      quantity: velocity\n"
                                                        : "";
    return damping_of(blow_case(three_floors, {file}, {1.05, 0.96, 1.04}, quantity + more), three_floors.ratio);
  }

  /// Within four of its standard deviations of the truth, and these are small.
  static void expect_right(const DampingTrial& trial, double widest) {
    EXPECT_LT(std::abs(trial.found - trial.truth), 2.0 * trial.half_width() * trial.truth) << trial.words;
    EXPECT_LT(trial.half_width(), widest) << trial.words;
    EXPECT_TRUE(trial.consistent) << trial.words;
  }

  ScratchFolder folder_{"blow-records"};
};

// By Hann segments of 8 s the damping was 1.2 %.
TEST_F(BlowRecords, GiveTheDampingOfEachQuantity) {
  for (const int derivative : {0, 1, 2}) expect_right(damping({.duration = 40.0, .derivative = derivative}), 0.03);
}

TEST_F(BlowRecords, MayBeginAndEndInTheMiddleOfAVibration) {
  expect_right(damping({.force = BlowTest::Force::white, .duration = 40.0, .from_rest = false}), 0.05);
}

TEST_F(BlowRecords, OfOneShortBlowEachAreTakenTogether) {
  const BlowTest blow{.blows = 1, .duration = 2.5, .noise = 0.01, .rest = 0.05};
  std::vector<std::string> files;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    files.push_back((folder_ / ("blow" + std::to_string(seed) + ".csv")).string());
    write_csv(files.back(), record_of(three_floors, blow, seed));
  }
  const auto of = [&](const std::vector<std::string>& some) {
    return damping_of(blow_case(three_floors, some, {1.05, 0.96, 1.04}, ""), three_floors.ratio);
  };
  const DampingTrial all = of(files), single = of({files[0]});
  expect_right(all, 0.05);
  expect_right(single, 0.15);
  EXPECT_LT(all.half_width(), 0.8 * single.half_width());
}

// A resonance that no line of the record hits: 0.3 % of 6.5 Hz is half a line of 20 s.
TEST_F(BlowRecords, NeedNoLineWithinAResonance) {
  BlowChain light = three_floors;
  light.ratio = 0.003;
  const std::string file = (folder_ / "light.csv").string();
  write_csv(file, record_of(light, {.duration = 20.0}, 1));
  expect_right(damping_of(blow_case(light, {file}, {1.03, 0.98, 1.02}, ""), light.ratio), 0.08);
}

TEST_F(BlowRecords, AFactorMayBeFree) {
  BlowRecord record = record_of(three_floors, {.duration = 40.0}, 1);
  record.outputs *= 2.0;
  const std::string file = (folder_ / "doubled.csv").string();
  write_csv(file, record);
  for (const std::string scale : {"per_input", "per_response"})
    expect_right(damping_of(blow_case(three_floors, {file}, {1.05, 0.96, 1.04}, "      scale: " + scale + "\n"),
                            three_floors.ratio),
                 0.05);
}

TEST_F(BlowRecords, DerivativesAreThoseOfTheWhitenedResidual) {
  const std::string file = (folder_ / "record.csv").string();
  write_csv(file, record_of(three_floors, {.duration = 20.0}, 1));
  const Study study = study_of(blow_case(three_floors, {file}, {1.0, 1.0, 1.0}, ""));
  const auto& residual = *study.updating_plan->comparisons.at(0).continuation_steps.back();
  Eigen::VectorXd at(4);
  at << three_floors.stiffnesses, three_floors.ratio;
  const auto value = residual.evaluate(at, true);
  ASSERT_TRUE(value);
  EXPECT_NEAR(value->values.squaredNorm() / static_cast<double>(residual.size()), 1.0, 0.3);
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    Eigen::VectorXd above = at, below = at;
    above[i] *= 1.0 + 1e-5;
    below[i] *= 1.0 - 1e-5;
    // The gradient of |r|^2 / 2 is exact with the best amplitudes.
    const double difference = (residual.evaluate(above, false)->values.squaredNorm() -
                               residual.evaluate(below, false)->values.squaredNorm()) /
                              (4e-5 * at[i]);
    const double gradient = value->jacobian.col(i).dot(value->values);
    EXPECT_NEAR(gradient, difference, 0.05 * value->jacobian.col(i).norm()) << i;
  }
}

// Magnitudes alone still come from windowed segments.
TEST_F(BlowRecords, OfNarrowResonancesAreNoMagnitudes) {
  const std::string file = (folder_ / "record.csv").string();
  write_csv(file, record_of(three_floors, {.duration = 40.0}, 1));
  const std::string refused =
      problems_of(blow_case(three_floors, {file}, {1.05, 0.96, 1.04}, "      compare: log_magnitude\n"));
  EXPECT_NE(refused.find("narrower than two lines of a segment of 8 s (0.25 Hz)"), std::string::npos) << refused;
}

}  // namespace
}  // namespace kalfem::test
