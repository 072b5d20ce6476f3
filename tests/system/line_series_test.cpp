// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/signals/line_series.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/processor_time.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/system/signals/random_signal.hpp"

namespace kalfem {
namespace {

/// Lines with amplitudes that fall with the frequency (power 0: flat) and random phases.
LineSeries series_of(double period, Eigen::Index first, std::size_t lines, double power) {
  LineSeries series{period, first, {}, {}};
  RandomStream random(3, "lines");
  for (std::size_t l = 0; l < lines; ++l) {
    series.amplitude.push_back(std::pow(double(first) + double(l), -power));
    series.phase.push_back(2.0 * std::numbers::pi * random.uniform());
  }
  return series;
}

/// Largest difference from the plain sum of sines, to the rms of the value and of each derivative.
double error_against_the_sum(const LineSeries& series, double start, double step, Eigen::Index count) {
  const auto fast = make_transformed_lines(series)->sample(start, step, count);
  SignalSamples sum = SignalSamples::Zero(count, 3);
  for (Eigen::Index k = 0; k < count; ++k)
    for (std::size_t l = 0; l < series.amplitude.size(); ++l) {
      const long double f = (series.first + Eigen::Index(l)) / static_cast<long double>(series.period);
      const long double turned = f * static_cast<long double>(start + double(k) * step);
      const double angle =
          double(2.0L * std::numbers::pi_v<long double> * (turned - std::floor(turned))) + series.phase[l];
      const double w = 2.0 * std::numbers::pi * double(f), a = series.amplitude[l];
      sum.row(k) +=
          Eigen::Array<double, 1, 3>(a * std::sin(angle), a * w * std::cos(angle), -a * w * w * std::sin(angle));
    }
  const Eigen::Array<double, 1, 3> size = sum.square().colwise().mean().sqrt();
  return ((fast - sum).rowwise() / size).abs().maxCoeff();
}

TEST(LineSeries, ByTheTransformIsTheSumOfItsLines) {
  // found: 3e-13, from the rounding of the acceleration e'' + 2 i w e' - w^2 e
  // rounding of the sum of sines, whose arguments grow with time
  EXPECT_LT(error_against_the_sum(series_of(20.0, 10, 591, 0.0), 0.0, 0.0513, 300), 1e-12);
  EXPECT_LT(error_against_the_sum(series_of(20.0, 10, 591, 0.0), -7.3, 1e-3, 300), 1e-12);
  EXPECT_LT(error_against_the_sum(series_of(43.0, 12, 3000, 1.0), 3.1, 0.131, 200), 4e-12);  // a road
  EXPECT_LT(error_against_the_sum(series_of(2.0, 5, 1, 0.0), 0.2, 0.0371, 50), 1e-12);
  // found: 6e-12, what the rounding of the time makes at 900 Hz after 7 s; 2e-12 where the rms is mostly a constant
  EXPECT_LT(error_against_the_sum(series_of(10.0, 9000, 40, 0.0), 0.2, 0.0371, 200), 2e-11);
  EXPECT_LT(error_against_the_sum(series_of(2.0, 0, 2, 0.0), 0.2, 0.0371, 50), 1e-11);
}

TEST(LineSeries, SummedOrTransformedIsOneSignal) {
  const auto few = series_of(30.0, 15, 886, 0.0);
  const auto summed = make_line_series(few)->sample(1.0, 1e-3, 20000);
  const auto transformed = make_transformed_lines(few)->sample(1.0, 1e-3, 20000);
  for (int d = 0; d < 3; ++d)
    // rounding of the transform: found .6 of it for the second derivative
    EXPECT_LT((summed - transformed).col(d).abs().maxCoeff(), 1e-12 * summed.col(d).abs().maxCoeff());
}

TEST(LineSeries, ALongRandomSignalIsTheSumOverThePhasesOfItsSeed) {
  const RandomSignalOptions options{.rms = 2.0, .duration = 60.0, .fade_in = 0.0, .seed = 5};  // 1,771 lines
  LineSeries series{60.0, 30, std::vector<double>(1771, 2.0 * std::sqrt(2.0 / 1771)), {}};
  RandomStream stream(options.seed, options.name);
  for (int l = 0; l < 1771; ++l) series.phase.push_back(2.0 * std::numbers::pi * stream.uniform());
  std::vector<SpectralLine> lines;
  for (int l = 0; l < 1771; ++l) lines.push_back({series.amplitude[l], (30 + l) / 60.0, series.phase[l]});
  const auto expected = make_spectral_lines(lines)->sample(11.0, 0.01, 500);
  const auto found = make_random(options)->sample(11.0, 0.01, 500);
  for (int d = 0; d < 3; ++d)
    // rounding: found 3e-13
    EXPECT_LT((found - expected).col(d).abs().maxCoeff(), 1e-12 * expected.col(d).abs().maxCoeff());
}

TEST(LineSeries, RefusesWhatIsNoSeries) {
  EXPECT_THROW(make_line_series({.period = 0.0, .first = 1, .amplitude = {1.0}, .phase = {0.0}}), InvalidInput);
  EXPECT_THROW(make_line_series({.period = 1.0, .first = -1, .amplitude = {1.0}, .phase = {0.0}}), InvalidInput);
  EXPECT_THROW(make_line_series({.period = 1.0, .first = 1, .amplitude = {1.0}, .phase = {}}), InvalidInput);
  EXPECT_THROW(make_line_series({.period = 1.0, .first = 1, .amplitude = {NAN}, .phase = {0.0}}), InvalidInput);
  EXPECT_THROW(make_transformed_lines({}), InvalidInput);
  EXPECT_EQ(make_line_series({})->sample(0.0, 1.0, 3).abs().maxCoeff(), 0.0);
}

double seconds_of(double duration, bool road) {
  const double begin = processor_seconds();
  const auto signal = road ? make_road_profile({.speed = 10.0, .duration = duration})
                           : make_random({.lower = 0.5, .upper = 30.0, .duration = duration});
  double size = 0.0;
  const double rate = 200.0;
  const auto block = Eigen::Index(4096), count = Eigen::Index(rate * duration);
  for (Eigen::Index first = 0; first < count; first += block)
    size += signal->sample(double(first) / rate, 1.0 / rate, block).abs().maxCoeff();
  EXPECT_TRUE(std::isfinite(size));
  return processor_seconds() - begin;
}

TEST(LineSeries, LongRandomSignalsCostWithTheirDuration) {
  // 147,501 lines at a million instants: about 0.4 s. Line by line it were 10^12 operations, many minutes.
  for (const bool road : {false, true}) {
    const double seconds = seconds_of(5000.0, road);
    RecordProperty(road ? "road_seconds" : "random_seconds", std::to_string(seconds));
    EXPECT_LT(seconds, 10.0);
  }
}

TEST(LineSeries, ALongRandomSignalKeepsItsRmsAndStartsFromRest) {
  const double duration = 400.0, rate = 100.0;  // 11,801 lines
  const auto whole = make_random({.rms = 2.0, .duration = duration, .fade_in = 0.0})
                         ->sample(0.0, 1.0 / rate, Eigen::Index(duration * rate));
  EXPECT_NEAR(std::sqrt(whole.col(0).square().mean()), 2.0, 5e-14);  // rounding of the mean of many squares
  const auto faded = make_random({.rms = 2.0, .duration = duration, .fade_in = 0.5})->sample(0.0, 1.0 / rate, 100);
  EXPECT_EQ(faded.row(0).abs().maxCoeff(), 0.0);
  // the fade is 1 there
  EXPECT_LT((faded.bottomRows(50) - whole.middleRows(50, 50)).abs().maxCoeff(), 1e-14 * whole.abs().maxCoeff());
}

}  // namespace
}  // namespace kalfem
