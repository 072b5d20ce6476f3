#include <map>

#include "kalfem/casefile/assembly.hpp"
#include "kalfem/casefile/bounds.hpp"
#include "kalfem/casefile/record_file.hpp"
#include "kalfem/system/signals/harmonic.hpp"
#include "kalfem/system/signals/pulse.hpp"
#include "kalfem/system/signals/random_signal.hpp"
#include "kalfem/system/signals/road_profile.hpp"
#include "kalfem/system/signals/sampled.hpp"
#include "kalfem/system/signals/smooth_step.hpp"

namespace kalfem {
namespace {

namespace d = description;

/// Makes the signals of one case; signals that follow another need it first.
class SignalMaker {
public:
  SignalMaker(const d::Case& given, double duration) : given_(given), duration_(duration) {}

  SignalPtr make(const std::string& name, InputKind kind) {
    if (const auto made = made_.find(name); made != made_.end()) return made->second;
    for (const auto& [input, excitation] : given_.excitation)
      if (input == name) {
        name_ = name;
        unit_ = unit_of(kind);
        const auto signal = std::visit([&](const auto& each) { return from(each); }, excitation.signal);
        return made_[name] = excitation.scale == 1.0 ? signal : scaled(signal, excitation.scale);
      }
    return {};
  }

  /// Line of a value of the signal, where it has one that keeps its place.
  [[nodiscard]] SourceLocation location(const std::string& name) const {
    for (const auto& [input, excitation] : given_.excitation)
      if (input == name) return std::visit([](const auto& signal) { return place_of(signal); }, excitation.signal);
    return {};
  }

private:
  template <class Signal>
  static SourceLocation place_of(const Signal& signal) {
    if constexpr (requires { signal.rms.location; }) return signal.rms.location;
    if constexpr (requires { signal.amplitude.location; }) return signal.amplitude.location;
    if constexpr (requires { signal.input.location; }) return signal.input.location;
    return {};
  }

  SignalPtr from(const d::RandomSignal& g) {
    return make_random({.rms = checked_number(g.rms, unit_, Bounds::nonnegative()),
                        .lower = g.band[0],
                        .upper = g.band[1],
                        .duration = g.duration.value_or(duration_),
                        .fade_in = g.fade_in,
                        .seed = g.seed,
                        .name = name_});
  }
  SignalPtr from(const d::Sine& g) {
    return make_sine({.amplitude = checked_number(g.amplitude, unit_),
                      .frequency = g.frequency,
                      .phase = g.phase,
                      .fade_in = g.fade_in});
  }
  SignalPtr from(const d::SweptSine& g) {
    return make_swept_sine({.amplitude = checked_number(g.amplitude, unit_),
                            .from = g.from,
                            .to = g.to,
                            .duration = g.duration.value_or(duration_),
                            .sweep = g.kind,
                            .fade_in = g.fade_in});
  }
  SignalPtr from(const d::Impulse& g) {
    return make_pulse(
        {.amplitude = checked_number(g.amplitude, unit_), .start = g.start, .duration = g.duration, .shape = g.shape});
  }
  SignalPtr from(const d::Road& g) {
    return make_road_profile({.road_class = g.road_class,
                              .speed = g.speed,
                              .lower = g.band[0],
                              .upper = g.band[1],
                              .duration = g.duration.value_or(duration_),
                              .fade_in = g.fade_in,
                              .seed = g.seed,
                              .name = name_});
  }
  SignalPtr from(const d::FileSignal& g) {
    const TimeSeries table = read_record_file(g.file, {g.channel}, g.sample_rate, "");
    const double factor = g.unit.empty() ? 1.0 : to_si("1 " + g.unit, unit_);
    return make_sampled(factor * table.values.col(0), {.sample_rate = table.sample_rate, .start = table.start});
  }
  SignalPtr from(const d::Delayed& g) { return after(g.input, g.delay); }
  SignalPtr from(const d::Trailing& g) { return after(g.input, g.wheelbase / g.speed); }
  SignalPtr from(const d::Constant& g) { return make_constant(checked_number(g.value, unit_)); }

  SignalPtr after(const d::Name& input, double delay) {
    const auto made = made_.find(input.value);
    if (made == made_.end())
      throw InvalidInput(
          input.issue("there is no input '" + input.value + "' before this one", "", "name an input above"));
    return delayed(made->second, delay);
  }

  const d::Case& given_;
  double duration_;
  std::map<std::string, SignalPtr> made_;
  std::string name_, unit_;
};

}  // namespace

std::vector<SignalPtr> make_signals(const description::Case& given, const std::vector<InputDescription>& inputs,
                                    double duration, IssueList& issues) {
  SignalMaker maker(given, duration);
  std::vector<SignalPtr> signals;
  for (const auto& input : inputs) {
    try {
      signals.push_back(maker.make(input.name, input.kind));
    } catch (const InvalidInput& error) {
      const auto known = maker.location(input.name);
      IssueList placed;
      add_at(known.line > 0 ? known : given.source.at({"excitation", input.name}), error, placed);
      for (const auto& issue : placed.issues()) {
        const std::string path = "excitation." + input.name;
        const bool named = issue.what.starts_with(path);
        issues.add(issue.location, named ? issue.what : path + ": " + issue.what, issue.why, issue.fix);
      }
    }
  }
  return signals;
}

}  // namespace kalfem
