// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/frequency_response.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/random.hpp"

namespace kalfem {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::VectorXd;

constexpr double rate = 256.0;

/// y_k = b x_k + a_1 y_(k-1) + a_2 y_(k-2): its FRF is known exactly.
struct DigitalResonator {
  double a_1 = 0.0, a_2 = 0.0, b = 1.0;

  static DigitalResonator with(double frequency, double ratio) {
    const Complex pole =
        std::exp(2.0 * std::numbers::pi * frequency / rate * Complex(-ratio, std::sqrt(1.0 - ratio * ratio)));
    return {2.0 * pole.real(), -std::norm(pole), 1.0};
  }

  [[nodiscard]] VectorXd response(const VectorXd& input) const {
    VectorXd output(input.size());
    double last = 0.0, before = 0.0;
    for (Index k = 0; k < input.size(); ++k) {
      output[k] = b * input[k] + a_1 * last + a_2 * before;
      before = last;
      last = output[k];
    }
    return output;
  }

  [[nodiscard]] Complex frf(double frequency) const {
    const Complex z = std::exp(Complex(0.0, -2.0 * std::numbers::pi * frequency / rate));
    return b / (1.0 - a_1 * z - a_2 * z * z);
  }
};

Record record_of(const DigitalResonator& system, Index samples, double noise, std::uint64_t seed) {
  RandomStream input_stream(seed, "input"), noise_stream(seed, "noise");
  VectorXd input(samples);
  for (double& x : input) x = input_stream.normal();
  VectorXd output = system.response(input);
  for (double& y : output) y += noise * noise_stream.normal();
  Record record{rate, 0.0, {{"force", "N"}, {"motion", "m"}}, Eigen::MatrixXd(2, samples)};
  record.values << input.transpose(), output.transpose();
  return record;
}

H1Estimate h1(const Record& record, const H1Options& options) {
  return estimate_h1({&record, 1}, "force", {"motion"}, options);
}

// Damping of 5 % at 40 Hz: the impulse response dies within a hundredth of a segment of 2048 samples, so that leakage
// is small against the tolerances.
const DigitalResonator damped = DigitalResonator::with(40.0, 0.05);

TEST(H1Estimate, IsTheFrfOfTheSystem) {
  const auto estimate = h1(record_of(damped, 200 * 2048, 0.0, 1), {.segment = 2048});
  const auto& response = estimate.response;
  ASSERT_EQ(response.lines.size(), 1023);
  EXPECT_DOUBLE_EQ(response.lines[0], rate / 2048);
  EXPECT_EQ(response.outputs[0].unit, "m");
  for (Index k = 2; k < response.lines.size(); ++k) {
    const Complex truth = damped.frf(response.lines[k]);
    // The half-power width has 32 lines: what leaks between them is of the order of 1 / 32^2, and averages out.
    // found .0035 of the truth
    EXPECT_LT(std::abs(response.values(k, 0) - truth), 0.005 * std::abs(truth)) << response.lines[k];
    EXPECT_GT(estimate.response.coherence(k, 0), 0.998) << response.lines[k];
  }
}

TEST(H1Estimate, CountsIndependentAverages) {
  const auto record = record_of(damped, 64 * 256, 1.0, 3);
  const auto plain = h1(record, {.segment = 256, .overlap = 0.0, .window = SpectralWindow::rectangular});
  EXPECT_EQ(plain.segments, 64);
  EXPECT_DOUBLE_EQ(plain.averages, 64.0);
  // Hann windows that share a half are correlated by 1/6: n_d = n / (1 + 2/36) for many segments.
  const auto half = h1(record, {.segment = 256});
  EXPECT_EQ(half.segments, 127);
  EXPECT_NEAR(half.averages, 127.0 / (1.0 + 2.0 / 36.0 * 126.0 / 127.0), 1e-12);  // the same closed form
  // More overlap than that brings little that is new.
  const auto most = h1(record, {.segment = 256, .overlap = 0.9});
  EXPECT_GT(most.segments, 600);
  // found .09
  EXPECT_NEAR(most.averages, half.averages, 0.1 * half.averages);
}

TEST(H1Estimate, OutputNoiseNeitherBiasesItNorEscapesItsDeviation) {
  constexpr double noise = 3.0;
  constexpr int seeds = 60;
  const std::array<Index, 3> looked_at = {80, 315, 440};  // below, at and above the peak
  std::array<Complex, 3> sum{};
  std::array<double, 3> squares{}, deviations{}, coherence{};
  for (int seed = 0; seed < seeds; ++seed) {
    const auto estimate = h1(record_of(damped, 40 * 2048, noise, 100 + std::uint64_t(seed)), {.segment = 2048});
    for (std::size_t i = 0; i < 3; ++i) {
      const Index k = looked_at[i];
      const Complex error = estimate.response.values(k, 0) - damped.frf(estimate.response.lines[k]);
      sum[i] += error / double(seeds);
      squares[i] += std::norm(error) / (2.0 * seeds);
      deviations[i] += std::pow(estimate.response.deviations(k, 0), 2) / seeds;
      coherence[i] += estimate.response.coherence(k, 0) / seeds;
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const double size = std::abs(damped.frf(rate / 2048 * double(looked_at[i] + 1)));
    // 120 parts: their mean square is known to sqrt(2 / 120) = 13 %; three times that.
    EXPECT_NEAR(squares[i] / deviations[i], 1.0, 0.4) << i;
    // three standard errors, and the leakage of the line
    EXPECT_LT(std::abs(sum[i]), 3.0 * std::sqrt(2.0 * deviations[i] / seeds) + 0.01 * size) << i;
    const double truth = size * size / (size * size + noise * noise);
    // found .018
    EXPECT_NEAR(coherence[i], truth, 0.04) << i;
  }
}

TEST(H1Estimate, AveragesOverRecords) {
  const std::vector<Record> blows = {record_of(damped, 512, 0.5, 7), record_of(damped, 600, 0.5, 8)};
  const auto estimate = estimate_h1(blows, "force", {"motion"}, {.segment = 512});
  EXPECT_EQ(estimate.segments, 2);
  EXPECT_DOUBLE_EQ(estimate.averages, 2.0);
  EXPECT_GT(estimate.response.deviations.minCoeff(), 0.0);
  const auto single = h1(blows[0], {.segment = 512});
  EXPECT_EQ(single.response.deviations.size(), 0);
  EXPECT_NEAR(single.response.coherence.minCoeff(), 1.0, 1e-14);  // rounding
}

TEST(H1Estimate, SaysWhatDoesNotFit) {
  const auto record = record_of(damped, 300, 0.0, 1);
  EXPECT_THROW(h1(record, {.segment = 512}), InvalidInput);
  EXPECT_THROW(h1(record, {.segment = 2}), InvalidInput);
  EXPECT_THROW(h1(record, {.segment = 64, .overlap = 1.0}), InvalidInput);
  EXPECT_THROW(estimate_h1({&record, 1}, "force", {"motoin"}, {.segment = 64}), InvalidInput);
  EXPECT_THROW(estimate_h1({}, "force", {"motion"}, {.segment = 64}), InvalidInput);
  std::vector<Record> rates = {record, record};
  rates[1].sample_rate = 2.0 * rate;
  EXPECT_THROW(estimate_h1(rates, "force", {"motion"}, {.segment = 64}), InvalidInput);
}

struct Mode {
  double frequency, ratio;
};

/// Accelerances of two outputs: modes of residues 1 and (-1)^i on a constant.
FrequencyResponse accelerance(const std::vector<Mode>& modes, const VectorXd& lines) {
  FrequencyResponse response{lines, {{"a", ""}, {"b", ""}}, Eigen::MatrixXcd(lines.size(), 2)};
  for (Index k = 0; k < lines.size(); ++k) {
    const double f = lines[k];
    Complex sum[2] = {0.3, -0.2};
    double sign = 1.0;
    for (const auto& [frequency, ratio] : modes) {
      const Complex mode = -f * f / (frequency * frequency - f * f + Complex(0, 2.0 * ratio * frequency * f));
      sum[0] += mode;
      sum[1] += sign * mode;
      sign = -sign;
    }
    response.values.row(k) << sum[0], sum[1];
  }
  return response;
}

// Peaks narrower than the distance of the lines: 0.2 % of 6.51 Hz is a half-power width of 0.026 Hz.
TEST(ResponsePeaks, AreFoundBetweenTheLines) {
  const std::vector<Mode> modes = {{6.5141, 0.002}, {17.4637, 0.0023}, {26.507, 0.001}};
  const auto peaks = find_peaks(accelerance(modes, VectorXd::LinSpaced(1600, 0.03125, 50.0)));
  ASSERT_EQ(peaks.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    // found 5e-6 of the frequencies and 8e-6 of the ratios
    EXPECT_NEAR(peaks[i].frequency, modes[i].frequency, 2e-5 * modes[i].frequency);
    ASSERT_TRUE(peaks[i].damping.has_value());
    EXPECT_NEAR(*peaks[i].damping, modes[i].ratio, 2e-5 * modes[i].ratio);
  }
}

TEST(ResponsePeaks, StandOutOfNoiseAndOfTheBand) {
  auto response = accelerance({{10.0, 0.003}, {30.0, 0.003}}, VectorXd::LinSpaced(1600, 0.03125, 50.0));
  RandomStream stream(5, "noise");
  for (auto& value : response.values.reshaped()) value += 0.5 * Complex(stream.normal(), stream.normal());
  const auto peaks = find_peaks(response);
  ASSERT_EQ(peaks.size(), 2u);
  // noise of .5 against peaks of 170: found 9e-5 Hz
  EXPECT_NEAR(peaks[0].frequency, 10.0, 2e-4);
  EXPECT_NEAR(peaks[1].frequency, 30.0, 4e-4);
  const auto upper = find_peaks(response, {.band = {20.0, 40.0}});
  ASSERT_EQ(upper.size(), 1u);
  EXPECT_NEAR(upper[0].frequency, 30.0, 4e-4);
  EXPECT_TRUE(find_peaks(response, {.band = {60.0, 70.0}}).empty());
}

TEST(ResponsePeaks, NeedNoPhases) {
  auto response = accelerance({{10.0, 0.01}}, VectorXd::LinSpaced(1600, 0.03125, 50.0));
  response.values = response.values.cwiseAbs().cast<Complex>();
  response.magnitudes_only = true;
  const auto peaks = find_peaks(response);
  ASSERT_EQ(peaks.size(), 1u);
  EXPECT_NEAR(peaks[0].frequency, 10.0, 0.004);  // found .001; lines are .03 Hz apart
  EXPECT_FALSE(peaks[0].damping.has_value());
}

}  // namespace
}  // namespace kalfem
