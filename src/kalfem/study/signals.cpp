// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <map>
#include <sstream>

#include "kalfem/base/units.hpp"
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/formats/record_file.hpp"
#include "kalfem/records/gap_bridge.hpp"
#include "kalfem/records/oversampling.hpp"
#include "kalfem/study/alignment.hpp"
#include "kalfem/study/assembly.hpp"
#include "kalfem/system/signals/deterministic.hpp"
#include "kalfem/system/signals/ground_motion.hpp"
#include "kalfem/system/signals/integrated_velocity.hpp"
#include "kalfem/system/signals/random_signal.hpp"
#include "kalfem/system/signals/remembered.hpp"
#include "kalfem/system/signals/sampled.hpp"
#include "kalfem/yaml/bounds.hpp"

namespace kalfem {
namespace {

namespace d = description;

/// Knots per period of the highest frequency for the integration of a signal: the error is 1e-9 of the motion.
constexpr double knots_per_period = 32.0;
/// Removed drift, relative to the remaining motion, above which the user is told.
constexpr double told_drift = 0.1;

/// SI unit of a value that may have any.
std::string unit_of(const d::Value& value) { return value.value.bare ? "-" : si_unit(value.value.dimension); }

/// SI unit of a law's signal, as the case states it.
std::string unit_of(const d::Signal& signal) {
  if (const auto* channel = std::get_if<d::ChannelSignal>(&signal)) try {
      return si_unit(parse_unit(channel->unit.value).dimension);
    } catch (const InvalidInput& error) {
      throw InvalidInput(channel->unit.issue(error.issues().front().what, error.issues().front().why, ""));
    }
  return std::visit(
      [](const auto& each) -> std::string {
        if constexpr (requires { each.rms.value.bare; }) return unit_of(each.rms);
        if constexpr (requires { each.amplitude.value.bare; }) return unit_of(each.amplitude);
        if constexpr (requires { each.value.value.bare; }) return unit_of(each.value);
        return "s";
      },
      signal);
}

/// Unit of an excitation as the user gives it.
std::string unit_of(const d::Excitation& excitation) {
  if (std::holds_alternative<d::SignalTarget>(excitation.target)) return unit_of(*excitation.signal);
  if (std::holds_alternative<d::BaseDisplacement>(excitation.target)) return unit_of(InputKind::base_displacement);
  if (std::holds_alternative<d::BaseVelocity>(excitation.target)) return "m/s";
  return unit_of(std::holds_alternative<d::Force>(excitation.target) ? InputKind::force : InputKind::base_acceleration);
}

template <class Signal>
SourceLocation place_of(const Signal& signal) {
  if constexpr (requires { signal.rms.location; }) return signal.rms.location;
  if constexpr (requires { signal.amplitude.location; }) return signal.amplitude.location;
  if constexpr (requires { signal.input.location; }) return signal.input.location;
  return {};
}

/// The signals made so far, each as given and, if needed, integrated twice to a displacement. Signals that refer to
/// others find them here.
struct MadeSignals {
  const d::Case& given;
  double duration;
  SignalNotes& notes;
  std::map<std::pair<std::string, bool>, SignalPtr> made = {};
};

SignalPtr signal_of(MadeSignals& all, const std::string& name, bool integrated);

/// The time of the record.
class ClockSignal final : public FormulaSignal {
  [[nodiscard]] Eigen::Array<double, 1, 3> at(double time) const override { return {time, 1.0, 0.0}; }
};

/// A displacement whose rate was measured too: value of the one, and of the other the value as rate and the rate as
/// acceleration.
class WithMeasuredRate final : public Signal {
public:
  WithMeasuredRate(SignalPtr value, SignalPtr rate) : value_(std::move(value)), rate_(std::move(rate)) {}
  [[nodiscard]] SignalSamples sample(double start, double step, Eigen::Index count) const override {
    SignalSamples samples = value_->sample(start, step, count);
    samples.rightCols<2>() = rate_->sample(start, step, count).leftCols<2>();
    return samples;
  }
  [[nodiscard]] bool covers(double begin, double end) const override {
    return value_->covers(begin, end) && rate_->covers(begin, end);
  }
  [[nodiscard]] double determined_until() const override {
    return std::min(value_->determined_until(), rate_->determined_until());
  }

private:
  SignalPtr value_, rate_;
};

SignalPtr with_measured_rate(SignalPtr value, SignalPtr rate) {
  return std::make_shared<const WithMeasuredRate>(std::move(value), std::move(rate));
}

/// Makes the signal of one excitation. An accelerated ground needs its displacement: sums of sines and pulses are
/// integrated in closed form; all other signals are integrated numerically on knots (GroundMotion), which also removes
/// the drift unless the case keeps it. Delayed and trailing inputs reuse the signal they refer to.
class SignalMaker {
public:
  /// `integrated`: the signal is a ground acceleration and its displacement is wanted.
  SignalMaker(MadeSignals& all, const std::string& name, const d::Excitation& excitation, bool integrated)
      : all_(all), name_(name), excitation_(excitation), unit_(unit_of(excitation)), integrated_(integrated) {}

  SignalPtr make() {
    check_drift();
    if (!excitation_.signal) return make_constant(0.0);  // only the filter has this input
    const auto signal = std::visit([&](const auto& each) { return from(each); }, *excitation_.signal);
    return excitation_.scale == 1.0 ? signal : scaled(signal, excitation_.scale);
  }

private:
  [[nodiscard]] bool follows_another() const {
    return excitation_.signal_as<d::Delayed>() || excitation_.signal_as<d::Trailing>();
  }
  /// Whether the displacement is wanted of a velocity that this excitation gives.
  [[nodiscard]] bool is_velocity() const {
    return std::holds_alternative<d::BaseVelocity>(excitation_.target) && !follows_another();
  }
  /// Whether the acceleration is integrated from rest as it is, with its drift.
  [[nodiscard]] bool keeps_drift() const { return excitation_.drift && excitation_.drift->value == Drift::keep; }

  void check_drift() const {
    if (!excitation_.drift) return;
    const auto refuse = [&](const std::string& why, const std::string& fix) {
      const auto& [value, location, path] = *excitation_.drift;
      throw InvalidInput(Issue{location, path + " has no effect here", why, fix});
    };
    if (!excitation_.signal) refuse("the excitation has no signal to integrate", "remove it");
    if (!integrated_ && !follows_another())
      refuse("only accelerations of named grounds are integrated", "remove it, or accelerate grounds by name");
    if (follows_another()) refuse("the motion is that of the input that it refers to", "give `drift` at that input");
    const bool lasting = excitation_.signal_as<d::Impulse>() || excitation_.signal_as<d::Constant>();
    if (lasting && !keeps_drift())
      refuse("an impulse or a constant acceleration moves the ground permanently, which is not drift",
             "remove it or write drift: keep");
  }

  /// The straight line that is taken out of a displacement would be most of this one.
  [[noreturn]] static void refuse_lasting(const std::string& velocity) {
    throw InvalidInput(velocity + " moves the ground for good", "base_velocity is for motions about a place of rest",
                       "give its displacement by base_displacement");
  }

  /// Whether the lines of a spectrum are integrated one by one.
  [[nodiscard]] bool integrates_lines() const { return integrated_ && !keeps_drift(); }

  SignalPtr from(const d::RandomSignal& g) {
    const double duration = g.duration.value_or(all_.duration);
    const auto signal = make_random({.rms = checked_number(g.rms, unit_, Bounds::nonnegative()),
                                     .lower = g.band[0],
                                     .upper = g.band[1],
                                     .duration = duration,
                                     .fade_in = g.fade_in,
                                     .integrated_twice = integrates_lines(),
                                     .seed = g.seed,
                                     .name = name_});
    return integrates_lines() ? signal : integrated_from_rest(signal, g.band[1], duration);
  }
  SignalPtr from(const d::Sine& g) {
    const auto signal = make_sine({.amplitude = checked_number(g.amplitude, unit_),
                                   .frequency = g.frequency,
                                   .phase = g.phase,
                                   .fade_in = g.fade_in,
                                   .integrated_twice = integrates_lines()});
    return integrates_lines() ? signal : integrated_from_rest(signal, g.frequency, all_.duration);
  }
  SignalPtr from(const d::SweptSine& g) {
    const double duration = g.duration.value_or(all_.duration);
    const auto signal = make_swept_sine({.amplitude = checked_number(g.amplitude, unit_),
                                         .from = g.from,
                                         .to = g.to,
                                         .duration = duration,
                                         .sweep = g.kind,
                                         .fade_in = g.fade_in});
    return integrated_from_rest(signal, std::max(g.from, g.to), duration);
  }
  SignalPtr from(const d::Impulse& g) {
    if (is_velocity()) refuse_lasting("an impulse");
    return make_pulse({.amplitude = checked_number(g.amplitude, unit_),
                       .start = g.start,
                       .duration = g.duration,
                       .shape = g.shape,
                       .integrated_twice = integrated_});
  }
  SignalPtr from(const d::Road& g) {
    if (unit_ != "m")
      throw InvalidInput("a road profile is a displacement [m]", "a value in " + unit_ + " is needed",
                         "move a ground by it: base_displacement");
    return make_road_profile({.road_class = g.road_class,
                              .speed = g.speed,
                              .lower = g.band[0],
                              .upper = g.band[1],
                              .duration = g.duration.value_or(all_.duration),
                              .fade_in = g.fade_in,
                              .seed = g.seed,
                              .name = name_});
  }
  SignalPtr from(const d::FileSignal& g) {
    if (all_.given.live) return make_constant(0.0);  // its samples come with the stream
    if (g.file == d::from_stream)
      throw InvalidInput("`file: live` is given, but the case has no `live`",
                         "there is no stream that it could come with", "name the table, or add `live`");
    PreparedRecord prepared{read_record_file(
        g.file,
        {{.column = g.channel.value,
          .owner = "excitation." + name_,
          .unit = unit_,
          .unit_key = "excitation." + name_ + ".unit",
          .unit_given = g.unit}},
        {.sample_rate = g.sample_rate, .missing = g.bridge_gaps > 0.0, .interpolate = !(g.bridge_gaps > 0.0)})};
    if (g.bridge_gaps > 0.0) bridge_gaps(prepared, g.bridge_gaps);
    prepare_channels(prepared, g.prepare);
    Record& table = prepared.record;
    if (g.align) prepared.preparation.push_back(align(table, g));
    table.start -= g.delay;
    table.sample_rate *= 1.0 + g.clock_drift;  // its samples are nearer to each other than its clock says
    tell_preparation("excitation '" + name_ + "'", prepared);
    const auto signal = sampled(table, "excitation '" + name_ + "'");
    return integrated({.start = table.start, .step = 1.0 / table.sample_rate, .knots = table.samples()}, signal);
  }

  /// Moves the table to the clock of the record, by a channel that both have. Returns the step in words.
  std::string align(Record& table, const d::FileSignal& g) {
    const CommonDelay found = delay_behind_record(all_.given, g);
    table.start -= found.delay;
    return "its file is " + shortest(std::round(found.delay * 1e6) / 1e6) + " s behind the record by '" +
           g.align->channel.value + "' and sensor '" + g.align->sensor.value + "' (correlation " +
           shortest(std::round(found.correlation * 1e3) / 1e3) + "), which is taken out";
  }
  SignalPtr from(const d::ChannelSignal& g) {
    const auto channel = [&](const d::ChannelSignal& column, const std::string& unit) {
      return sampled(channel_of(column, unit), "channel '" + column.channel.value + "'");
    };
    if (!excitation_.velocity) return channel(g, unit_);
    return with_measured_rate(channel(g, unit_), channel(*excitation_.velocity, unit_ + "/s"));
  }
  SignalPtr from(const d::Clock& /*time*/) { return std::make_shared<const ClockSignal>(); }
  SignalPtr from(const d::Delayed& g) { return after(g.input, g.delay); }
  SignalPtr from(const d::Trailing& g) { return after(g.input, g.wheelbase / g.speed); }
  SignalPtr from(const d::Constant& g) {
    if (is_velocity()) refuse_lasting("a constant velocity");
    const auto signal = make_constant(checked_number(g.value, unit_));
    return integrated({.step = all_.duration, .knots = 2, .drift = Drift::keep}, signal);
  }

  /// The column of a file, by default that of the case's record.
  [[nodiscard]] Record channel_of(const d::ChannelSignal& column, const std::string& unit) const {
    const auto& record = all_.given.record;
    if (!column.file && !record)
      throw InvalidInput(
          column.channel.issue("the case has no record to take the channel '" + column.channel.value + "' from",
                               "a channel without a file is one of the record", "give `record` or `file`"));
    RecordFileOptions options{.sample_rate = column.sample_rate, .missing = column.bridge_gaps > 0.0};
    if (!column.file) options.dataset = record->group;
    if (!column.file && !column.sample_rate) options.sample_rate = record->sample_rate;
    PreparedRecord prepared{read_record_file(column.file ? *column.file : record->file.value,
                                             {{.column = column.channel.value,
                                               .owner = name_,
                                               .unit = unit,
                                               .unit_key = name_ + ".unit",
                                               .unit_given = column.unit}},
                                             options)};
    if (column.bridge_gaps > 0.0) bridge_gaps(prepared, column.bridge_gaps);
    prepare_channels(prepared, column.prepare);
    tell_preparation("channel '" + column.channel.value + "'", prepared);
    return prepared.record;
  }

  /// The signal through the samples of a table, which is told where a spline alone would not do.
  SignalPtr sampled(const Record& table, const std::string& of) const {
    const Eigen::VectorXd samples = table.values.row(0).transpose();
    SignalPtr signal = make_sampled(samples, {.sample_rate = table.sample_rate, .start = table.start});
    if (is_fast(samples))
      all_.notes.preparation.push_back(of + ": " + fast_content(share_above_quarter(samples), table.sample_rate) +
                                       "; interpolated as a band-limited signal" + end_of(*signal, table));
    return signal;
  }

  /// Where the signal is not determined at its end, in words.
  static std::string end_of(const Signal& signal, const Record& table) {
    const double until = signal.determined_until();
    if (!(until < table.end())) return {};
    return fmt::format(
        "; for want of samples behind its end it is not determined from {:.6g} s on, where the filter learns nothing",
        until);
  }

  void tell_preparation(const std::string& of, const PreparedRecord& prepared) const {
    for (const auto& words : prepared.preparation) all_.notes.preparation.push_back(of + ": " + words);
  }

  /// The displacement, if wanted, of an acceleration with frequencies up to `highest` [Hz].
  SignalPtr integrated_from_rest(const SignalPtr& signal, double highest, double duration) {
    const double step = 1.0 / (knots_per_period * highest);
    const auto knots = static_cast<Eigen::Index>(std::ceil(std::max(duration, all_.duration) / step)) + 1;
    return integrated({.step = step, .knots = knots}, signal);
  }

  SignalPtr integrated(IntegrationOptions options, const SignalPtr& signal) {
    if (is_velocity()) return integrated_velocity(signal, {options.start, 1.0 / options.step, options.knots});
    if (!integrated_) return signal;
    if (!excitation_.signal_as<d::Constant>()) options.drift = keeps_drift() ? Drift::keep : Drift::remove;
    const auto motion = std::make_shared<const GroundMotion>(signal, options);
    if (excitation_.signal_as<d::FileSignal>() && motion->removed().part > told_drift) tell(motion->removed());
    return motion;
  }

  /// Tells the user which offset and velocity were removed as errors of the accelerometer.
  void tell(const GroundMotion::Removed& removed) {
    const auto three_digits = [](double value) {
      std::ostringstream text;
      text << std::setprecision(3) << value;
      return text.str();
    };
    all_.notes.remarks.push_back(
        "excitation '" + name_ + "': its acceleration is assumed to have an offset of " + three_digits(removed.offset) +
        " m/s^2, and the ground to start at " + three_digits(-removed.velocity) +
        " m/s; otherwise it would drift; use `drift: keep` to integrate the acceleration as it is");
  }

  SignalPtr after(const Name& input, double delay) {
    const auto earlier = std::ranges::find_if(
        all_.given.excitation, [&](const auto& each) { return each.first == input.value || each.first == name_; });
    if (input.value == name_ || earlier->first != input.value)
      throw InvalidInput(
          input.issue("there is no input '" + input.value + "' above this one", "", "refer to an input listed above"));
    const bool of_law = std::holds_alternative<d::SignalTarget>(excitation_.target);  // takes any input
    if (!of_law && unit_of(earlier->second) != unit_)
      throw InvalidInput(input.issue("input '" + input.value + "' is in " + unit_of(earlier->second),
                                     "this input needs values in " + unit_, "refer to an input of the same kind"));
    if (earlier->second.unknown && !excitation_.unknown)
      throw InvalidInput(input.issue("input '" + input.value + "' is unknown, so its repetition is too",
                                     "the filter cannot delay an input that it estimates",
                                     "make this input unknown as well"));
    return delayed(signal_of(all_, input.value, integrated_), delay);
  }

  MadeSignals& all_;
  const std::string& name_;
  const d::Excitation& excitation_;
  std::string unit_;
  bool integrated_;
};

SignalPtr signal_of(MadeSignals& all, const std::string& name, bool integrated) {
  auto& signal = all.made[{name, integrated}];
  const auto found = std::ranges::find(all.given.excitation, name, &std::pair<std::string, d::Excitation>::first);
  if (!signal) signal = SignalMaker(all, found->first, found->second, integrated).make();
  return signal;
}

SourceLocation place_of(const d::Excitation& excitation) {
  if (const auto* base = std::get_if<d::BaseDisplacement>(&excitation.target)) return base->ground.location;
  if (const auto* base = std::get_if<d::BaseVelocity>(&excitation.target)) return base->ground.location;
  if (const auto* force = std::get_if<d::Force>(&excitation.target)) return force->point.location;
  if (const auto* signal = std::get_if<d::SignalTarget>(&excitation.target)) return signal->ground.location;
  return std::get<d::BaseAcceleration>(excitation.target).direction.location;
}

/// Line of a value of the signal; that of its target if no value keeps its place.
SourceLocation location_of(const d::Case& given, const std::string& name) {
  const auto found = std::ranges::find(given.excitation, name, &std::pair<std::string, d::Excitation>::first);
  const auto& given_signal = found->second.signal;
  const auto place =
      given_signal ? std::visit([](const auto& signal) { return place_of(signal); }, *given_signal) : SourceLocation{};
  return place.file.empty() ? place_of(found->second) : place;
}

}  // namespace

std::vector<SignalPtr> make_signals(const description::Case& given, double duration, IssueList& issues,
                                    SignalNotes& notes) {
  MadeSignals all{given, duration, notes};
  std::vector<SignalPtr> signals;
  for (const auto& [name, excitation] : given.excitation) {
    try {
      signals.push_back(remembered(signal_of(all, name, accelerates_grounds(given, excitation))));
    } catch (const InvalidInput& error) {
      const auto known = location_of(given, name);
      IssueList placed;
      add_at(known.line > 0 ? known : given.source.at({"excitation", name}), error, placed);
      for (const auto& issue : placed.issues()) {
        const bool own_key = name.find('.') != std::string::npos;  // of a component or of a law's signal
        const std::string path = own_key ? name : "excitation." + name;
        const bool named = issue.what.starts_with(path);
        issues.add(issue.location, named ? issue.what : path + ": " + issue.what, issue.why, issue.fix);
      }
    }
  }
  return signals;
}

}  // namespace kalfem
