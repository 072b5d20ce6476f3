#include "kalfem/verdict/checks.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double chance = 3.2e-5;      ///< of a normal variable beyond four deviations on one side
constexpr double significant = 4.0;    ///< standard deviations beyond chance
constexpr Index parts = 20;            ///< of a record
constexpr Index shortest_part = 50;    ///< samples
constexpr double gate = 5.0;           ///< standard deviations: white noise gets there once in two million samples
constexpr double few_outliers = 0.01;  ///< of the samples: beyond it the sensor is wrong as a whole

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
  for (Index begin = 0; begin + length <= e.size(); begin += length) {
    const Size part = size_of(clipped.segment(begin, length));
    if (part.count < length / 2 || part.rms <= largest) continue;
    largest = part.rms;
    found.largest_part = size_of(e.segment(begin, length)).rms;
    found.part_begin = time(begin);
    found.part_end = time(begin + length);
  }
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
           fmt::format("the innovations of '{}' are {:.3g} times smaller than the filter expects, so that "
                       "stated deviations are too large",
                       name_, 1.0 / found_.ratio),
           fmt::format("state the noise of '{}' as about {}, not {}, or less process noise", name_,
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
    find_largest_part(record, e, found);
    sensors.push_back(found);
  }
  return sensors;
}

std::vector<Reason> innovation_reasons(const InnovationRecord& record) {
  std::vector<Reason> reasons;
  const auto sensors = sensor_consistency(record);
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const auto found = SensorReasons(record, static_cast<Index>(i), sensors[i]).reasons();
    reasons.insert(reasons.end(), found.begin(), found.end());
  }
  return reasons;
}

}  // namespace kalfem
