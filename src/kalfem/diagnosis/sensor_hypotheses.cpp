// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kalfem/diagnosis/candidates.hpp"
#include "kalfem/records/clock_lag.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double like_a_unit = 0.15;      ///< relative distance of a gain from a mistake of units
constexpr double clear_likeness = 0.5;    ///< correlation that tells a sign
constexpr double far_from_one = 1.0;      ///< logarithm of a gain that must be a mistake of units, if it is one
constexpr double worth_a_gain = 0.03;     ///< relative
constexpr double worth_a_delay = 0.15;    ///< correlation at its lag
constexpr double worth_a_drift = 4.0;     ///< standard deviations
constexpr Index unknown_ends = 10;        ///< samples at an end that are not known at other times
constexpr double clipped_samples = 2e-3;  ///< of all, at the channel's extremes
constexpr Index most_swapped = 6;         ///< sensors that are exchanged in pairs

/// Samples of a channel that are there.
Index present(const Eigen::Ref<const VectorXd>& channel) { return channel.array().isFinite().count(); }

/// The input with other samples of one channel.
template <class Change>
Correction with(const DiagnosisInput& input, const std::string& channel, const Change& change) {
  Correction made{input};
  Record& record = made.input.record;
  const Index row = record.find(channel);
  record.values.row(row) = change(VectorXd(record.values.row(row).transpose())).transpose();
  return made;
}

/// Samples moved to earlier times; what comes from beyond their ends is missing.
VectorXd earlier(const VectorXd& recorded, Index lag) {
  VectorXd moved = VectorXd::Constant(recorded.size(), not_a_number);
  const Index count = recorded.size() - std::abs(lag);
  if (count > 0) moved.segment(std::max<Index>(-lag, 0), count) = recorded.segment(std::max<Index>(lag, 0), count);
  return moved;
}

/// The input with a channel moved to earlier times by so many samples, as recorded where these are whole.
Correction with_true_clock(const DiagnosisInput& input, const std::string& channel, double lag) {
  return with(input, channel, [&](const VectorXd& recorded) {
    if (lag == std::round(lag)) return earlier(recorded, static_cast<Index>(lag));
    return without_lag(input.record, input.record.find(channel), {lag / input.record.sample_rate, 0.0});
  });
}

/// Mistakes of units that may be behind a gain. One that is far from 1 is known roughly, as the model may be wrong
/// besides: then the usual mistakes as well.
std::vector<double> units_for(const std::optional<double>& gain) {
  std::vector<double> units = unit_factors_near(gain, like_a_unit);
  if (gain && std::abs(std::log(*gain)) > far_from_one)
    for (const double usual : unit_factors_near(std::nullopt, 0.0))
      if (std::ranges::find(units, usual) == units.end()) units.push_back(usual);
  return units;
}

bool drifts(const ClockFit& clock) { return std::abs(clock.drift) > worth_a_drift * clock.drift_deviation; }

/// Channels with a clock that was late by a delay at the record's start and drifts. What comes from near their ends is
/// missing.
Hypothesis drifting(const Record& record, const std::vector<std::string>& names, const ClockFit& clock) {
  const bool late = std::abs(clock.delay) > worth_a_drift * clock.delay_deviation && std::abs(clock.delay) > 0.5;
  const double delay = late ? clock.delay / record.sample_rate : 0.0;
  const std::string all = fmt::format("{}", fmt::join(names, ", "));
  const auto correct = [names, delay](const DiagnosisInput& given, double drift) {
    Correction made{given};
    Record& corrected = made.input.record;
    for (const auto& name : names) {
      const Index row = corrected.find(name);
      corrected.values.row(row) = without_lag(given.record, row, {delay, drift, given.record.start}).transpose();
      const Index unknown = std::min(unknown_ends, corrected.samples());
      corrected.values.row(row).tail(unknown).setConstant(not_a_number);
      if (delay != 0.0) corrected.values.row(row).head(unknown).setConstant(not_a_number);
    }
    return made;
  };
  const auto words = [all, delay](double drift, const auto&) {
    const std::string also =
        delay == 0.0 ? "" : fmt::format(", {} ms late at the start of the record", in_words(1e3 * delay));
    return fmt::format("the clock of '{}' runs {} ppm {}{}", all, in_words(1e6 * std::abs(drift)),
                       drift > 0.0 ? "fast" : "slow", also);
  };
  const std::string unknown = delay == 0.0 ? ".drift" : ".drift and .delay";
  return {.code = "sensor_drift",
          .subject = all,
          .starts = {clock.drift},
          .search = Search::offset,
          .step = std::max(clock.drift_deviation, 0.02 / static_cast<double>(record.samples())),
          .fitted = late ? 2 : 1,
          .correct = correct,
          .words = words,
          .remedy = fmt::format("state it as `drift` of '{}' in `sensors`; or estimate it: sensors.{}{}", all,
                                names.front(), unknown)};
}

/// Changes of one channel of a run.
class ChannelHypotheses {
public:
  ChannelHypotheses(const Record& record, const FilterRun& base, Index channel, const Likeness& likeness)
      : record_(record),
        base_(base),
        i_(channel),
        name_(base.input.measured.channels[static_cast<std::size_t>(channel)].name),
        unit_(base.input.measured.channels[static_cast<std::size_t>(channel)].unit),
        likeness_(likeness),
        recorded_(base.input.measured.values.row(channel).transpose()) {}

  std::vector<Hypothesis> all() {
    add_sign();
    add_gain();
    add_delay();
    add_drift();
    add_offset();
    add_saturation();
    add_noise();
    return std::move(found_);
  }

private:
  void add_sign() {
    found_.push_back(
        {.code = "sensor_sign",
         .subject = name_,
         .correct =
             [name = name_](const DiagnosisInput& input, double) {
               return with(input, name, [](const VectorXd& recorded) { return VectorXd(-recorded); });
             },
         .words = [name = name_](double, const auto&) { return fmt::format("'{}' has the wrong sign", name); },
         .remedy = "turn the direction of '" + name_ + "' in the case (a point such as -body.3)"});
  }

  void add_gain() {
    const bool known = likeness_.known && likeness_.gain != 0.0;
    const bool clear = std::abs(likeness_.correlation) > clear_likeness;
    const double gain = std::abs(likeness_.gain), turned = known && clear && likeness_.gain < 0.0 ? -1.0 : 1.0;
    const auto correct = [name = name_, count = present(recorded_), turned](const DiagnosisInput& input,
                                                                            double factor) {
      auto made = with(input, name, [&](const VectorXd& recorded) { return VectorXd(recorded / (turned * factor)); });
      made.log_jacobian = -static_cast<double>(count) * std::log(std::abs(factor));
      return made;
    };
    for (const double unit : units_for(known ? std::optional(gain) : std::nullopt))
      found_.push_back({.code = "sensor_unit",
                        .subject = name_,
                        .starts = {unit},
                        .correct = correct,
                        .words =
                            [name = name_](double factor, const auto&) {
                              return fmt::format("the unit of '{}' is wrong by {}: {}", name, in_words(factor),
                                                 unit_mistake(factor).value_or(""));
                            },
                        .remedy = "correct the unit of the channel '" + name_ + "' in the record or in the case",
                        .turned = turned < 0.0});
    if (known && std::abs(std::log(gain)) > worth_a_gain)
      found_.push_back({.code = "sensor_gain",
                        .subject = name_,
                        .starts = {gain},
                        .search = Search::factor,
                        .step = 0.05,
                        .fitted = 1,
                        .correct = correct,
                        .words =
                            [name = name_](double factor, const auto&) {
                              return fmt::format("'{}' is {} times as large as it should be", name, in_words(factor));
                            },
                        .remedy = "check the sensitivity and the unit of '" + name_ + "'",
                        .turned = turned < 0.0});
  }

  void add_delay() {
    if (!likeness_.known || likeness_.lag == 0 || std::abs(likeness_.correlation) < worth_a_delay) return;
    const double rate = base_.input.measured.sample_rate;
    found_.push_back({.code = "sensor_delay",
                      .subject = name_,
                      .starts = {static_cast<double>(likeness_.lag)},
                      .search = Search::samples,
                      .step = 1.0,
                      .fitted = 1,
                      .correct = [name = name_](const DiagnosisInput& input,
                                                double lag) { return with_true_clock(input, name, lag); },
                      .words =
                          [name = name_, rate](double lag, const auto&) {
                            return fmt::format("'{}' is {} ms {}", name, in_words(1e3 * std::abs(lag) / rate),
                                               lag > 0.0 ? "late" : "early");
                          },
                      .remedy = "align the clock of '" + name_ + "' with the others before the estimation"});
  }

  void add_drift() {
    if (likeness_.clock && drifts(*likeness_.clock)) found_.push_back(drifting(record_, {name_}, *likeness_.clock));
  }

  void add_offset() {
    const double noise = std::sqrt(base_.input.noise(i_, i_));
    if (!likeness_.known || std::abs(likeness_.offset) < 0.2 * noise) return;
    found_.push_back({.code = "sensor_offset",
                      .subject = name_,
                      .starts = {likeness_.offset},
                      .search = Search::offset,
                      .step = 0.1 * noise,
                      .fitted = 1,
                      .correct =
                          [name = name_](const DiagnosisInput& input, double offset) {
                            return with(input, name,
                                        [&](const VectorXd& recorded) { return VectorXd(recorded.array() - offset); });
                          },
                      .words =
                          [name = name_, unit = unit_](double offset, const auto&) {
                            return fmt::format("'{}' has an offset of {} {}", name, in_words(offset), unit);
                          },
                      .remedy = "remove the offset of '" + name_ + "' from the record"});
  }

  /// Samples at the largest or smallest value, where these repeat, are taken for missing.
  void add_saturation() {
    const auto there = recorded_.array().isFinite();
    const double high = there.select(recorded_.array(), -1e300).maxCoeff();
    const double low = there.select(recorded_.array(), 1e300).minCoeff();
    const double near = 1e-6 * (high - low);
    const Eigen::Array<bool, Eigen::Dynamic, 1> clipped =
        there && (recorded_.array() > high - near || recorded_.array() < low + near);
    const double part =
        static_cast<double>(clipped.count()) / static_cast<double>(std::max<Index>(1, present(recorded_)));
    if (part < clipped_samples || !(high > low)) return;
    found_.push_back({.code = "sensor_saturated",
                      .subject = name_,
                      .correct =
                          [name = name_, clipped](const DiagnosisInput& input, double) {
                            return with(input, name, [&](const VectorXd& recorded) {
                              return VectorXd(clipped.select(not_a_number, recorded));
                            });
                          },
                      .words =
                          [name = name_, unit = unit_, high, low, part](double, const auto&) {
                            return fmt::format("'{}' is cut off at {} and {} {} ({:.2g} % of its samples)", name,
                                               in_words(low), in_words(high), unit, 100.0 * part);
                          },
                      .remedy = "measure '" + name_ +
                                "' with a larger range, or leave these samples empty with "
                                "record.skip_missing"});
  }

  void add_noise() {
    found_.push_back({.code = "sensor_noise",
                      .subject = name_,
                      .starts = {0.5, 1.5, 5.0},
                      .search = Search::factor,
                      .step = 0.4,
                      .fitted = 2,
                      .widens = true,
                      .correct =
                          [i = i_](const DiagnosisInput& input, double factor) {
                            Correction made{input};
                            made.input.on_run.emplace_back(
                                [i, factor](FilterRun& run) { run.input.noise(i, i) *= factor * factor; });
                            return made;
                          },
                      .words =
                          [name = name_](double factor, const auto&) {
                            return factor > 1.0 ? fmt::format(
                                                      "'{}' does not fit the others: its deviation is {} times the "
                                                      "stated noise",
                                                      name, in_words(factor))
                                                : fmt::format("the noise of '{}' is {} times the stated one", name,
                                                              in_words(factor));
                          },
                      .remedy = "state the noise of '" + name_ + "' as it is"});
  }

  const Record& record_;
  const FilterRun& base_;
  Index i_;
  std::string name_, unit_;
  Likeness likeness_;
  VectorXd recorded_;
  std::vector<Hypothesis> found_;
};

Hypothesis swapped(const std::string& one, const std::string& other) {
  return {.code = "sensors_swapped",
          .subject = one + ", " + other,
          .correct =
              [one, other](const DiagnosisInput& input, double) {
                Correction made{input};
                Record& record = made.input.record;
                record.values.row(record.find(one)).swap(record.values.row(record.find(other)));
                return made;
              },
          .words = [one, other](double, const auto&) { return fmt::format("'{}' and '{}' are exchanged", one, other); },
          .remedy = "exchange the channels of '" + one + "' and '" + other + "'"};
}

/// Pairs of sensors of one unit, of those that fit the others worst.
void add_swapped(const FilterRun& base, const std::vector<Likeness>& likeness, std::vector<Hypothesis>& found) {
  const auto& channels = base.input.measured.channels;
  std::vector<Index> worst(channels.size());
  for (std::size_t i = 0; i < worst.size(); ++i) worst[i] = static_cast<Index>(i);
  std::ranges::stable_sort(worst, {}, [&](Index i) {
    const auto& of = likeness[static_cast<std::size_t>(i)];
    return of.known ? -std::abs(of.gain - 1.0) : 0.0;
  });
  if (static_cast<Index>(worst.size()) > most_swapped) worst.resize(most_swapped);
  for (std::size_t a = 0; a < worst.size(); ++a)
    for (std::size_t b = a + 1; b < worst.size(); ++b) {
      const auto& one = channels[static_cast<std::size_t>(std::min(worst[a], worst[b]))];
      const auto& other = channels[static_cast<std::size_t>(std::max(worst[a], worst[b]))];
      if (one.unit == other.unit) found.push_back(swapped(one.name, other.name));
    }
}

/// Channels of one rack: those whose clocks drift alike.
void add_drifting_rack(const Record& record, const FilterRun& base, const std::vector<Likeness>& likeness,
                       std::vector<Hypothesis>& found) {
  constexpr double alike = 0.15;
  std::vector<std::string> best;
  ClockFit of_best;
  for (const auto& one : likeness) {
    if (!one.clock || !drifts(*one.clock)) continue;
    std::vector<std::string> names;
    ClockFit sum;
    for (std::size_t i = 0; i < likeness.size(); ++i) {
      const auto& other = likeness[i].clock;
      if (!other || !(std::abs(other->drift - one.clock->drift) < alike * std::abs(one.clock->drift))) continue;
      names.push_back(base.input.measured.channels[i].name);
      sum.drift += other->drift;
      sum.drift_deviation = std::max(sum.drift_deviation, other->drift_deviation);
    }
    if (names.size() < 2 || names.size() <= best.size()) continue;
    of_best = sum;
    of_best.drift /= static_cast<double>(names.size());
    best = names;
  }
  if (!best.empty()) found.push_back(drifting(record, best, of_best));
}

/// A factor of every channel alike: a record in other units.
void add_gain_of_all(const FilterRun& base, const Likeness& of_all, std::vector<Hypothesis>& found) {
  const bool known = of_all.known && of_all.gain != 0.0;
  if (base.input.measured.values.rows() < 2) return;
  const auto& channels = base.input.measured.channels;
  const auto count = base.input.measured.values.array().isFinite().count();
  for (const double unit : unit_factors_near(known ? std::optional(of_all.gain) : std::nullopt, 2.0 * like_a_unit))
    found.push_back({.code = "record_unit",
                     .subject = "all sensors",
                     .starts = {unit},
                     .correct =
                         [channels = channels, count](const DiagnosisInput& input, double factor) {
                           Correction made{input, -static_cast<double>(count) * std::log(factor)};
                           Record& record = made.input.record;
                           for (const auto& channel : channels) record.values.row(record.find(channel.name)) /= factor;
                           return made;
                         },
                     .words =
                         [](double factor, const auto&) {
                           return fmt::format("the unit of the whole record is wrong by {}: {}", in_words(factor),
                                              unit_mistake(factor).value_or(""));
                         },
                     .remedy = "correct the units of the record's channels"});
}

}  // namespace

std::vector<Hypothesis> sensor_hypotheses(const DiagnosisInput& input, const FilterRun& base,
                                          const std::vector<Likeness>& likeness, const Likeness& of_all) {
  std::vector<Hypothesis> found;
  for (std::size_t i = 0; i < likeness.size(); ++i) {
    auto own = ChannelHypotheses(input.record, base, static_cast<Index>(i), likeness[i]).all();
    found.insert(found.end(), std::make_move_iterator(own.begin()), std::make_move_iterator(own.end()));
  }
  add_swapped(base, likeness, found);
  add_drifting_rack(input.record, base, likeness, found);
  add_gain_of_all(base, of_all, found);
  return found;
}

}  // namespace kalfem
