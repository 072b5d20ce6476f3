// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "kalfem/base/random.hpp"
#include "kalfem/records/frequency_response.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// y = 2 x + noise, all white: every line is alike, and segments without overlap are independent.
Record white_record(Index segments, std::uint64_t seed) {
  constexpr Index length = 128;
  Record record{100.0, 0.0, {{"force", "N"}, {"motion", "m"}}, Eigen::MatrixXd(2, segments * length)};
  RandomStream input(seed, "input"), noise(seed, "noise");
  for (Index k = 0; k < record.samples(); ++k) {
    record.values(0, k) = input.normal();
    record.values(1, k) = 2.0 * record.values(0, k) + 3.0 * noise.normal();
  }
  return record;
}

/// Ratio of the squared error to the stated variance, mean over lines and seeds. With S_yy (1 - gamma^2) of n_d
/// averages n_d - 1 of the output's power are not fitted: E is 1 for n_d - 1 in the deviation, and (n_d - 1) / n_d for
/// n_d. The error itself grows by n_d / (n_d - 1), as E[1 / S_xx] does.
double error_to_stated(Index segments, const H1Options& options) {
  constexpr int seeds = 600;
  double error = 0.0, stated = 0.0;
  for (int seed = 0; seed < seeds; ++seed) {
    const auto record = white_record(segments, 1000 + std::uint64_t(seed));
    const auto estimate = estimate_h1({&record, 1}, "force", {"motion"}, options);
    const auto& response = estimate.response;
    for (Index k = 1; k < response.lines.size() - 1; ++k) {
      error += std::norm(response.values(k, 0) - 2.0) / 2.0;
      stated += std::pow(response.deviations(k, 0), 2);
    }
  }
  return error / stated;
}

TEST(H1OfFewAverages, HasDeviationsThatAreThoseOfItsErrors) {
  // Found 0.99 to 1.01. With n_d in the place of n_d - 1 it would be 2 for two segments, 1.5 for three and 1.25 for
  // five.
  for (const Index segments : {2, 3, 5}) {
    const double ratio =
        error_to_stated(segments, {.segment = 128, .overlap = 0.0, .window = SpectralWindow::rectangular});
    std::printf("%d segments: squared error %.3f of the stated variance\n", int(segments), ratio);
    // found .011; the mean of 37,800 squared errors scatters by .5 %, with two averages by more
    EXPECT_NEAR(ratio, 1.0, 0.03) << segments;
  }
}

TEST(H1OfFewAverages, CountsOverlappingSegmentsForWhatTheyAreWorth) {
  for (const Index segments : {3, 6}) {
    const auto record = white_record(segments, 1);
    const auto estimate = estimate_h1({&record, 1}, "force", {"motion"}, {.segment = 128});
    const double n = double(2 * segments - 1);
    EXPECT_EQ(estimate.segments, 2 * segments - 1);
    // Hann windows that share a half are correlated by 1/6, and n segments have n - 1 such neighbours.
    // the same closed form
    EXPECT_NEAR(estimate.averages, n / (1.0 + 2.0 * (n - 1.0) / n / 36.0), 1e-14 * n);
  }
}

/// The sign of the phase: an output that comes one sample later turns by -2 pi f / rate.
TEST(H1OfFewAverages, LagsWhereTheOutputComesLater) {
  auto record = white_record(40, 5);
  for (Index k = record.samples() - 1; k > 0; --k) record.values(1, k) = record.values(0, k - 1);
  record.values(1, 0) = 0.0;
  const auto response = estimate_h1({&record, 1}, "force", {"motion"}, {.segment = 128}).response;
  for (Index k = 0; k < response.lines.size(); ++k) {
    const auto expected = std::polar(1.0, -2.0 * 3.14159265358979323846 * response.lines[k] / 100.0);
    // found .007: one sample's delay of a segment of 128 leaves 1 / 128
    EXPECT_LT(std::abs(response.values(k, 0) - expected), 0.02) << response.lines[k];
  }
}

}  // namespace
}  // namespace kalfem
