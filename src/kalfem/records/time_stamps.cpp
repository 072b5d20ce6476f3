// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/time_stamps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kalfem {

double resolution(const Eigen::VectorXd& stamps) {
  const Eigen::VectorXd last = stamps.tail(std::min<Eigen::Index>(64, stamps.size()));
  for (double unit = 1.0, scale = 1.0; scale < 1e12; scale *= 10.0, unit = 1.0 / scale) {
    const Eigen::ArrayXd counts = last.array() * scale;
    const double largest = counts.abs().maxCoeff();
    const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * std::max(1.0, largest);
    if (largest > 0.0 && largest < 0.5) continue;  // less than a unit tells nothing about it
    if ((counts - counts.round()).abs().maxCoeff() <= rounding) return unit;
  }
  return 0.0;
}

double typical_interval(const Eigen::VectorXd& stamps) {
  constexpr Eigen::Index enough = 200'000;  // intervals that tell their median
  const Eigen::Index window = std::clamp<Eigen::Index>(stamps.size() / 4, 1, 50), all = stamps.size() - window;
  const auto some = Eigen::seq(0, all - 1, 1 + all / enough);
  Eigen::VectorXd intervals = (stamps.tail(all)(some) - stamps.head(all)(some)) / static_cast<double>(window);
  double* middle = intervals.data() + intervals.size() / 2;
  std::nth_element(intervals.data(), middle, intervals.data() + intervals.size());
  return *middle;
}

double roundest(double rate, double uncertainty) {
  for (double scale = 1.0; scale <= 1e6; scale *= 10.0) {
    const double candidate = std::round(rate * scale) / scale;
    if (candidate > 0.0 && std::abs(candidate - rate) <= uncertainty) return candidate;
  }
  return rate;
}

std::optional<EvenTimes> even_times(const Eigen::VectorXd& stamps) {
  constexpr double tolerance = 1e-3;  // of the interval
  const Eigen::Index count = stamps.size();
  if (count < 2 || !stamps.allFinite()) return std::nullopt;
  const double span = stamps[count - 1] - stamps[0], interval = span / static_cast<double>(count - 1);
  const double usual = typical_interval(stamps), unit = resolution(stamps);
  if (!(interval > 0.0 && usual > 0.0)) return std::nullopt;
  // Where the interval is a whole number of the stamps' units, nothing was rounded.
  const double units = unit > 0.0 ? usual / unit : 0.0;
  const bool rounded = std::abs(units - std::round(units)) > 1e-6 * units;
  const double allowed = (rounded ? 1.01 * unit : 0.0) + tolerance * interval +
                         8.0 * std::numeric_limits<double>::epsilon() * stamps.cwiseAbs().maxCoeff();
  for (Eigen::Index k = 1; k < count; ++k) {
    const double line = stamps[0] + interval * static_cast<double>(k);
    if (std::abs(stamps[k] - line) > allowed || std::abs(stamps[k] - stamps[k - 1] - usual) > allowed)
      return std::nullopt;
  }
  const double rate = 1.0 / interval;
  return EvenTimes{stamps[0], 1.0 / roundest(rate, rate * (unit / span + 1e-9))};
}

void set_times(MeasuredChannel& channel, const Eigen::VectorXd& stamps) {
  if (const auto even = even_times(stamps)) {
    channel.start = even->start;
    channel.interval = even->interval;
    channel.times.resize(0);
    return;
  }
  channel.start = stamps.size() > 0 ? stamps[0] : 0.0;
  channel.interval = 0.0;
  channel.times = stamps;
}

}  // namespace kalfem
