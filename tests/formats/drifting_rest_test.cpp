// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/records/free_response.hpp"

// How far a structure may drift before its rest has ended.
namespace kalfem {
namespace {

using Eigen::Index;

constexpr double sampling = 200.0, let_go = 0.5, drift_start = 14.0, drift_duration = 1.0;
constexpr double rest_place = 0.005;

/// Held at 40 mm, let go at 0.5 s, at rest by 10 s, and moved from 14 s on by `distance` [m] within a second.
Record drifting(double distance) {
  Record record{sampling, 0.0, {}, Eigen::MatrixXd(1, Index(30.0 * sampling))};
  const double damping = 0.25, omega = std::numbers::pi, damped = omega * std::sqrt(1.0 - damping * damping);
  for (Index k = 0; k < record.samples(); ++k) {
    const double since = std::max(0.0, record.time(k) - let_go);
    const double moved = distance * std::clamp((record.time(k) - drift_start) / drift_duration, 0.0, 1.0);
    record.values(0, k) = rest_place + 0.035 * std::exp(-damping * omega * since) * std::cos(damped * since) + moved;
  }
  return record;
}

/// A rest that goes on may tremble by twice the +-departure of a quiet one: means of windows of 0.2 s may lie four
/// departures apart within the longest swing, half a period of 1.03 s. A drift of d in a second moves them by 0.83 d.
TEST(DriftingRest, EndsWhereTheMeansMoveByMoreThanFourDepartures) {
  const Record still = drifting(0.0);
  const double departure = FreeResponseOptions{}.departure * (still.values.maxCoeff() - still.values.minCoeff());
  const auto rest_after = [&](double departures) {
    return find_rest(drifting(departures * departure), Index(let_go * sampling));
  };
  const auto within = rest_after(4.0), beyond = rest_after(6.0);  // the limit is 4.8
  ASSERT_TRUE(within && beyond);
  // The rest that goes on lies where the drift has ended; the other one where the motion has ended.
  EXPECT_NEAR(within->position[0], rest_place + 4.0 * departure, 0.01 * departure);
  EXPECT_NEAR(beyond->position[0], rest_place, 0.2 * departure);  // the first of the drift lies within +-departure
  EXPECT_LT(still.time(beyond->last), drift_start + drift_duration);
}

}  // namespace
}  // namespace kalfem
