#include "kalfem/formats/tables/time_axis.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

namespace kalfem {

namespace {

constexpr double rate_agreement = 1e-3;

std::string shown(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 8).ptr};
}

/// One unit of the last decimal to which the stamps are written, from the last of them: formats with a fixed number of
/// digits are coarsest there. Zero when they have all the digits of a double.
double resolution(const Eigen::VectorXd& stamps) {
  const Eigen::VectorXd last = stamps.tail(std::min<Eigen::Index>(64, stamps.size()));
  for (double unit = 1.0, scale = 1.0; scale < 1e12; scale *= 10.0, unit = 1.0 / scale) {
    const Eigen::ArrayXd counts = last.array() * scale;
    const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * std::max(1.0, counts.abs().maxCoeff());
    if ((counts - counts.round()).abs().maxCoeff() <= rounding) return unit;
  }
  return 0.0;
}

/// Median over windows of many intervals: neither rounding nor a few gaps move it.
double typical_interval(const Eigen::VectorXd& stamps) {
  const Eigen::Index window = std::clamp<Eigen::Index>(stamps.size() / 4, 1, 50);
  Eigen::VectorXd intervals =
      (stamps.tail(stamps.size() - window) - stamps.head(stamps.size() - window)) / static_cast<double>(window);
  double* middle = intervals.data() + intervals.size() / 2;
  std::nth_element(intervals.data(), middle, intervals.data() + intervals.size());
  return *middle;
}

/// By how much rounding to `unit` may move an interval; nothing when that is too much to see a gap. Coarse stamps that
/// count whole units (0, 1, 2 ...) are not rounded at all.
std::optional<double> visible_rounding(double unit, double interval) {
  if (unit < 0.75 * interval) return 1.01 * unit;
  const double units = interval / unit;
  if (std::round(units) >= 1.0 && std::abs(units - std::round(units)) < 1e-9) return 0.0;
  return std::nullopt;
}

void find_gaps(const Eigen::VectorXd& stamps, const std::vector<int>& lines, double interval, double tolerance,
               const std::string& column, FileProblems& problems) {
  tolerance += 8.0 * std::numeric_limits<double>::epsilon() * stamps.cwiseAbs().maxCoeff();
  for (Eigen::Index k = 1; k < stamps.size(); ++k) {
    const double found = stamps(k) - stamps(k - 1);
    if (std::abs(found - interval) <= tolerance) continue;
    const double missing = std::round(found / interval) - 1.0;
    problems.add(lines[static_cast<std::size_t>(k)],
                 "'" + column + "' runs from " + shown(stamps(k - 1)) + " s to " + shown(stamps(k)) + " s",
                 found <= 0.0 ? "time must increase"
                              : "the usual interval is " + shown(interval) + " s" +
                                    (missing >= 1.0 ? "; " + shown(missing) + " samples are missing" : ""),
                 "cut the record here, or resample it to equal intervals");
  }
}

/// The number of fewest decimals within `uncertainty` of the rate.
double roundest(double rate, double uncertainty) {
  for (double scale = 1.0; scale <= 1e6; scale *= 10.0) {
    const double candidate = std::round(rate * scale) / scale;
    if (candidate > 0.0 && std::abs(candidate - rate) <= uncertainty) return candidate;
  }
  return rate;
}

}  // namespace

TimeAxis time_axis(const Eigen::VectorXd& stamps, const std::vector<int>& lines, const TimeAxisOptions& options,
                   FileProblems& problems) {
  if (stamps.size() < 2) {
    problems.add(0, "the record has fewer than two samples", "a sampling rate needs two");
    return {};
  }
  const double interval = typical_interval(stamps);
  const double unit = resolution(stamps);
  if (!(interval > 0.0)) {
    problems.add(lines.front(), "the time column '" + options.column + "' does not increase", "time must increase",
                 "name the column with the time in seconds");
    return {};
  }
  const std::optional<double> rounding = visible_rounding(unit, interval);
  if (!rounding && !options.sample_rate) {
    problems.add(lines.front(),
                 "the time column '" + options.column + "' is rounded to " + shown(unit) + " s at intervals of " +
                     shown(interval) + " s",
                 "a missing sample could not be detected", "give the sampling rate");
    return {};
  }
  if (rounding) find_gaps(stamps, lines, interval, options.jitter * interval + *rounding, options.column, problems);

  const double span = stamps(stamps.size() - 1) - stamps(0);
  const double rate = static_cast<double>(stamps.size() - 1) / span;
  if (!options.sample_rate) return {stamps(0), roundest(rate, rate * (unit / span + 1e-9))};
  if (problems.empty() && !(std::abs(rate / *options.sample_rate - 1.0) <= rate_agreement + unit / span))
    problems.add(lines.front(),
                 "the time column '" + options.column + "' gives " + shown(rate) + " Hz, but " +
                     shown(*options.sample_rate) + " Hz was given",
                 "both must agree", "remove or correct the sampling rate");
  return {stamps(0), *options.sample_rate};
}

}  // namespace kalfem
