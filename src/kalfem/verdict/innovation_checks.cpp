// SPDX-License-Identifier: Apache-2.0
#include "kalfem/verdict/checks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();
constexpr double chance = 3.2e-5;      ///< of a normal variable beyond four deviations on one side
constexpr double significant = 4.0;    ///< standard deviations beyond chance
constexpr Index parts = 20;            ///< of a record
constexpr Index shortest_part = 50;    ///< samples
constexpr double gate = 5.0;           ///< standard deviations: white noise gets there once in two million samples
constexpr double few_outliers = 0.05;  ///< of the samples: beyond it the sensor is wrong as a whole
const double half_gate = std::sqrt(0.5) * gate;
constexpr double often = 0.05;  ///< of the time over half the gate: the limit of PX4's checks after a flight
constexpr Index enough = 20;    ///< samples over half the gate that are no chance
constexpr double beyond_half_gate = 4.07e-4;  ///< part of a normal variable there

/// Root mean square of the values that are there, and their number.
struct Size {
  double rms = 0.0;
  Index count = 0;
};

Size size_of(const Eigen::Ref<const VectorXd>& values) {
  double sum = 0.0;
  Index count = 0;
  for (const double value : values)
    if (std::isfinite(value)) {
      sum += value * value;
      ++count;
    }
  return {count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0, count};
}

VectorXd normalised(const InnovationRecord& record, Index sensor) {
  const auto value = record.innovation.row(sensor).array(), deviation = record.deviation.row(sensor).array();
  return (value / deviation).tail(record.innovation.cols() - record.first).matrix().transpose();
}

/// The part that is loudest even where single outliers count as five deviations.
void find_largest_part(const InnovationRecord& record, const VectorXd& e, SensorConsistency& found) {
  const Index length = std::max(shortest_part, e.size() / parts);
  const VectorXd clipped = e.array().isNaN().select(e, e.cwiseMax(-gate).cwiseMin(gate));
  const auto time = [&](Index k) { return record.start + static_cast<double>(record.first + k) / record.sample_rate; };
  double largest = size_of(clipped).rms;
  found.largest_part = std::min(found.ratio, largest);
  found.part_begin = time(0);
  found.part_end = time(e.size());
  for (Index begin = 0; begin + length <= e.size(); begin += length) {
    const Size part = size_of(clipped.segment(begin, length));
    if (part.count < length / 2 || part.rms <= largest) continue;
    largest = part.rms;
    found.largest_part = size_of(e.segment(begin, length)).rms;
    found.part_begin = time(begin);
    found.part_end = time(begin + length);
  }
}

/// Part of the values that are there for which `over` holds.
template <class Over>
double part_over(const VectorXd& values, const Over& over) {
  Index count = 0, all = 0;
  for (Index k = 0; k < values.size(); ++k)
    if (std::isfinite(values[k])) {
      ++all;
      count += over(k) ? 1 : 0;
    }
  return all > 0 ? static_cast<double>(count) / static_cast<double>(all) : 0.0;
}

/// Over half the gate for longer than single events take.
bool often_over(double part, Index samples) {
  return part > often && part * static_cast<double>(samples) > static_cast<double>(enough);
}

/// Whether the mean of e^2 differs from one by more than chance gives.
bool differs(double ratio, double independent_samples) {
  const double n = std::max(1.0, independent_samples), sum = n * ratio * ratio;
  return sum > chi_squared_quantile(1.0 - chance, n) || sum < chi_squared_quantile(chance, n);
}

std::string noise_text(const InnovationRecord& record, Index i, double value) {
  return fmt::format("{:.2g} {}", value, record.units[static_cast<std::size_t>(i)]);
}

class SensorReasons {
public:
  SensorReasons(const InnovationRecord& record, Index sensor, const SensorConsistency& found)
      : record_(record), i_(sensor), name_(record.sensors[static_cast<std::size_t>(sensor)]), found_(found) {}

  std::vector<Reason> reasons() {
    if (found_.samples < 2) return {};
    check_size();
    check_part();
    check_time();
    check_correlation();
    check_outliers();
    return std::move(reasons_);
  }

private:
  void check_size() {
    if (!differs(found_.ratio, found_.independent_samples())) return;
    const double noise = record_.noise[i_];
    if (state_of(found_.ratio) != VerdictState::consistent)
      reasons_.push_back(
          {"innovation_large", name_,
           fmt::format("the innovations of '{}' are {:.3g} times as large as the filter expects, so that "
                       "stated deviations are too small by as much",
                       name_, found_.ratio),
           fmt::format("check the sensor's sign, unit, channel, place and clock and the model near it; "
                       "where these are right, its noise is about {}, not {}",
                       noise_text(record_, i_, noise * found_.ratio), noise_text(record_, i_, noise)),
           state_of(found_.ratio), found_.ratio});
    if (state_of(1.0 / found_.ratio) != VerdictState::consistent)
      reasons_.push_back(
          {"noise_too_large", name_,
           fmt::format("the noise of '{}' is {} {:.2g} times too large: its innovations are smaller than "
                       "expected by as much, and deviations of estimates that rest on it are too wide by up to as much",
                       name_, record_.adapted_noise ? "adapted" : "stated", 1.0 / found_.ratio),
           record_.adapted_noise
               ? fmt::format("state less process noise, or a shorter memory: on average '{}' was given {}", name_,
                             noise_text(record_, i_, noise))
               : fmt::format("state the noise of '{}' as about {}, not {}, or less process noise", name_,
                             noise_text(record_, i_, noise * found_.ratio), noise_text(record_, i_, noise)),
           VerdictState::suspicious, 1.0 / found_.ratio});
  }

  /// A part of the record that is louder than the rest and than expected: quiet parts must not average it away.
  void check_part() {
    const double samples = found_.independent_samples() / static_cast<double>(parts);
    if (state_of(found_.largest_part) == VerdictState::consistent || !differs(found_.largest_part, samples)) return;
    if (found_.largest_part < suspicious_widening * found_.ratio && state_of(found_.ratio) != VerdictState::consistent)
      return;
    reasons_.push_back(
        {"innovation_large_in_part", name_,
         fmt::format("from {:.4g} to {:.4g} s the innovations of '{}' are {:.3g} times as large as the "
                     "filter expects",
                     found_.part_begin, found_.part_end, name_, found_.largest_part),
         fmt::format("look at the record there: saturation, a loose cable, or motion that the model does "
                     "not follow when it is large"),
         VerdictState::suspicious, found_.largest_part});
  }

  /// Neither the whole nor one part is too large, and yet the sensor is far off for much of the time.
  void check_time() {
    if (!reasons_.empty() || !often_over(found_.beyond_half_gate, found_.samples)) return;
    reasons_.push_back(
        {"innovation_large_often", name_,
         fmt::format("'{}' lies more than {:.2g} expected deviations from its prediction in {:.2g} % of the time "
                     "(expected 0.04 %)",
                     name_, half_gate, 100.0 * found_.beyond_half_gate),
         fmt::format("look at where '{}' leaves its band on the page: impacts, a loose cable, or motion that the model "
                     "does not follow",
                     name_),
         VerdictState::suspicious, suspicious_widening});
  }

  /// Correlation matters as far as it makes deviations too small: noise that is stated too large may outweigh it. By
  /// itself it is a suspicion, as robust deviations allow for it; with innovations that are too large as well, the
  /// model neither explains the record nor says how much it misses.
  void check_correlation() {
    const auto& lag = found_.lag_one;
    const VerdictState state = state_of(found_.widening());
    if (std::abs(lag.value) < significant / 1.96 * lag.band || state_of(lag.widening()) == VerdictState::consistent ||
        state == VerdictState::consistent)
      return;
    reasons_.push_back(
        {"innovation_correlated", name_,
         fmt::format("successive innovations of '{}' are correlated by {:.2g} (expected 0 +- {:.2g}): the model misses "
                     "part of the motion, and deviations of parameters are up to {:.2g} times too small",
                     name_, lag.value, lag.band, found_.widening()),
         fmt::format("look for a wrong fixed parameter, a missing mode or another law near '{}', and for a wrong sign, "
                     "unit or clock of a channel; rely on std_robust in the place of std",
                     name_),
         state_of(found_.ratio) == VerdictState::consistent ? VerdictState::suspicious : state, found_.widening()});
  }

  void check_outliers() {
    if (!reasons_.empty() && reasons_.back().code == "innovation_large_in_part") return;
    const VectorXd e = normalised(record_, i_);
    Index count = 0, worst = 0;
    double largest = gate;
    for (Index k = 0; k < e.size(); ++k) {
      if (!(std::abs(e[k]) > gate)) continue;
      ++count;
      if (std::abs(e[k]) > largest) {
        largest = std::abs(e[k]);
        worst = k;
      }
    }
    if (count == 0 || static_cast<double>(count) > few_outliers * static_cast<double>(e.size()) ||
        state_of(found_.ratio) != VerdictState::consistent || largest < 2.0 * gate)
      return;
    const double time = record_.start + static_cast<double>(record_.first + worst) / record_.sample_rate;
    reasons_.push_back(
        {"outliers", name_,
         fmt::format("{} of {} samples of '{}' lie more than {:.2g} deviations from their prediction, the "
                     "worst at {:.4g} s by {:.3g}",
                     count, e.size(), name_, gate, time, largest),
         "look at the record there, and leave these samples empty with record.skip_missing", VerdictState::suspicious,
         1.0});
  }

  const InnovationRecord& record_;
  Index i_;
  std::string name_;
  const SensorConsistency& found_;
  std::vector<Reason> reasons_;
};

}  // namespace

double SensorConsistency::independent_samples() const {
  const double square = lag_one.value * lag_one.value;
  return static_cast<double>(samples) * (1.0 - square) / (1.0 + square);
}

double SensorConsistency::widening() const { return ratio * lag_one.widening(); }

std::vector<SensorConsistency> sensor_consistency(const InnovationRecord& record) {
  std::vector<SensorConsistency> sensors;
  for (Index i = 0; i < record.innovation.rows(); ++i) {
    const VectorXd e = normalised(record, i);
    SensorConsistency found;
    const Size whole = size_of(e);
    found.ratio = whole.rms;
    found.samples = whole.count;
    found.lag_one = autocorrelation(e);
    found.beyond_half_gate = part_over(e, [&](Index k) { return std::abs(e[k]) > half_gate; });
    find_largest_part(record, e, found);
    sensors.push_back(found);
  }
  return sensors;
}

// Sums over the samples from the first one on; samples without a measurement are left out. The spread of a sum of NIS
// is that of as many independent samples as its autocorrelation leaves.
NisConsistency nis_consistency(const InnovationRecord& record) {
  NisConsistency found;
  const Index count = std::max<Index>(0, record.nis.size() - record.first);
  const VectorXd nis = record.nis.tail(count), degrees = record.measured.tail(count).cast<double>();
  const auto there = nis.array().isFinite() && degrees.array() > 0.0;
  const VectorXd value = there.select(nis, 0.0), freedom = there.select(degrees, 0.0);
  found.samples = there.count();
  if (found.samples == 0) return found;
  found.mean_degrees = freedom.sum() / static_cast<double>(found.samples);
  found.ratio = found.largest_part = value.sum() / freedom.sum();
  const VectorXd excess = there.select((nis - degrees).cwiseQuotient((2.0 * degrees).cwiseSqrt()), missing);
  const double rho = std::clamp(autocorrelation(excess).value, 0.0, 0.9999);
  found.independent_samples = static_cast<double>(found.samples) * (1.0 - rho) / (1.0 + rho);
  std::map<double, double> limits;
  found.beyond_half_gate = part_over(excess, [&](Index k) {
    const auto [limit, added] = limits.try_emplace(degrees[k]);
    if (added) limit->second = chi_squared_quantile(1.0 - beyond_half_gate, degrees[k]);
    return nis[k] > limit->second;
  });
  const Index length = std::max(shortest_part, count / parts);
  const auto time = [&](Index k) { return record.start + static_cast<double>(record.first + k) / record.sample_rate; };
  found.part_begin = time(0);
  found.part_end = time(count);
  for (Index begin = 0; begin + length <= count; begin += length) {
    const auto part = Eigen::seqN(begin, length);
    if (there(part).count() < length / 2) continue;
    const double ratio = value(part).sum() / freedom(part).sum();
    if (ratio <= found.largest_part) continue;
    found.largest_part = ratio;
    found.part_begin = time(begin);
    found.part_end = time(begin + length);
  }
  return found;
}

namespace {

/// Whether a mean of NIS over this part of the samples is larger than expected by more than chance.
bool exceeds_chance(const NisConsistency& found, double ratio, double part) {
  const double freedom = part * found.independent_samples * found.mean_degrees;
  return freedom > 0.0 && (ratio - 1.0) > significant * std::sqrt(2.0 / freedom);
}

/// What all sensors together say where none does by itself.
void add_nis_reason(const InnovationRecord& record, std::vector<Reason>& reasons) {
  const auto found = nis_consistency(record);
  if (found.samples < 2) return;
  const double whole = std::sqrt(found.ratio), part = std::sqrt(found.largest_part);
  const bool large = state_of(whole) != VerdictState::consistent && exceeds_chance(found, found.ratio, 1.0);
  const double share = std::max(1.0 / static_cast<double>(parts),
                                std::min(1.0, static_cast<double>(shortest_part) / static_cast<double>(found.samples)));
  const std::string remedy =
      "look at the innovations of all sensors on the page: a wrong excitation, clock or parameter moves several at "
      "once";
  if (large || often_over(found.beyond_half_gate, found.samples))
    reasons.push_back(
        {"nis_large", "all sensors",
         fmt::format("the mean NIS is {:.3g} (expected {:.3g}), and {:.2g} % of the samples lie beyond half "
                     "the gate (expected 0.04 %): the sensors together contradict the model, though none "
                     "does by itself",
                     found.ratio * found.mean_degrees, found.mean_degrees, 100.0 * found.beyond_half_gate),
         remedy, large ? state_of(whole) : VerdictState::suspicious, std::max(1.0, whole)});
  else if (state_of(part) != VerdictState::consistent && exceeds_chance(found, found.largest_part, share))
    reasons.push_back(
        {"nis_large_in_part", "all sensors",
         fmt::format("from {:.4g} to {:.4g} s the mean NIS is {:.3g} (expected {:.3g}), though no sensor by "
                     "itself is too large there",
                     found.part_begin, found.part_end, found.largest_part * found.mean_degrees, found.mean_degrees),
         remedy, VerdictState::suspicious, part});
}

}  // namespace

std::vector<Reason> innovation_reasons(const InnovationRecord& record) {
  std::vector<Reason> reasons;
  const auto sensors = sensor_consistency(record);
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const auto found = SensorReasons(record, static_cast<Index>(i), sensors[i]).reasons();
    reasons.insert(reasons.end(), found.begin(), found.end());
  }
  const bool told = std::ranges::any_of(reasons, [](const Reason& reason) {
    return reason.code.starts_with("innovation_large") || reason.code == "outliers";
  });
  if (!told) add_nis_reason(record, reasons);
  return reasons;
}

}  // namespace kalfem
