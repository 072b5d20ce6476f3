// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/input_error.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <numbers>

#include "kalfem/base/random.hpp"

namespace kalfem::test {
namespace {

using Complex = std::complex<double>;

constexpr double rate = 256.0, duration = 32.0;

/// Fourier integral of a pulse sin^2(pi t / T), 0 < t < T, that begins at `start`: in closed form.
Complex pulse_spectrum(double frequency, double start, double length) {
  const double x = frequency * length;
  const double shape =
      std::abs(x) < 1e-9 ? 0.5 : std::sin(std::numbers::pi * x) / (2.0 * std::numbers::pi * x * (1.0 - x * x));
  return length * shape * std::polar(1.0, -2.0 * std::numbers::pi * frequency * (start + 0.5 * length));
}

struct Blows {
  RecordSpectra sampled;
  Eigen::VectorXcd exact;  ///< spectrum of the force between the samples, too
};

Blows blows(double length, std::uint64_t seed) {
  RandomStream random(seed, "blows");
  const auto samples = static_cast<Eigen::Index>(rate * duration);
  Record record = make_record(rate, {{"F", Eigen::VectorXd::Zero(samples)}, {"a", Eigen::VectorXd::Zero(samples)}});
  record.values(1, 0) = 1.0;
  std::vector<double> starts;
  for (int blow = 0; blow < 10; ++blow) {
    const double start = starts.emplace_back((duration - 1.0) * random.uniform());
    for (Eigen::Index k = 0; k < samples; ++k) {
      const double since = record.time(k) - start;
      if (since > 0.0 && since < length)
        record.values(0, k) += std::pow(std::sin(std::numbers::pi * since / length), 2);
    }
  }
  Blows result{record_spectra(record, "F", {"a"}), {}};
  result.exact = Eigen::VectorXcd::Zero(result.sampled.lines.size());
  for (const double start : starts)
    for (Eigen::Index k = 0; k < result.exact.size(); ++k)
      result.exact[k] += rate * pulse_spectrum(result.sampled.lines[k], start, length);
  return result;
}

/// Error of the sampled spectrum below an eighth of the sampling rate, and what is expected, as root mean squares.
struct Errors {
  double true_one = 0.0, expected = 0.0;
};

Errors errors_of(const Blows& given) {
  const auto below = static_cast<Eigen::Index>(rate / 8.0 * duration);
  const Eigen::VectorXcd difference = given.sampled.input - given.exact;
  return {std::sqrt(difference.head(below).cwiseAbs2().mean()),
          std::sqrt(input_error_power(given.sampled).head(below).mean())};
}

// A sine squared falls as 1 / f^3, faster than the 1 / f^2 that is taken: the error is at most overestimated, and not
// by an order of magnitude.
TEST(InputError, IsThatOfBlowsBetweenTheirSamples) {
  for (const double length : {0.008, 0.012, 0.02})
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      const Errors errors = errors_of(blows(length, seed));
      EXPECT_GT(errors.expected, 0.8 * errors.true_one) << length;
      EXPECT_LT(errors.expected, 8.0 * errors.true_one) << length;
    }
}

TEST(InputError, IsNegligibleForAForceThatMovesSlowly) {
  const Blows slow = blows(0.2, 1);
  const double power = slow.sampled.input.head(100).cwiseAbs2().mean();
  EXPECT_LT(input_error_power(slow.sampled).head(100).maxCoeff(), 1e-7 * power);
}

}  // namespace
}  // namespace kalfem::test
