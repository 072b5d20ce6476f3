// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/figures.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/modal/identify_modes.hpp"
#include "kalfem/modal/shape_measures.hpp"

// Modes of frequency responses whose modes are known: H = sum_r phi_r l_r^T s^2 / (s^2 + 2 zeta omega s + omega^2).

namespace kalfem::test {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::VectorXd;

struct TrueModes {
  VectorXd frequencies, dampings;
  Eigen::MatrixXd shapes;  ///< outputs x modes
};

/// A beam of `outputs` equal spaces with modes between 5 and 95 Hz, irregularly spaced, damped by 0.5 to 1.5 %.
TrueModes beam(Index modes, Index outputs, std::uint64_t seed) {
  RandomStream stream(seed, "modes");
  TrueModes truth{VectorXd(modes), VectorXd(modes), Eigen::MatrixXd(outputs, modes)};
  for (Index r = 0; r < modes; ++r) {
    const double off = 0.3 * std::clamp(stream.normal(), -1.0, 1.0);
    truth.frequencies[r] = 5.0 + 95.0 * (static_cast<double>(r) + 0.5 + off) / static_cast<double>(modes);
    truth.dampings[r] = 0.01 + 0.005 * std::clamp(stream.normal(), -1.0, 1.0);
    for (Index o = 0; o < outputs; ++o)
      truth.shapes(o, r) =
          std::sin(std::numbers::pi * static_cast<double>((r + 1) * (o + 1)) / static_cast<double>(outputs + 1));
  }
  return truth;
}

/// Accelerations per force at some outputs, with noise of a part of each response's rms.
FrfMatrix responses(const TrueModes& truth, const std::vector<Index>& forces, double noise, std::uint64_t seed,
                    Index lines = 4000) {
  FrfMatrix frfs{.lines = VectorXd::LinSpaced(lines, 1.0, 100.0), .outputs = {}, .inputs = {}, .values = {}};
  const Index outputs = truth.shapes.rows();
  for (Index o = 0; o < outputs; ++o) frfs.outputs.push_back({"a" + std::to_string(o + 1), "m/s^2"});
  RandomStream stream(seed, "noise");
  for (const Index force : forces) {
    frfs.inputs.push_back("f" + std::to_string(force + 1));
    MatrixXcd values = MatrixXcd::Zero(lines, outputs);
    for (Index k = 0; k < lines; ++k) {
      const Complex s(0.0, 2.0 * std::numbers::pi * frfs.lines[k]);
      for (Index r = 0; r < truth.frequencies.size(); ++r) {
        const double omega = 2.0 * std::numbers::pi * truth.frequencies[r];
        values.row(k) += s * s / (s * s + 2.0 * truth.dampings[r] * omega * s + omega * omega) *
                         truth.shapes(force, r) * truth.shapes.col(r).transpose();
      }
    }
    for (Index o = 0; o < outputs; ++o) {
      const double rms = values.col(o).norm() / std::sqrt(static_cast<double>(lines));
      for (Index k = 0; k < lines; ++k)
        values(k, o) += noise * rms * std::sqrt(0.5) * Complex(stream.normal(), stream.normal());
    }
    frfs.values.push_back(std::move(values));
  }
  return frfs;
}

/// Largest errors of what was found, and how many deviations the errors are, squared, on average.
struct Errors {
  Index found = 0, spurious = 0;
  double frequency = 0.0, damping = 0.0, mac = 1.0, frequency_z2 = 0.0, damping_z2 = 0.0;
};

Errors errors_of(const ModalResult& result, const TrueModes& truth) {
  Errors errors;
  for (const auto& mode : result.modes) {
    Index nearest = 0;
    (truth.frequencies.array() - mode.frequency).abs().minCoeff(&nearest);
    const double off = mode.frequency / truth.frequencies[nearest] - 1.0;
    if (std::abs(off) > 0.01) {
      ++errors.spurious;
      continue;
    }
    ++errors.found;
    errors.frequency = std::max(errors.frequency, std::abs(off));
    errors.damping = std::max(errors.damping, std::abs(mode.damping / truth.dampings[nearest] - 1.0));
    errors.mac = std::min(errors.mac, mac(mode.shape, truth.shapes.col(nearest).cast<Complex>()));
    errors.frequency_z2 += std::pow((mode.frequency - truth.frequencies[nearest]) / mode.frequency_std(), 2);
    errors.damping_z2 += std::pow((mode.damping - truth.dampings[nearest]) / mode.damping_std(), 2);
  }
  errors.frequency_z2 /= static_cast<double>(std::max<Index>(1, errors.found));
  errors.damping_z2 /= static_cast<double>(std::max<Index>(1, errors.found));
  return errors;
}

TEST(ResponseModes, TwentyModesOfThirtySensorsWithOnePerCentOfNoise) {
  const auto truth = beam(20, 30, 1);
  const Errors errors = errors_of(identify_modes(responses(truth, {3}, 0.01, 1)), truth);
  std::printf(
      "20 modes, 30 sensors, 1 %% of noise: %ld found, %ld spurious, frequency within %.4f %%, damping %.2f %%, "
      "MAC %.5f\n",
      static_cast<long>(errors.found), static_cast<long>(errors.spurious), 100.0 * errors.frequency,
      100.0 * errors.damping, errors.mac);
  EXPECT_EQ(errors.found, 20);
  EXPECT_EQ(errors.spurious, 0);
  EXPECT_LT(errors.frequency, 0.0002);
  EXPECT_LT(errors.damping, 0.02);
  EXPECT_GT(errors.mac, 0.999);
}

TEST(ResponseModes, ErrorsAreOfTheSizeOfTheirDeviations) {
  double frequency = 0.0, damping = 0.0;
  constexpr int records = 6;
  for (std::uint64_t seed = 1; seed <= records; ++seed) {
    const auto truth = beam(6, 8, seed);
    const Errors errors = errors_of(identify_modes(responses(truth, {1, 4}, 0.05, seed, 1500)), truth);
    EXPECT_EQ(errors.found, 6);
    EXPECT_EQ(errors.spurious, 0);
    frequency += errors.frequency_z2 / records;
    damping += errors.damping_z2 / records;
  }
  // 36 squares each: their mean has the deviation sqrt(2 / 36) = 0.24
  EXPECT_GT(frequency, 0.4);
  EXPECT_LT(frequency, 1.8);
  EXPECT_GT(damping, 0.4);
  EXPECT_LT(damping, 1.8);
}

/// Two modes 0.3 % apart, less than half their bandwidth, which one force shows as one peak.
TEST(ResponseModes, SeveralForcesTellCloseModesApart) {
  auto truth = beam(4, 12, 3);
  truth.frequencies[2] = 1.003 * truth.frequencies[1];
  truth.dampings[1] = truth.dampings[2] = 0.004;
  const Errors errors = errors_of(identify_modes(responses(truth, {2, 7}, 0.002, 3)), truth);
  EXPECT_EQ(errors.found, 4);
  EXPECT_LT(errors.frequency, 0.0002);
  EXPECT_GT(errors.mac, 0.999);
}

TEST(ResponseModes, ABandTakesItsModesAlone) {
  const auto truth = beam(20, 30, 1);
  const auto result = identify_modes(responses(truth, {3}, 0.01, 1), {.band = FrequencyBand{30.0, 60.0}});
  const auto inside = ((truth.frequencies.array() > 30.5) && (truth.frequencies.array() < 59.5)).count();
  EXPECT_GE(std::ssize(result.modes), inside);
  for (const auto& mode : result.modes) {
    EXPECT_GT(mode.frequency, 30.0);
    EXPECT_LT(mode.frequency, 60.0);
  }
  EXPECT_LT(errors_of(result, truth).frequency, 0.001);
}

TEST(ResponseModes, NoiseAloneHasNoMode) {
  const auto truth = beam(3, 6, 5);
  auto frfs = responses(truth, {1}, 0.0, 5, 800);
  RandomStream stream(5, "alone");
  for (auto& value : frfs.values.front().reshaped()) value = Complex(stream.normal(), stream.normal());
  EXPECT_TRUE(identify_modes(frfs).modes.empty());
}

TEST(ResponseModes, ARecordWithItsForces) {
  // Two oscillators under a white force, sampled: frequencies from H1 with long segments.
  const double rate = 64.0;
  RandomStream stream(2, "force");
  const std::vector<double> frequency = {4.0, 9.0}, zeta = {0.02, 0.015};
  const Index samples = 40000;
  Record record{
      .sample_rate = rate, .channels = {{"f", "N"}, {"a", "m"}, {"b", "m"}}, .values = Eigen::MatrixXd(3, samples)};
  std::vector<Complex> q(2, 0.0);
  for (Index k = 0; k < samples; ++k) {
    const double force = stream.normal();
    record.values(0, k) = force;
    double parts[2] = {};
    for (std::size_t r = 0; r < 2; ++r) {
      const double omega = 2.0 * std::numbers::pi * frequency[r];
      const Complex pole(-zeta[r] * omega, omega * std::sqrt(1.0 - zeta[r] * zeta[r]));
      q[r] = std::exp(pole / rate) * q[r] + force;
      parts[r] = q[r].imag();
    }
    record.values(1, k) = parts[0] + parts[1] + 0.05 * stream.normal();
    record.values(2, k) = parts[0] - 0.5 * parts[1] + 0.05 * stream.normal();
  }
  for (const FrfEstimator estimator : {FrfEstimator::h1, FrfEstimator::hv}) {
    const auto result = identify_modes(
        record,
        {.inputs = {"f"}, .forced = {.segment = 40.0, .estimator = estimator}, .band = FrequencyBand{1.0, 15.0}});
    ASSERT_EQ(result.modes.size(), 2u);
    EXPECT_EQ(result.method, ModalMethod::rational_fraction);
    EXPECT_EQ(result.references, std::vector<std::string>{"f"});
    for (std::size_t r = 0; r < 2; ++r) {
      EXPECT_NEAR(result.modes[r].frequency / frequency[r], 1.0, 0.002);
      EXPECT_NEAR(result.modes[r].damping / zeta[r], 1.0, 0.1);
    }
    EXPECT_NEAR(std::abs(result.modes[1].shape[1]), 0.5, 0.02);
  }
}

TEST(ResponseModes, MistakesAreNamed) {
  const auto truth = beam(3, 6, 5);
  const auto good = responses(truth, {1}, 0.01, 5, 200);
  const auto refusal = [](const FrfMatrix& frfs, const ModalOptions& options = {}) -> std::string {
    try {
      identify_modes(frfs, options);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  const auto expect = [](const std::string& text, const std::string& piece) {
    EXPECT_NE(text.find(piece), std::string::npos) << text;
  };
  auto bad = good;
  bad.values[0](3, 2) = std::nan("");
  expect(refusal(bad), "hold values that are not finite");
  bad = good;
  bad.values[0].conservativeResize(199, 6);
  expect(refusal(bad), "there are 200 lines and 6 outputs");
  bad = good;
  bad.lines[5] = bad.lines[7];
  expect(refusal(bad), "not ascending");
  bad = good;
  bad.values[0].col(4).setZero();
  expect(refusal(bad), "the responses of 'a5' are 0");
  bad = good;
  bad.inputs.clear();
  expect(refusal(bad), "each input has a name");
  expect(refusal(good, {.channels = {"a7"}}), "there is no response of 'a7'");
  expect(refusal(good, {.band = FrequencyBand{50.0, 51.0}}), "a fit needs at least 32");
}

}  // namespace
}  // namespace kalfem::test
